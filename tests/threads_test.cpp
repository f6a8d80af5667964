// Threads: what is asked for, within what the machine has and the system gives.

#include "threads.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace rivid::detail {
namespace {

TEST(Threads, AreAtMostFourAProcessor) {
  const int processors = std::max(static_cast<int>(std::thread::hardware_concurrency()), 1);
  EXPECT_EQ(useful_threads(std::numeric_limits<int>::max()), 4 * processors);
  EXPECT_EQ(useful_threads(4 * processors), 4 * processors);
  EXPECT_EQ(useful_threads(2), 2);
}

TEST(Threads, AreAtLeastOne) {
  EXPECT_EQ(useful_threads(0), 1);
  EXPECT_EQ(useful_threads(std::numeric_limits<int>::min()), 1);
}

// As std::thread where the system gives no more.
struct Refused {
  explicit Refused(int /*unused*/) {
    throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
  }
};

TEST(Threads, ThatTheSystemDoesNotGiveAreNotStarted) {
  std::vector<Refused> none;
  EXPECT_FALSE(started(none, 1));
  EXPECT_TRUE(none.empty());
  std::vector<std::jthread> one;
  EXPECT_TRUE(started(one, [] {}));
  EXPECT_EQ(one.size(), 1U);
}

}  // namespace
}  // namespace rivid::detail
