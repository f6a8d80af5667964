#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "rivid/data/adjust.hpp"
#include "rivid/data/table.hpp"
#include "support/complaint.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;

// The same curve by another elimination: a few hundred units of rounding on signals of size one.
constexpr double other_algorithm = 1e-12;

enum Kind { knot, spline, linear };

Matrix part(const Table& table, double number, double kind) {
  std::vector<Index> rows;
  for (Index k = 0; k < table.rows(); ++k) {
    if (table.values(k, 0) == number && table.values(k, 1) == kind) {
      rows.push_back(k);
    }
  }
  return table.values(rows, Eigen::seq(2, 4));
}

TEST(CubicSpline, IsThatOfSciPy) {
  const Table table = read_table(std::filesystem::path(RIVID_TEST_DATA) / "data/interpolate_oracle.csv");
  for (int number = 0; number < 6; ++number) {
    const Matrix knots = part(table, number, knot);
    const Matrix wanted = part(table, number, spline);
    ASSERT_GT(wanted.rows(), 0);
    const Matrix got = CubicSpline(knots.col(0), knots.rightCols(2))(wanted.col(0));
    const double scale = 1.0 + wanted.rightCols(2).cwiseAbs().maxCoeff();
    EXPECT_LT((got - wanted.rightCols(2)).cwiseAbs().maxCoeff(), other_algorithm * scale)
        << "case " << number;
  }
}

TEST(CubicSpline, HasItsValueAndItsDerivativesAtOneInstant) {
  Vector t(7);
  t << 0.0, 0.1, 0.2, 0.31, 2.0, 2.5, 4.0;
  const auto cubic = [](double x) { return 1.0 + x * (2.0 + x * (3.0 - x)); };
  const CubicSpline curve(t, t.unaryExpr(cubic));
  EXPECT_EQ(curve.size(), 1);
  EXPECT_EQ(curve.begin(), 0.0);
  EXPECT_EQ(curve.end(), 4.0);
  Vector value(1);
  Vector slope(1);
  Vector curvature(1);
  for (double at = -0.5; at < 5.0; at += 0.03125) {
    curve.at(at, value, slope, curvature);
    EXPECT_EQ(value[0], curve(Vector::Constant(1, at))(0, 0));
    EXPECT_NEAR(value[0], cubic(at), 1e3 * other_algorithm);
    EXPECT_NEAR(slope[0], 2.0 + at * (6.0 - 3.0 * at), 1e3 * other_algorithm);
    EXPECT_NEAR(curvature[0], 6.0 - 6.0 * at, 1e3 * other_algorithm);
  }
}

TEST(LinearInterpolation, IsThatOfNumPy) {
  const Table table = read_table(std::filesystem::path(RIVID_TEST_DATA) / "data/interpolate_oracle.csv");
  for (int number = 0; number < 6; ++number) {
    const Matrix knots = part(table, number, knot);
    const Matrix wanted = part(table, number, linear);
    const Matrix got = linear_interpolation(knots.col(0), knots.rightCols(2), wanted.col(0));
    EXPECT_LT((got - wanted.rightCols(2)).cwiseAbs().maxCoeff(), other_algorithm) << "case " << number;
  }
}

TEST(CubicSpline, ReproducesACubicEverywhere) {
  const Vector t{{0.0, 0.1, 0.5, 0.7, 1.5, 2.0}};
  const auto cubic = [](const Vector& x) -> Vector {
    return 1.0 + x.array() * (2.0 + x.array() * (x.array() - 3.0));
  };
  const Vector at{{1.9, -0.5, 0.05, 2.5, 1.0, 0.6}};
  EXPECT_TRUE(CubicSpline(t, cubic(t))(at).isApprox(cubic(at), other_algorithm));
}

TEST(CubicSpline, PassesThroughItsSamples) {
  const Vector t = Vector::LinSpaced(50, 0.0, 3.0);
  const Matrix values = t.array().sin();
  EXPECT_EQ(CubicSpline(t, values)(t).topRows(49), values.topRows(49));
}

TEST(LinearInterpolation, HoldsTheEndValues) {
  const Vector t{{0.0, 1.0}};
  const Vector values{{2.0, 4.0}};
  const Vector at{{-1.0, 0.25, 9.0}};
  EXPECT_EQ(linear_interpolation(t, values, at), (Matrix{{2.0}, {2.5}, {4.0}}));
  EXPECT_EQ(linear_interpolation(t.head(1), values.head(1), at), (Matrix{{2.0}, {2.0}, {2.0}}));
}

TEST(Interpolation, RefusesWhatIsNoSeriesOfSamples) {
  const Vector t{{0.0, 1.0, 1.0}};
  EXPECT_TRUE(says(complaint_of([&] { CubicSpline(t, t); }),
                   "CubicSpline: t must increase, but goes from 1 to 1 at index 2"));
  EXPECT_TRUE(says(complaint_of([&] { CubicSpline(t.head(1), t.head(1)); }), "t has 1 instants, at least 2"));
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(linear_interpolation(t, t.head(2), t)); }),
                   "linear_interpolation: t has 3 instants, values has 2 rows"));
}

}  // namespace
}  // namespace rivid
