#include "experiment/json_node.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

#include "support/complaint.hpp"

namespace rivid::detail {
namespace {

template <typename Integer>
Integer read(const char* text) {
  const nlohmann::json json = nlohmann::json::parse(text);
  Integer out = 0;
  JsonNode(json, "a.json", "count").read(out);
  return out;
}

TEST(JsonNode, ReadsWholeNumbersThatTheirTypeHolds) {
  EXPECT_EQ(read<int>("-2147483648"), std::numeric_limits<int>::min());
  EXPECT_EQ(read<int>("2147483647.0"), std::numeric_limits<int>::max());
  EXPECT_EQ(read<std::int64_t>("1000000000000000"), 1'000'000'000'000'000);
  EXPECT_EQ(test::complaint_of([] { return read<int>("0.5"); }), "a.json: count must be a whole number");
  EXPECT_EQ(test::complaint_of([] { return read<int>("3e9"); }),
            "a.json: count is 3000000000, must be between -2147483648 and 2147483647");
  EXPECT_EQ(test::complaint_of([] { return read<std::uint64_t>("-1"); }),
            "a.json: count is -1, must be between 0 and 1e+15");
  EXPECT_EQ(test::complaint_of([] { return read<std::int64_t>("1e16"); }),
            "a.json: count is 1e+16, must be between -1e+15 and 1e+15");
}

}  // namespace
}  // namespace rivid::detail
