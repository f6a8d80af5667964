// Fourier series and splines that begin and end at rest.

#include "excite/curve.hpp"

#include <gtest/gtest.h>

#include <random>

#include "excite/tasks.hpp"

namespace rivid {
namespace {

constexpr double duration = 12.0;

Vector variables(const detail::Curve& curve) {
  std::mt19937_64 random(42);
  std::normal_distribution<double> normal;
  return Vector::NullaryExpr(curve.variables(), [&] { return normal(random); });
}

struct Ends {
  Vector q{3};
  Vector qd{3};
  Vector qdd{3};
};

Ends at(const FourierReference& reference, double t) {
  Ends out;
  reference.at(t, out.q, out.qd, out.qdd);
  return out;
}

TEST(FourierCurve, BeginsAndEndsAtRest) {
  for (const int harmonics : {2, 5, 12}) {
    const detail::FourierCurve curve(duration, harmonics, test::wide_bounds(3), {});
    const FourierReference reference(curve.series(variables(curve)).value());
    for (const double t : {0.0, duration}) {
      const Ends end = at(reference, t);
      EXPECT_LE(end.qd.cwiseAbs().maxCoeff(), 1e-9);
      EXPECT_LE(end.qdd.cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(FourierCurve, IsTheSeriesThatItTells) {
  const detail::FourierCurve curve(duration, 5, test::wide_bounds(3), {});
  const Vector z = variables(curve);
  const FourierReference reference(curve.series(z).value());
  const Vector t = Vector::LinSpaced(37, 0.0, duration);
  const Motion motion = curve.motion(curve.tables(t), curve.coefficients(z));
  for (Index k = 0; k < t.size(); ++k) {
    const Ends expected = at(reference, t[k]);
    EXPECT_LE((motion.q.row(k).transpose() - expected.q).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE((motion.qd.row(k).transpose() - expected.qd).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE((motion.qdd.row(k).transpose() - expected.qdd).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(FourierCurve, HasTheJerkOfItsAccelerations) {
  const detail::FourierCurve curve(duration, 5, test::wide_bounds(3), {});
  const Matrix c = curve.coefficients(variables(curve));
  constexpr double h = 1e-5;
  for (const double t : {0.3, 5.0, 11.0}) {
    const auto tables = [&](double time) { return curve.tables(Vector::Constant(1, time)); };
    const Matrix difference =
        (curve.motion(tables(t + h), c).qdd - curve.motion(tables(t - h), c).qdd) / (2.0 * h);
    EXPECT_LE((detail::FourierCurve::jerk(tables(t), c) - difference).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST(FourierCurve, BeginsWhereItIsTold) {
  const Vector start = Eigen::Vector3d(0.3, -1.0, 0.7);
  const detail::FourierCurve curve(duration, 5, test::wide_bounds(3), start);
  const FourierReference reference(curve.series(variables(curve)).value());
  for (const double t : {0.0, duration}) {
    const Ends end = at(reference, t);
    EXPECT_LE((end.q - start).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE(end.qd.cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE(end.qdd.cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(FourierCurve, RestsAtAPose) {
  const detail::FourierCurve curve(duration, 5, test::wide_bounds(3), {});
  const Vector pose = Eigen::Vector3d(0.3, -1.0, 0.7);
  const FourierSeries series = curve.series(curve.at_rest(pose)).value();
  EXPECT_LE((series.q0 - pose).norm(), 1e-12);
  EXPECT_EQ(series.A.cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(series.B.cwiseAbs().maxCoeff(), 0.0);
}

// An independent way to the same functions: De Boor's recursion for one value.
double b_spline(const Vector& knots, Index i, int degree, double t) {
  if (degree == 0) {
    return knots[i] <= t && t < knots[i + 1] ? 1.0 : 0.0;
  }
  const auto part = [&](double above, double width, Index k) {
    return width > 0.0 ? above / width * b_spline(knots, k, degree - 1, t) : 0.0;
  };
  return part(t - knots[i], knots[i + degree] - knots[i], i) +
         part(knots[i + degree + 1] - t, knots[i + degree + 1] - knots[i + 1], i + 1);
}

TEST(SplineCurve, IsMadeOfBSplines) {
  const int points = 7;
  const detail::SplineCurve curve(duration, points, test::wide_bounds(1), {});
  const Index intervals = points + 1;
  Vector knots = Vector::Zero(intervals + 11);
  knots.segment(5, intervals + 1).setLinSpaced(0.0, duration);
  knots.tail(5).setConstant(duration);
  const Vector t = Vector::LinSpaced(40, 0.0, duration * 0.999);
  const Matrix table = curve.tables(t).position;
  ASSERT_EQ(table.cols(), points + 6);
  for (Index k = 0; k < t.size(); ++k) {
    for (Index i = 0; i < table.cols(); ++i) {
      EXPECT_NEAR(table(k, i), b_spline(knots, i, 5, t[k]), 1e-13);
    }
  }
}

TEST(SplineCurve, BeginsAndEndsAtRestInOnePose) {
  const Vector start = Vector::LinSpaced(3, -0.3, 0.5);
  for (const Vector& given : {Vector(), start}) {
    const detail::SplineCurve curve(duration, 6, test::wide_bounds(3), given);
    const Motion motion =
        curve.motion(curve.tables(Vector::LinSpaced(2, 0.0, duration)), curve.coefficients(variables(curve)));
    EXPECT_LE(motion.qd.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LE(motion.qdd.cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_LE((motion.q.row(0) - motion.q.row(1)).cwiseAbs().maxCoeff(), 1e-12);
    if (given.size() > 0) {
      EXPECT_LE((motion.q.row(0).transpose() - start).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

TEST(SplineCurve, HasTheDerivativesOfItsPositions) {
  const detail::SplineCurve curve(duration, 6, test::wide_bounds(3), {});
  constexpr double h = 1e-4;
  const Vector t = Vector::LinSpaced(60, 2.0 * h, duration - 2.0 * h);
  const Matrix c = curve.coefficients(variables(curve));
  const auto moved = [&](double shift) { return curve.tables(t.array() + shift); };
  const detail::FunctionTables here = curve.tables(t);
  const detail::FunctionTables before = moved(-h);
  const detail::FunctionTables after = moved(h);
  const auto expect_slope = [&](const Matrix& slope, const Matrix& late, const Matrix& early) {
    const Matrix expected = (late - early) * c / (2.0 * h);
    // Truncation of the differences.
    EXPECT_LE((slope * c - expected).cwiseAbs().maxCoeff(), 1e-5 * expected.cwiseAbs().maxCoeff());
  };
  expect_slope(here.velocity, after.position, before.position);
  expect_slope(here.acceleration, after.velocity, before.velocity);
  expect_slope(here.jerk, after.acceleration, before.acceleration);
}

}  // namespace
}  // namespace rivid
