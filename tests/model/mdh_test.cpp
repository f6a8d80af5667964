#include "rivid/model/mdh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "support/chain_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr double same_quantity = 1e-12;

// The definition, written out as four motions.
Eigen::Isometry3d by_definition(const MdhRow& row, double q) {
  const bool revolute = row.type == JointType::revolute;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.rotate(Eigen::AngleAxisd(row.alpha, Eigen::Vector3d::UnitX()));
  T.translate(row.a * Eigen::Vector3d::UnitX());
  T.rotate(Eigen::AngleAxisd(row.theta + (revolute ? q : 0.0), Eigen::Vector3d::UnitZ()));
  T.translate((row.d + (revolute ? 0.0 : q)) * Eigen::Vector3d::UnitZ());
  return T;
}

TEST(RobotFromMdh, PlacesFramesByRotXTransXRotZTransZ) {
  const std::vector<MdhRow> table = {
      {.type = JointType::revolute, .alpha = 0.3, .a = 0.1, .d = 0.2, .theta = -0.4, .name = {}},
      {.type = JointType::prismatic, .alpha = -1.2, .a = -0.3, .d = 0.5, .theta = 0.7, .name = {}},
      {.type = JointType::revolute,
       .alpha = std::numbers::pi / 2,
       .a = 0.0,
       .d = 0.6,
       .theta = 2.0,
       .name = {}}};
  const Robot robot = robot_from(table);
  const Vector q = Eigen::Vector3d(0.9, -0.8, 1.7);
  const auto frames = test::forward_kinematics(robot.chain, q);
  Eigen::Isometry3d wanted = Eigen::Isometry3d::Identity();
  for (std::size_t j = 0; j < table.size(); ++j) {
    wanted = wanted * by_definition(table[j], q[static_cast<Index>(j)]);
    EXPECT_LE((frames[j].matrix() - wanted.matrix()).norm(), same_quantity) << "frame " << j + 1;
  }
}

TEST(RobotFromMdh, NamesJointsAndKnowsNoInertials) {
  const std::vector<MdhRow> table = {{.name = "waist"}, {.type = JointType::prismatic, .name = {}}};
  const Robot robot = robot_from(table, {0.0, -9.81, 0.0});
  EXPECT_EQ(robot.joints[0].name, "waist");
  EXPECT_EQ(robot.joints[1].name, "joint_2");
  EXPECT_EQ(robot.joints[1].link, "link_2");
  EXPECT_EQ(robot.joints[1].type, JointType::prismatic);
  EXPECT_TRUE(robot.chi_st().isZero(0.0));
  EXPECT_EQ(robot.chain.gravity.y(), -9.81);
}

TEST(RobotFromMdh, RefusesAnEmptyTableAndWhatIsNotFinite) {
  const auto refusal = [](const std::vector<MdhRow>& table) -> std::string {
    return test::complaint_of([&] { return robot_from(table); });
  };
  EXPECT_EQ(refusal({}), "robot_from(MDH): the robot has no moving joint");
  EXPECT_EQ(refusal({{.a = std::numeric_limits<double>::infinity(), .name = "waist"}}),
            "robot_from(MDH): joint \"waist\": its frame is not finite");
}

TEST(Robot, RefusesFramesAxesAndValuesThatAreNone) {
  struct Case {
    void (*spoil)(Robot&);
    const char* words;
  };
  for (const auto& [spoil, words] :
       {Case{[](Robot& r) { r.chain.links[1].R *= 2.0; }, "R of its frame must be a rotation"},
        Case{[](Robot& r) { r.chain.links[1].R(2, 2) = -1.0; }, "R of its frame must be a rotation"},
        Case{[](Robot& r) { r.chain.links[1].axes = {0, 7, 2}; }, "axes of its link are 0, 7, 2"},
        Case{[](Robot& r) { r.chain.links[1].signs = {1, 0, 1}; }, "signs of its link are 1, 0, 1"},
        Case{[](Robot& r) { r.joints[1].friction = static_cast<Friction>(99); }, "none of Friction"},
        Case{[](Robot& r) { r.joints[1].max_effort = std::nan(""); }, "is nan; infinity is no limit"}}) {
    Robot robot = test::scara();
    EXPECT_EQ(robot.complaint(), std::nullopt);
    spoil(robot);
    EXPECT_TRUE(test::says(robot.complaint().value_or(""), "joint \"joint_2\": "));
    EXPECT_TRUE(test::says(robot.complaint().value_or(""), words));
  }
}

}  // namespace
}  // namespace rivid
