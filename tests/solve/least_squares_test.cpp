#include "rivid/solve/least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "rivid/solve/inference.hpp"
#include "rivid/solve/robust_loss.hpp"
#include "support/complaint.hpp"
#include "support/random_matrix.hpp"

namespace rivid {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

using test::random_matrix;

// Two groups of rows, the second blind for columns 0 and 1.
struct TwoGroups {
  Matrix W1 = random_matrix(400, 5, 21);
  Matrix W2 = random_matrix(300, 3, 22);
  Vector Y1 = random_matrix(400, 1, 23);
  Vector Y2 = 10.0 * random_matrix(300, 1, 24);

  [[nodiscard]] std::vector<RowGroup> groups() const {
    std::vector<RowGroup> out = {{{0, 1, 2, 3, 4}, StreamingQr(5)}, {{2, 3, 4}, StreamingQr(3)}};
    out[0].qr.add(W1, Y1);
    out[1].qr.add(W2, Y2);
    return out;
  }
  [[nodiscard]] Matrix W(double w1, double w2) const {
    Matrix out = Matrix::Zero(700, 5);
    out << w1 * W1, Matrix::Zero(300, 2), w2 * W2;
    return out;
  }
  [[nodiscard]] Vector Y(double w1, double w2) const {
    Vector out(700);
    out << w1 * Y1, w2 * Y2;
    return out;
  }
};

TEST(LeastSquares, OfGroupsIsThatOfTheStackedWeightedRows) {
  const TwoGroups data;
  const std::vector<double> weights = {0.7, 3.0};
  const LeastSquares found = least_squares(data.groups(), 5, weights);
  const Matrix W = data.W(0.7, 3.0);
  const Matrix normal = W.transpose() * W;
  const Vector expected = normal.inverse() * (W.transpose() * data.Y(0.7, 3.0));
  EXPECT_TRUE(found.full_rank());
  EXPECT_LT((found.chi - expected).norm(), 1e4 * epsilon * expected.norm());
  EXPECT_LT((found.unit_covariance - normal.inverse()).norm(), 1e4 * epsilon * normal.inverse().norm());
  const Residual r = residual(data.groups(), found.chi, weights);
  const Vector rho = data.Y(0.7, 3.0) - W * found.chi;
  EXPECT_NEAR(r.norm, rho.norm(), 1e4 * epsilon * rho.norm());
  EXPECT_NEAR(r.sum, rho.sum(), 1e5 * epsilon * rho.norm());
  EXPECT_NEAR((W.transpose() * rho).norm(), 0.0, 1e5 * epsilon * rho.norm());
}

TEST(LeastSquares, ConditionIsTheRatioOfTheSingularValues) {
  std::vector<RowGroup> groups = {{{0, 1}, StreamingQr(2)}};
  Matrix W = Matrix::Zero(4, 2);
  W(1, 0) = 3.0;
  W(2, 1) = 0.5;
  groups[0].qr.add(W, Vector::Zero(4));
  EXPECT_NEAR(least_squares(groups, 2, std::vector<double>{1.0}).condition, 6.0, 1e-14);
}

TEST(LeastSquares, ConditionHasEightDigitsAtLeast) {
  for (const double spread : {1.0, 1e4, 1e8}) {
    const Matrix Q = Eigen::HouseholderQR<Matrix>(random_matrix(40, 40, 25)).householderQ();
    const Vector singular =
        Vector::NullaryExpr(40, [&](Index i) { return std::pow(spread, -static_cast<double>(i) / 39.0); });
    std::vector<RowGroup> groups = {{std::vector<Index>(40), StreamingQr(40)}};
    std::iota(groups[0].columns.begin(), groups[0].columns.end(), 0);
    const Matrix U = Eigen::HouseholderQR<Matrix>(random_matrix(300, 40, 26)).householderQ();
    groups[0].qr.add(U.leftCols(40) * singular.asDiagonal() * Q.transpose(), Vector::Zero(300));
    // The singular values themselves are only known to a rounding of the largest one.
    EXPECT_NEAR(least_squares(groups, 40, std::vector<double>{1.0}).condition, spread,
                (1e-8 + 100 * epsilon * spread) * spread);
  }
}

TEST(LeastSquares, NamesTheColumnsThatCanNotBeToldApartAndKeepsTheOthers) {
  Matrix W = random_matrix(200, 5, 31);
  W.col(4) = 2.0 * W.col(1);  // 1 and 4 depend on each other
  W.col(2).setZero();         // 2 is not excited
  const Vector truth = Vector::LinSpaced(5, 1.0, 5.0);
  std::vector<RowGroup> groups = {{{0, 1, 2, 3, 4}, StreamingQr(5)}};
  groups[0].qr.add(W, W * truth);
  const LeastSquares found = least_squares(groups, 5, std::vector<double>{1.0});
  EXPECT_EQ(found.rank, 3);
  EXPECT_EQ(found.undetermined, (std::vector<std::vector<Index>>{{1, 4}, {2}}));
  EXPECT_NEAR(found.chi[0], 1.0, 1e-12);
  EXPECT_NEAR(found.chi[3], 4.0, 1e-12);
  EXPECT_TRUE(std::isinf(found.unit_covariance(1, 1)));
  EXPECT_TRUE(std::isfinite(found.unit_covariance(0, 0)));
  EXPECT_NEAR((W * (found.chi - truth)).norm(), 0.0, 1e-11);
}

// Units must not decide about rank: columns of 1e-9 and 1e9 are as good as others.
TEST(LeastSquares, JudgesRankOnColumnsOfEqualNorm) {
  Matrix W = random_matrix(100, 3, 41);
  W.col(1) *= 1e-9;
  W.col(2) *= 1e9;
  std::vector<RowGroup> groups = {{{0, 1, 2}, StreamingQr(3)}};
  groups[0].qr.add(W, W * Vector{{1.0, 1e9, 1e-9}});
  const LeastSquares found = least_squares(groups, 3, std::vector<double>{1.0});
  EXPECT_TRUE(found.full_rank());
  EXPECT_NEAR(found.chi[1] / 1e9, 1.0, 1e-12);
}

TEST(GroupSigmas, AreThoseOfAFitToEachGroupAlone) {
  const TwoGroups data;
  const std::vector<double> sigmas = group_sigmas(data.groups());
  const Vector own = (data.W2.transpose() * data.W2).inverse() * (data.W2.transpose() * data.Y2);
  EXPECT_NEAR(sigmas[1], (data.Y2 - data.W2 * own).norm() / std::sqrt(297.0), 1e-12);
}

TEST(GroupSigmas, CountTheRankOfTheGroupNotItsColumns) {
  Matrix W = random_matrix(50, 3, 51);
  W.col(2) = W.col(0);
  const Vector Y = random_matrix(50, 1, 52);
  std::vector<RowGroup> groups = {{{0, 1, 2}, StreamingQr(3)}};
  groups[0].qr.add(W, Y);
  const Matrix independent = W.leftCols(2);
  const Vector own = (independent.transpose() * independent).inverse() * (independent.transpose() * Y);
  EXPECT_NEAR(group_sigmas(groups)[0], (Y - independent * own).norm() / std::sqrt(48.0), 1e-12);
}

// Gravity about a vertical axis: a column of rounding errors, which must not be taken for one that fits
// something.
TEST(GroupSigmas, TakeColumnsOfRoundingErrorsForZero) {
  Matrix W = random_matrix(50, 3, 53);
  const Vector Y = random_matrix(50, 1, 54);
  const Matrix independent = W.leftCols(2);
  const Vector own = (independent.transpose() * independent).inverse() * (independent.transpose() * Y);
  W.col(2) *= 1e-16;
  std::vector<RowGroup> groups = {{{0, 1, 2}, StreamingQr(3)}, {{2}, StreamingQr(1)}};
  groups[0].qr.add(W, Y);
  groups[1].qr.add(Matrix::Ones(50, 1), Y);
  EXPECT_NEAR(group_sigmas(groups)[0], (Y - independent * own).norm() / std::sqrt(48.0), 1e-12);
}

// Rows of one truth, of two groups with these deviations of the noise; the second one has few rows.
std::vector<RowGroup> unequal_groups(Index few, double first, double second, unsigned seed) {
  constexpr Index many = 400;
  const Matrix W = random_matrix(many + few, 4, seed);
  const Matrix noise = random_matrix(many + few, 1, seed + 1);
  const Vector truth = W * Vector::Ones(4);
  std::vector<RowGroup> groups = {{{0, 1, 2, 3}, StreamingQr(4)}, {{0, 1, 2, 3}, StreamingQr(4)}};
  groups[0].qr.add(W.topRows(many), truth.head(many) + first * noise.topRows(many));
  groups[1].qr.add(W.bottomRows(few), truth.tail(few) + second * noise.bottomRows(few));
  return groups;
}

// Four rows of four columns fit themselves to rounding: their own fit would weight them by 1e15.
TEST(GroupSigmas, OfAGroupThatFitsItselfAreThoseThatTheFitToAllLeaves) {
  constexpr double noise = 0.1;
  for (const Index few : {3, 4, 5, 12}) {
    double squares = 0.0;
    constexpr unsigned runs = 200;
    for (unsigned run = 0; run < runs; ++run) {
      squares += std::pow(group_sigmas(unequal_groups(few, noise, noise, 1000 + 2 * run))[1] / noise, 2.0);
    }
    const double scatter = random_matrix(1000, 1, 5).squaredNorm() / 1000.0;  // of the noise's unit
    // Four deviations of the mean of as many squares.
    EXPECT_NEAR(squares / runs / scatter, 1.0, 4.0 * std::sqrt(2.0 / (static_cast<double>(few) * runs)))
        << few;
  }
}

// Arms exist whose joints err by such different torques.
TEST(GroupSigmas, KeepARatioOfSevenHundred) {
  const std::vector<double> sigmas = group_sigmas(unequal_groups(12, 0.7, 0.001, 77));
  EXPECT_GT(sigmas[0] / sigmas[1], 250.0);
  EXPECT_LT(sigmas[0] / sigmas[1], 2500.0);
}

// A column that this group alone has, in as many rows as it has columns: nothing tells its error.
TEST(GroupSigmas, OfAGroupThatNothingElseDeterminesStayBounded) {
  std::vector<RowGroup> groups = unequal_groups(4, 0.1, 0.1, 91);
  groups[1].columns = {4, 5, 6, 7};
  const double rms = groups[1].qr.y_norm() / 2.0;
  EXPECT_NEAR(group_sigmas(groups)[1], 1e-3 * rms, 1e-9 * rms);
}

// A floating base without contact: all parameters of zero would fit its rows.
TEST(GroupSigmas, OfRowsWithoutYAreThoseThatTheFitToAllLeaves) {
  constexpr double noise = 0.1;
  constexpr unsigned runs = 50;
  double squares = 0.0;
  for (unsigned run = 0; run < runs; ++run) {
    std::vector<RowGroup> groups = unequal_groups(200, noise, noise, 3000 + 4 * run);
    Matrix W = random_matrix(200, 4, 3002 + 4 * run);
    const Vector errors = noise * random_matrix(200, 1, 3003 + 4 * run);
    W -= 0.25 * (W * Vector::Ones(4) - errors) * Vector::Ones(4).transpose();
    groups[1] = {{0, 1, 2, 3}, StreamingQr(4)};
    groups[1].qr.add(W, Vector::Zero(200));
    squares += std::pow(group_sigmas(groups)[1] / noise, 2.0);
  }
  const double scatter = random_matrix(1000, 1, 5).squaredNorm() / 1000.0;
  EXPECT_NEAR(squares / runs / scatter, 1.0, 4.0 * std::sqrt(2.0 / (200.0 * runs)));
}

TEST(GroupSigmas, AreNeverZero) {
  const Matrix W = random_matrix(50, 3, 61);
  std::vector<RowGroup> groups = {{{0, 1, 2}, StreamingQr(3)}};
  groups[0].qr.add(W, W * Vector::Ones(3));
  EXPECT_GT(group_sigmas(groups)[0], 0.0);
}

// Table values (SciPy's t.ppf(0.975, freedom)).
TEST(StudentQuantile, IsThatOfTheTables) {
  EXPECT_NEAR(student_quantile_975(1), 12.706205, 1e-6);
  EXPECT_NEAR(student_quantile_975(2), 4.302653, 1e-6);
  EXPECT_NEAR(student_quantile_975(3), 3.182446, 5e-3);
  EXPECT_NEAR(student_quantile_975(10), 2.228139, 1e-5);
  EXPECT_NEAR(student_quantile_975(100), 1.983972, 1e-6);
  EXPECT_NEAR(student_quantile_975(1e9), 1.959964, 1e-6);
}

TEST(LeastSquares, RefusesGroupsThatDoNotFit) {
  const TwoGroups two;
  const std::vector<double> one = {1.0};
  const std::vector<double> both = {1.0, 1.0};
  EXPECT_EQ(test::complaint_of([&] { return least_squares(two.groups(), 5, one); }),
            "least_squares: weights has 1 value, must have one for each of 2 groups");
  EXPECT_EQ(test::complaint_of([&] { return combined(two.groups(), 4, both); }),
            "combined: a group has column 4, must be one of 0 to 3");
  EXPECT_EQ(test::complaint_of([&] { return residual(two.groups(), Vector::Zero(4), both); }),
            "residual: a group has column 4, must be one of 0 to 3");
  EXPECT_EQ(test::complaint_of([&] { return least_squares({}, 5, both); }),
            "least_squares: there are 0 groups and 5 columns, must be one of each at least");
  std::vector<RowGroup> odd = two.groups();
  odd[1].columns.pop_back();
  EXPECT_EQ(test::complaint_of([&] { return group_sigmas(odd); }),
            "group_sigmas: a group names 2 columns, its factor has 3");
}

TEST(RobustScale, RefusesNoErrors) {
  EXPECT_EQ(test::complaint_of([] { return robust_scale({}); }),
            "robust_scale: rho has no values, must have at least one");
}

}  // namespace
}  // namespace rivid
