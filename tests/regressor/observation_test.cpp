#include <gtest/gtest.h>

#include <cmath>

#include "rivid/regressor/batch.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// Same formula in another order: entries below 100, sums of a few terms.
constexpr double rounding = 64.0 * 2.3e-16 * 100.0;

// The eight columns of section 4.1 of [RIV], (52), with MX2 and MY2 in place of L MX2 and L MY2.
Matrix closed_form(const Motion& m) {
  constexpr double L = 0.5;
  Matrix W = Matrix::Zero(2 * m.samples(), 8);
  for (Index k = 0; k < m.samples(); ++k) {
    const double c = std::cos(m.q(k, 1));
    const double s = std::sin(m.q(k, 1));
    const double d1 = m.qd(k, 0);
    const double d2 = m.qd(k, 1);
    const double dd1 = m.qdd(k, 0);
    const double dd2 = m.qdd(k, 1);
    W.row(k) << dd1, d1, sign(d1), dd1 + dd2, L * ((2 * dd1 + dd2) * c - d2 * (2 * d1 + d2) * s),
        L * (-(2 * dd1 + dd2) * s - d2 * (2 * d1 + d2) * c), 0, 0;
    W.row(m.samples() + k) << 0, 0, 0, dd1 + dd2, L * (dd1 * c + d1 * d1 * s), L * (d1 * d1 * c - dd1 * s),
        d2, sign(d2);
  }
  return W;
}

TEST(Observation, OfTheScaraIsTheClosedFormOfThePaper) {
  std::mt19937_64 random(1);
  const Motion motion = test::random_motion(200, 2, random);
  const Robot robot = test::scara();
  const Matrix W = observation(robot, base_parameters(robot), motion).dense();
  EXPECT_LT((W - closed_form(motion)).cwiseAbs().maxCoeff(), rounding);
}

TEST(Observation, OfAJointHoldsOnlyTheColumnsItCanFeel) {
  const Robot robot = test::scara();
  std::mt19937_64 random(2);
  const Observation W = observation(robot, base_parameters(robot), test::random_motion(5, 2, random));
  EXPECT_EQ(W.joints[0].columns, (std::vector<Index>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(W.joints[1].columns, (std::vector<Index>{3, 4, 5, 6, 7}));
}

TEST(Observation, AtRestHoldsGravityAlone) {
  Robot robot = test::slider();
  robot.chain.gravity = {-9.81, 0.0, 0.0};  // against the direction of motion
  const Motion rest{Matrix::Zero(1, 1), Matrix::Zero(1, 1), Matrix::Zero(1, 1)};
  const Matrix W = observation(robot, base_parameters(robot), rest).dense();
  EXPECT_DOUBLE_EQ(W(0, 0), 9.81);
  EXPECT_EQ(W(0, 1), 0.0);
  EXPECT_EQ(W(0, 2), 0.0);
  EXPECT_EQ(W(0, 3), 1.0);
}

TEST(Observation, RefusesAMotionOfAnotherRobot) {
  const Robot robot = test::scara();
  std::mt19937_64 random(3);
  EXPECT_EQ(test::complaint_of([&] {
              return observation(robot, base_parameters(robot), test::random_motion(4, 3, random));
            }),
            "observation: q is (4 x 3), qd (4 x 3), qdd (4 x 3); each must have one column for each of the "
            "robot's 2 joints and the same number of rows");
}

}  // namespace
}  // namespace rivid
