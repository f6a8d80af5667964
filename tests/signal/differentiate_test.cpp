#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "rivid/error.hpp"
#include "rivid/signal/filter.hpp"
#include "signal/probe.hpp"
#include "support/complaint.hpp"

namespace rivid {
namespace {

constexpr double f_m = 100.0;

// ε times the largest position times f_m (f_m² for the second difference), with room for a few roundings.
constexpr double rounding = 1e-11;

Vector instants(Index n_m) { return Vector::LinSpaced(n_m, 0.0, static_cast<double>(n_m - 1)) / f_m; }

TEST(CentralDifference, IsExactOnAParabola) {
  const Vector t = instants(50);
  const Vector x = (1.0 - 2.0 * t.array() + 3.0 * t.array().square()).matrix();
  const Vector xd = (-2.0 + 6.0 * t.array()).matrix();
  const Matrix got = central_difference(x, f_m);
  EXPECT_LT((got - xd).middleRows(1, 48).cwiseAbs().maxCoeff(), rounding);
}

TEST(CentralDifference, IsOneSidedAtTheEnds) {
  Matrix x(4, 2);
  x << 1.0, 0.0, 3.0, 1.0, 4.0, 5.0, 8.0, 6.0;
  Matrix expected(4, 2);
  expected << 2.0, 1.0, 1.5, 2.5, 2.5, 2.5, 4.0, 1.0;
  EXPECT_EQ(central_difference(x, f_m), Matrix(f_m * expected));
}

TEST(CentralDifference, OfTwoSamplesIsTheirDifference) {
  const Eigen::Vector2d x(1.0, 4.0);
  EXPECT_EQ(central_difference(x, f_m), Matrix(Eigen::Vector2d::Constant(3.0 * f_m)));
}

TEST(CentralDifference, DoesNotShiftATone) {
  const double omega = 2.0 * std::numbers::pi * 5.0;
  const Vector t = instants(200);
  const Vector cosine = (omega * t.array()).cos().matrix();
  const double gain = f_m * std::sin(omega / f_m);
  const Matrix xd = central_difference((omega * t.array()).sin().matrix(), f_m);
  EXPECT_LT((xd - gain * cosine).middleRows(1, 198).cwiseAbs().maxCoeff(), rounding);
}

TEST(CentralDifference, SaysWhatIsWrongWithItsArguments) {
  EXPECT_EQ(test::complaint_of([] { return central_difference(Matrix::Zero(1, 3), f_m); }),
            "central_difference: x has 1 sample, must have at least 2");
  EXPECT_EQ(test::complaint_of([] { return central_difference(Matrix(0, 3), f_m); }),
            "central_difference: x has 0 samples, must have at least 2");
  EXPECT_EQ(test::complaint_of([] { return central_difference(Matrix::Zero(5, 3), -1.0); }),
            "central_difference: f_m is -1 Hz, must be positive and finite");
  EXPECT_EQ(test::complaint_of([] {
              return central_difference(Matrix::Zero(5, 3), std::numeric_limits<double>::quiet_NaN());
            }),
            "central_difference: f_m is nan Hz, must be positive and finite");
}

TEST(Differentiate, KeepsThePositionsAndTakesTheCentralDifferenceTwice) {
  const Matrix q = probe::columns(60, 3);
  const Motion motion = differentiate(q, f_m);
  EXPECT_EQ(motion.q, q);
  EXPECT_EQ(motion.qd, central_difference(q, f_m));
  EXPECT_EQ(motion.qdd, central_difference(motion.qd, f_m));
}

TEST(Differentiate, FindsTheAccelerationOfAParabolaButForTwoSamplesAtEachEnd) {
  const Vector t = instants(50);
  const Motion motion = differentiate((0.5 * 9.81 * t.array().square()).matrix(), f_m);
  EXPECT_LT((motion.qdd.array() - 9.81).middleRows(2, 46).abs().maxCoeff(), f_m * rounding);
}

}  // namespace
}  // namespace rivid
