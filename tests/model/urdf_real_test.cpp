#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "rivid/model/mdh.hpp"
#include "rivid/model/urdf.hpp"
#include "support/chain_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/real_data.hpp"

namespace rivid {
namespace {

// Both kinds of file print angles like 1.57079632679, which is 5e-12 rad off.
constexpr double printed_digits = 1e-9;

std::vector<std::filesystem::path> files_ending(const std::string& end) {
  std::vector<std::filesystem::path> out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(RIVID_REAL_DATA)) {
    if (entry.path().string().ends_with(end)) {
      out.push_back(entry.path());
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<MdhRow> mdh_table(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<MdhRow> table;
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, "joint,type,alpha_prev_rad,a_prev_m,d_m,theta_offset_rad");
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream in(line);
    int number = 0;
    char type = ' ';
    MdhRow row;
    in >> number >> type >> row.alpha >> row.a >> row.d >> row.theta;
    EXPECT_TRUE(in) << path << ": " << line;
    row.type = type == 'P' ? JointType::prismatic : JointType::revolute;
    table.push_back(row);
  }
  return table;
}

// What two tables of the same arm share, wherever base and link frames were put along the axes: the angles
// between the joint axes and their moments about each other, at any position.
void expect_same_axes(const Chain& a, const Chain& b, const Vector& q) {
  const std::vector<test::Screw> A = test::screws(a, q);
  const std::vector<test::Screw> B = test::screws(b, q);
  for (std::size_t i = 0; i < A.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_NEAR(A[i].w.dot(A[j].w), B[i].w.dot(B[j].w), printed_digits) << "joints " << j << ' ' << i;
      EXPECT_NEAR(A[i].v.dot(A[j].w) + A[i].w.dot(A[j].v), B[i].v.dot(B[j].w) + B[i].w.dot(B[j].v),
                  printed_digits)
          << "joints " << j << ' ' << i;
    }
  }
}

struct RealModels : test::RealData {
  RealModels() : RealData("models") {}
};

TEST_F(RealModels, AreReadWithoutComplaint) {
  const auto files = files_ending(".urdf");
  EXPECT_GE(files.size(), 9U);
  for (const auto& path : files) {
    SCOPED_TRACE(path);
    if (path.stem().string().ends_with("_as_published")) {  // kept with the faults that it was published with
      EXPECT_TRUE(test::says(test::complaint_of([&] { return read_urdf(path); }), path.string()));
      continue;
    }
    const Robot robot = read_urdf(path);
    EXPECT_EQ(robot.complaint(), std::nullopt);
    EXPECT_GT(robot.chi_st().norm(), 0.0);
    for (const Finding& warning : robot.warnings) {
      // What is true of makers' own files.
      EXPECT_TRUE(test::says(warning.text, "its inertia is physically inconsistent") ||
                  test::says(warning.text, "<transmission> is ignored") ||
                  test::says(warning.text, "; taken as unlimited") ||
                  test::says(warning.text, "since the base stands still"))
          << warning.text;
    }
  }
}

TEST_F(RealModels, HaveTheAxesOfTheirDenavitHartenbergTables) {
  const auto tables = files_ending("mdh.csv");
  EXPECT_GE(tables.size(), 8U);
  for (const auto& path : tables) {
    SCOPED_TRACE(path);
    std::string urdf = path.filename().string();
    urdf.erase(urdf.find("mdh.csv"));
    std::filesystem::path model;
    for (const auto& candidate : files_ending(".urdf")) {
      const bool same_robot = urdf.empty() || candidate.stem().string() + "_" == urdf;
      if (candidate.parent_path() == path.parent_path() && same_robot) {
        model = candidate;
      }
    }
    const Robot told = read_urdf(model);
    const Robot table = robot_from(mdh_table(path));
    ASSERT_EQ(told.size(), table.size());
    constexpr std::uint64_t seed = 20240;
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> position(-3.0, 3.0);
    for (int sample = 0; sample < 20; ++sample) {
      Vector q(told.size());
      for (double& value : q) {
        value = position(random);
      }
      expect_same_axes(told.chain, table.chain, q);
    }
  }
}

}  // namespace
}  // namespace rivid
