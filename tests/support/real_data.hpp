#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>

namespace rivid::test {

/// Skips its tests, visibly, where the log of the real robot is not at hand (CMake variable RIVID_REAL_DATA):
///
///   struct Emps : rivid::test::RealData {
///     Emps() : RealData("emps") {}
///   };
///   TEST_F(Emps, GivesThePublishedDigits) { const Log log = read_csv(path("emps_ident.csv")); … }
///
/// The program's line in CMake carries the label: rivid_test(real/emps_test real).
class RealData : public ::testing::Test {
 protected:
  explicit RealData(std::string robot) : robot_(std::move(robot)) {}

  void SetUp() override {
    const std::filesystem::path root = RIVID_REAL_DATA;
    if (root.empty()) {
      GTEST_SKIP() << "RIVID_REAL_DATA is not set";
    }
    if (!std::filesystem::is_directory(root / robot_)) {
      GTEST_SKIP() << "RIVID_REAL_DATA has no folder " << root / robot_;
    }
  }

  /// A file in the robot's folder.
  [[nodiscard]] std::string path(const std::string& file) const {
    return (std::filesystem::path(RIVID_REAL_DATA) / robot_ / file).string();
  }

 private:
  std::string robot_;
};

}  // namespace rivid::test
