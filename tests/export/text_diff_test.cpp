#include <gtest/gtest.h>

#include <cstdio>
#include <random>
#include <sstream>
#include <string>

#include "rivid/export/urdf.hpp"

namespace rivid {
namespace {

TEST(UnifiedDiff, IsEmptyForEqualTexts) { EXPECT_EQ(unified_diff("a\nb\n", "a\nb\n", "x", "y"), ""); }

// As diff -u of GNU diffutils 3.8 prints it, less the times.
TEST(UnifiedDiff, PrintsWhatDiffPrints) {
  const std::string before = "1\n2\n3\n4\n5\n6\n7\n8\n9\n10\n11\n12\n13\n14\n";
  const std::string after = "1\n2\n3\n4\nfive\n6\n7\n8\n9\n10\n11\n12\n12.5\n13\n14";
  EXPECT_EQ(unified_diff(before, after, "a", "b"),
            "--- a\n+++ b\n@@ -2,7 +2,7 @@\n 2\n 3\n 4\n-5\n+five\n 6\n 7\n 8\n"
            "@@ -10,5 +10,6 @@\n 10\n 11\n 12\n+12.5\n 13\n-14\n+14\n\\ No newline at end of file\n");
  EXPECT_EQ(unified_diff("", "new\n", "a", "b"), "--- a\n+++ b\n@@ -0,0 +1 @@\n+new\n");
}

// Applies the hunks to `before`, checking the lines that they name.
std::string patched(const std::string& before, const std::string& diff) {
  std::istringstream in(diff);
  std::istringstream old(before);
  std::string line, expected, out;
  std::getline(in, line);
  std::getline(in, line);
  long at = 0;
  while (std::getline(in, line)) {
    if (line.starts_with("@@")) {
      long first = 0;
      long count = 1;
      const int read = std::sscanf(line.c_str(), "@@ -%ld,%ld", &first, &count);
      EXPECT_GE(read, 1) << line;
      const long until = count == 0 ? first : first - 1;
      for (; at < until; ++at) {
        std::getline(old, expected);
        out += expected + '\n';
      }
      continue;
    }
    if (line[0] != '+') {
      std::getline(old, expected);
      EXPECT_EQ(line.substr(1), expected);
      ++at;
    }
    out += line[0] == '-' ? "" : line.substr(1) + '\n';
  }
  while (std::getline(old, expected)) {
    out += expected + '\n';
  }
  return out;
}

TEST(UnifiedDiff, TurnsOneTextIntoTheOther) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    std::uniform_int_distribution<int> word(0, 5);
    std::uniform_int_distribution<int> choice(0, 9);
    std::string before;
    std::string after;
    for (int i = 0; i < 60; ++i) {
      const std::string line = std::to_string(word(random)) + '\n';
      const int kind = choice(random);
      before += kind == 0 ? "" : line;
      after += kind == 1 ? "" : kind == 2 ? "changed\n" : line;
    }
    const std::string diff = unified_diff(before, after, "a", "b");
    if (before != after) {
      EXPECT_EQ(patched(before, diff), after) << diff;
    }
  }
}

}  // namespace
}  // namespace rivid
