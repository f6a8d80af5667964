#pragma once

#include <algorithm>
#include <array>
#include <ctime>
#include <functional>
#include <vector>

namespace rivid::benchmarks {

enum class Clock {
  wall,
  processor,  ///< of the calling thread: what others do on a busy machine counts less
  process     ///< the same of all threads
};

inline double now(Clock clock) {
  timespec time{};
  clock_gettime(clock == Clock::wall        ? CLOCK_MONOTONIC
                : clock == Clock::processor ? CLOCK_THREAD_CPUTIME_ID
                                            : CLOCK_PROCESS_CPUTIME_ID,
                &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Seconds that each of several runs took in each of several turns, sorted. They take turns, so that all meet
/// the same disturbances of a busy machine.
template <std::size_t N>
std::array<std::vector<double>, N> turns(int count, const std::array<std::function<void()>, N>& runs,
                                         Clock clock = Clock::wall) {
  std::array<std::vector<double>, N> out;
  for (int turn = 0; turn < count; ++turn) {
    for (std::size_t i = 0; i < N; ++i) {
      const double start = now(clock);
      runs[i]();
      out[i].push_back(now(clock) - start);
    }
  }
  for (std::vector<double>& seconds : out) {
    std::ranges::sort(seconds);
  }
  return out;
}

inline double median(const std::vector<double>& sorted) { return sorted[sorted.size() / 2]; }

}  // namespace rivid::benchmarks
