// Fourier series that begin and end at rest.

#include "excite/curve.hpp"

#include <gtest/gtest.h>

#include <random>

#include "excite/tasks.hpp"

namespace rivid {
namespace {

constexpr double duration = 12.0;

Vector variables(const detail::FourierCurve& curve) {
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
    const FourierReference reference(curve.series(variables(curve)));
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
  const FourierReference reference(curve.series(z));
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
  const FourierReference reference(curve.series(variables(curve)));
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
  const FourierSeries series = curve.series(curve.at_rest(pose));
  EXPECT_LE((series.q0 - pose).norm(), 1e-12);
  EXPECT_EQ(series.A.cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(series.B.cwiseAbs().maxCoeff(), 0.0);
}

}  // namespace
}  // namespace rivid
