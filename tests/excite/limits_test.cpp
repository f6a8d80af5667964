// Limits of motions: where they come from, and what is said where they are missing.

#include "rivid/excite/limits.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "rivid/error.hpp"
#include "rivid/model/urdf.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

Robot arm() { return read_urdf(RIVID_DATA "/six_axis/six_axis.urdf"); }

std::string message(const Robot& robot, const MotionLimits& limits) {
  try {
    (void)motion_bounds(robot, limits);
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

TEST(MotionBounds, AreSharesOfTheRobotsLimits) {
  const MotionBounds bounds =
      motion_bounds(arm(), {.position_share = 0.5, .velocity_share = 0.25, .torque_share = 0.1});
  EXPECT_NEAR(bounds.upper[0], 0.5 * 3.1416, 1e-12);
  EXPECT_NEAR(bounds.lower[0], -0.5 * 3.1416, 1e-12);
  EXPECT_NEAR(bounds.velocity[0], 0.25 * 5.0091, 1e-12);
  EXPECT_NEAR(bounds.torque[0], 10.0, 1e-12);
  EXPECT_TRUE(std::isinf(bounds.acceleration[0]));
  EXPECT_FALSE(missing_limit(arm(), bounds));
}

TEST(MotionBounds, TakeWhatIsSaidInPlaceOfTheRobots) {
  MotionLimits limits{.position_share = 1.0};
  limits.lower = Vector::Constant(6, -0.1);
  limits.upper = Vector::Constant(6, 0.3);
  limits.acceleration = Vector::Constant(6, 2.0);
  const MotionBounds bounds = motion_bounds(arm(), limits);
  EXPECT_NEAR(bounds.lower[3], -0.1, 1e-15);
  EXPECT_NEAR(bounds.upper[3], 0.3, 1e-15);
  EXPECT_EQ(bounds.acceleration[3], 2.0);
}

TEST(MotionBounds, KeepAJointWithoutLimitsWithinOneTurn) {
  Robot robot = arm();
  robot.joints[2].lower = -std::numeric_limits<double>::infinity();
  const MotionBounds bounds = motion_bounds(robot, {.position_share = 1.0});
  EXPECT_NEAR(bounds.lower[2], -std::numbers::pi, 1e-15);
  EXPECT_NEAR(bounds.upper[2], robot.joints[2].upper, 1e-15);
  ASSERT_EQ(bounds.findings.size(), 1U);
  EXPECT_EQ(bounds.findings.front().code, "limit_assumed");
  EXPECT_EQ(bounds.findings.front().subject, "joint_3");
}

TEST(MotionBounds, KeepTheOneSideThatIsGiven) {
  Robot robot = arm();
  for (Joint& joint : robot.joints) {
    joint.lower = -std::numeric_limits<double>::infinity();
    joint.upper = std::numeric_limits<double>::infinity();
  }
  const MotionBounds bounds =
      motion_bounds(robot, {.lower = Vector::Constant(6, -0.2), .position_share = 1.0});
  EXPECT_NEAR(bounds.lower[0], -0.2, 1e-15);
  EXPECT_NEAR(bounds.upper[0], std::numbers::pi, 1e-15);
  EXPECT_EQ(in_words(bounds.findings.front()),
            "note [limit_assumed] joint_1: has no upper position limit; the motion is kept below π");
}

TEST(MotionBounds, TakeWhatNoRobotReachesForNoLimit) {
  Robot robot = arm();
  robot.joints[2].lower = -1e16;
  const MotionBounds bounds = motion_bounds(robot, {.position_share = 1.0});
  EXPECT_NEAR(bounds.lower[2], -std::numbers::pi, 1e-15);
  ASSERT_FALSE(bounds.findings.empty());
  EXPECT_EQ(bounds.findings.front().subject, "joint_3");
  robot = test::slider();
  robot.joints[0].lower = -1e16;
  robot.joints[0].upper = 1e16;
  EXPECT_EQ(*missing_limit(robot, motion_bounds(robot, {})),
            "joint_1: has no position limits; give lower and upper in [excitation.limits]");
}

TEST(MotionBounds, NameWhatIsMissing) {
  Robot robot = arm();
  robot.joints[1].max_velocity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(*missing_limit(robot, motion_bounds(robot, {})),
            "joint_2: has no velocity limit; give velocity in [excitation.limits]");
  robot = arm();
  robot.joints[4].max_effort = std::numeric_limits<double>::infinity();
  EXPECT_EQ(*missing_limit(robot, motion_bounds(robot, {})),
            "joint_5: neither its acceleration nor its torque is limited; give acceleration in "
            "[excitation.limits]");
  robot = test::slider();
  EXPECT_EQ(*missing_limit(robot, motion_bounds(robot, {})),
            "joint_1: has no position limits; give lower and upper in [excitation.limits]");
}

TEST(MotionBounds, KnowNoTorquesWithoutMasses) {
  Robot robot = arm();
  robot.inertials.assign(6, Inertial::Zero());
  const MotionBounds bounds = motion_bounds(robot, {});
  EXPECT_TRUE(std::isinf(bounds.torque[0]));
  ASSERT_FALSE(bounds.findings.empty());
  EXPECT_EQ(bounds.findings.front().code, "no_torque_model");
  EXPECT_TRUE(missing_limit(robot, bounds));
}

TEST(MotionBounds, DoubtPlaceholders) {
  Robot robot = arm();
  for (Joint& joint : robot.joints) {
    joint.max_effort = 10000.0;
  }
  const std::vector<Finding> findings = motion_bounds(robot, {}).findings;
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(in_words(findings.front()),
            "warning [limit_doubt] six_axis: the torque limit is 10000 for all joints, which looks like a "
            "placeholder");
}

TEST(MotionBounds, RefuseWhatLeavesNoRoom) {
  MotionLimits limits;
  limits.lower = Vector::Constant(6, 1.0);
  limits.upper = Vector::Constant(6, 1.0);
  EXPECT_EQ(
      message(arm(), limits),
      "motion_bounds: joint_1: positions from 1 to 1 rad leave no room to move; correct lower and upper "
      "in [excitation.limits] or the robot");
  EXPECT_EQ(message(arm(), {.velocity = Vector::Constant(2, 1.0)}),
            "motion_bounds: velocity has 2 entries, must have one for each of the 6 joints");
  EXPECT_EQ(message(arm(), {.lower = Vector::Constant(6, std::numeric_limits<double>::quiet_NaN())}),
            "motion_bounds: lower of joint 1 is nan, must be a number, or -inf where there is no limit");
  EXPECT_EQ(message(arm(), {.upper = Vector::Constant(6, -std::numeric_limits<double>::infinity())}),
            "motion_bounds: upper of joint 1 is -inf, must be a number, or inf where there is no limit");
  EXPECT_EQ(message(arm(), {.torque_share = 1.5}),
            "motion_bounds: torque_share is 1.5, must lie between 0.01 and 1");
}

}  // namespace
}  // namespace rivid
