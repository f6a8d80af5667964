#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>

#include "rivid/export/urdf.hpp"
#include "support/real_data.hpp"
#include "support/temporary_folder.hpp"
#include "support/written_urdf.hpp"

namespace rivid {
namespace {

struct WrittenRealModels : test::RealData {
  WrittenRealModels() : RealData("models") {}
};

TEST_F(WrittenRealModels, ReadBackGiveTheSameTorquesAndChangeNoOtherLine) {
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(RIVID_REAL_DATA)) {
    const std::filesystem::path& path = entry.path();
    if (path.extension() != ".urdf" || path.stem().string().ends_with("_as_published")) {
      continue;
    }
    SCOPED_TRACE(path);
    ++files;
    const std::string before = test::content_of(path);
    const Robot robot = read_urdf(path);
    EXPECT_EQ(rewritten_urdf(path, robot, robot.chi_st()).text, before);
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      std::mt19937_64 random(seed);
      const Vector chi_st = test::random_urdf_parameters(robot, random);
      const RewrittenUrdf written = rewritten_urdf(path, robot, chi_st);
      EXPECT_TRUE(written.faults.empty());
      test::expect_same_torques(written.text, robot, chi_st, random);
      // Of an <inertial> that takes many lines.
      static const std::regex attribute("^- *(xyz|value|i[xyz][xyz])=\"");
      std::istringstream diff(unified_diff(before, written.text, "a", "b"));
      for (std::string line; std::getline(diff, line);) {
        if (line.starts_with("-") && !line.starts_with("---")) {
          const bool numbers =
              line.find("<origin") != std::string::npos || line.find("<mass") != std::string::npos ||
              line.find("<inertia") != std::string::npos || line.find("<dynamics") != std::string::npos ||
              line.ends_with("/>") ||  // a link that gets its first inertial
              std::regex_search(line, attribute);
          EXPECT_TRUE(numbers) << line;
        }
      }
    }
  }
  EXPECT_GE(files, 9);
}

}  // namespace
}  // namespace rivid
