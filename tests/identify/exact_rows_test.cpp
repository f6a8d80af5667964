#include "identify/rows/exact_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "rivid/identify/rows.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

using detail::average_torque;
using detail::averaged_motion;
using detail::motion_masks;
using detail::MotionMask;
using detail::window_centres;

constexpr double f_m = 200.0;

// Joint 1 swings, joint 2 stands still, encoders with noise.
Matrix swing(Index samples, double noise) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  return Matrix::NullaryExpr(samples, 2, [&](Index k, Index j) {
    return (j == 0 ? std::sin(2.0 * static_cast<double>(k) / f_m) : 0.3) + noise * normal(random);
  });
}

// A mass under a torque that is held from sample to sample moves in parabolas; its acceleration, as two
// central differences see it, is the averaged torque, to rounding.
TEST(ExactRows, AveragedTorqueIsTheAccelerationUnderAZeroOrderHold) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const double h = 1.0 / f_m;
  const Matrix tau = Matrix::NullaryExpr(60, 1, [&] { return normal(random); });
  Matrix q(60, 1);
  double x = 0.2;
  double v = -0.4;
  for (Index k = 0; k < 60; ++k) {
    q(k, 0) = x;
    x += h * v + 0.5 * h * h * tau(k, 0);
    v += h * tau(k, 0);
  }
  Matrix mean = tau;
  average_torque(mean, true);
  const Motion motion = averaged_motion(q, f_m);
  // Second differences lose digits by h².
  constexpr double rounding = 1e-15 * 4.0 * f_m * f_m;
  for (Index k = 2; k < 58; ++k) {
    EXPECT_NEAR(motion.qdd(k, 0), mean(k, 0), rounding);
  }
}

// Averages over one triangle: of a sine each is its value times the same number, to fourth order.
TEST(ExactRows, PositionVelocityAccelerationAndTorqueAreAveragedAlike) {
  constexpr double omega = 20.0;
  Matrix q(40, 1);
  Matrix tau(40, 1);
  for (Index k = 0; k < 40; ++k) {
    const double phase = omega * static_cast<double>(k) / f_m + 0.3;
    q(k, 0) = std::sin(phase);
    tau(k, 0) = std::cos(phase);
  }
  const Motion motion = averaged_motion(q, f_m);
  Matrix mean = tau;
  average_torque(mean, false);
  const double fourth_order = std::pow(omega / f_m, 4.0);
  for (Index k = 3; k < 37; ++k) {
    const double phase = omega * static_cast<double>(k) / f_m + 0.3;
    const double by = 1.0 - std::pow(omega / f_m, 2.0) / 3.0;
    EXPECT_NEAR(motion.q(k, 0), by * std::sin(phase), fourth_order);
    EXPECT_NEAR(motion.qd(k, 0), by * omega * std::cos(phase), omega * fourth_order);
    EXPECT_NEAR(motion.qdd(k, 0), -by * omega * omega * std::sin(phase), omega * omega * fourth_order);
    EXPECT_NEAR(mean(k, 0), by * std::cos(phase), fourth_order);
  }
}

TEST(ExactRows, LeaveOutReversalsAndStandstill) {
  const Robot robot = test::scara();
  const Matrix q = swing(2000, 1e-5);
  const std::vector<MotionMask> masks = motion_masks(robot, q, q, f_m, {});
  // Four standard deviations of a central difference, from an estimate of the noise.
  const double noise = 1e-5 * f_m * std::sqrt(0.5);
  EXPECT_NEAR(masks[0].threshold, 4.0 * noise, 0.1 * 4.0 * noise);
  for (Index k = 0; k < 2000; ++k) {
    const double velocity = 2.0 * std::cos(2.0 * static_cast<double>(k) / f_m);
    const bool moving = masks[0].direction[static_cast<std::size_t>(k)] != 0;
    // q̈ reaches 4 rad/s²: within two samples of a reversal the velocity stays below 0.04 rad/s.
    if (std::abs(velocity) > 0.1) {
      EXPECT_TRUE(moving) << k;
    }
    if (std::abs(velocity) < masks[0].threshold) {
      EXPECT_FALSE(moving) << k;
    }
    EXPECT_FALSE(masks[1].direction[static_cast<std::size_t>(k)]) << k;
  }
}

TEST(ExactRows, AMotorOfSeveralJointsReversesWithTheirSum) {
  Robot robot = test::scara();
  robot.couplings = {{.motor = 1, .joints = {0}, .ratios = {1.0}}};
  Matrix q(1000, 2);
  for (Index k = 0; k < 1000; ++k) {
    const double t = static_cast<double>(k) / f_m;
    // Neither joint reverses within the first second, their sum does at 0.5 s.
    q.row(k) << t, -t * t;
  }
  const std::vector<MotionMask> masks = motion_masks(robot, q, q, f_m, {});
  EXPECT_FALSE(masks[0].direction[100]);
  EXPECT_FALSE(masks[1].direction[100]);
  EXPECT_TRUE(masks[0].direction[50]);
  EXPECT_TRUE(masks[1].direction[150]);
}

TEST(ExactRows, WindowsLieWithinStretchesOfMotion) {
  MotionMask mask;
  mask.direction.assign(100, 1);
  mask.direction[30] = 0;
  for (std::size_t k = 60; k < 80; ++k) {
    mask.direction[k] = 0;
  }
  EXPECT_EQ(window_centres(mask, 0, 100, 10), (std::vector<Index>{9, 19, 40, 50, 89}));
  EXPECT_EQ(window_centres(mask, 5, 60, 10), (std::vector<Index>{9, 35, 45}));
  EXPECT_EQ(window_centres(mask, 0, 10, 10), std::vector<Index>{});
}

TEST(ExactRows, AJointThatStandsStillHasNone) {
  const Robot robot = test::scara();
  Log log;
  log.source = "swing.csv";
  log.f_m = f_m;
  log.q = swing(2000, 1e-6);
  log.t = Vector::LinSpaced(2000, 0.0, 1999.0 / f_m);
  log.tau = log.q;
  const Rows found = rows(robot, base_parameters(robot), log, {.decimation = {10}});
  EXPECT_GT(found.Y[0].size(), 100);
  EXPECT_EQ(found.Y[1].size(), 0);
  log.q.col(0).setConstant(1.0);
  EXPECT_TRUE(test::says(test::complaint_of([&] { return rows(robot, base_parameters(robot), log, {}); }),
                         "swing.csv: no joint moves for long enough"));
}

}  // namespace
}  // namespace rivid
