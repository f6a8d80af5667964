// StreamingQr against one factorisation of all rows in long double, and against normal equations.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <random>

#include "rivid/solve/streaming_qr.hpp"

namespace rivid {
namespace {

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using LongVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr Index rows = 4000;
constexpr Index columns = 20;

Matrix random_matrix(Index row_count, Index column_count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Matrix::NullaryExpr(row_count, column_count, [&] { return normal(random); });
}

Matrix orthonormal(Index row_count, Index column_count, std::uint64_t seed) {
  const Eigen::HouseholderQR<Matrix> qr(random_matrix(row_count, column_count, seed));
  return qr.householderQ() * Matrix::Identity(row_count, column_count);
}

// Singular values from 1 down to 1 / condition, in even steps of their logarithm.
Matrix with_condition(double condition, std::uint64_t seed) {
  const Vector s = (Vector::LinSpaced(columns, 0.0, -1.0) * std::log(condition)).array().exp();
  return orthonormal(rows, columns, seed) * s.asDiagonal() *
         orthonormal(columns, columns, seed + 1).transpose();
}

struct Case {
  double condition;
  std::uint64_t seed;
};

class EveryCondition : public testing::TestWithParam<Case> {};

TEST_P(EveryCondition, TheSolutionErrsByTenEpsilonKappaAtMost) {
  const auto [condition, seed] = GetParam();
  SCOPED_TRACE("seed " + std::to_string(seed));
  const Matrix W = with_condition(condition, seed);
  // A small residual, so that κ and not κ² bounds the error.
  const Vector Y = W * Vector::LinSpaced(columns, 1.0, 2.0) + 1e-10 * random_matrix(rows, 1, seed + 2);
  StreamingQr qr(columns);
  qr.add(W, Y);
  const Vector chi = qr.R().triangularView<Eigen::Upper>().solve(qr.qty());

  const LongVector exact =
      Eigen::HouseholderQR<LongMatrix>(W.cast<long double>()).solve(Y.cast<long double>());
  const auto relative_error = [&](const Vector& found) {
    return static_cast<double>((found.cast<long double>() - exact).norm() / exact.norm());
  };
  EXPECT_LT(relative_error(chi), 10.0 * epsilon * condition);

  const Vector normal = (W.transpose() * W).eval().partialPivLu().solve(W.transpose() * Y);
  RecordProperty("qr", std::to_string(relative_error(chi) * 1e15) + "e-15");
  RecordProperty("normal_equations", std::to_string(relative_error(normal) * 1e15) + "e-15");
  if (condition >= 1e8) {
    EXPECT_GT(relative_error(normal), 1e-3) << "normal equations were expected to fail here";
  }
}

TEST_P(EveryCondition, TheTriangleIsBackwardStable) {
  const auto [condition, seed] = GetParam();
  const Matrix W = with_condition(condition, seed);
  StreamingQr qr(columns);
  qr.add(W, Vector::Zero(rows));
  const LongMatrix R = qr.R().cast<long double>();
  const LongMatrix W_long = W.cast<long double>();
  // WᵀW = RᵀR in long double, within 10 ε ‖W‖² whatever the condition.
  const auto error = static_cast<double>((R.transpose() * R - W_long.transpose() * W_long).norm());
  EXPECT_LT(error, 10.0 * epsilon * W.squaredNorm());
}

INSTANTIATE_TEST_SUITE_P(StreamingQrOracle, EveryCondition,
                         testing::Values(Case{1e0, 1000}, Case{1e2, 2000}, Case{1e4, 3000}, Case{1e6, 4000},
                                         Case{1e8, 5000}, Case{1e8, 6000}),
                         [](const auto& instance) { return "Seed" + std::to_string(instance.param.seed); });

// Eq. (34) of [RIV].
TEST(JointFactorisation, SolvesTheInstrumentalNormalEquations) {
  const Matrix W = random_matrix(rows, columns, 71);
  const Matrix V = W + 0.3 * random_matrix(rows, columns, 72);
  const Vector Y = W * Vector::LinSpaced(columns, 1.0, 2.0) + random_matrix(rows, 1, 73);
  Matrix carried(rows, columns + 1);
  carried << W, Y;
  StreamingQr joint(columns, columns + 1);
  joint.add(V, carried);
  const Vector chi = joint.qt_carried().leftCols(columns).lu().solve(joint.qty());

  const LongMatrix V_long = V.cast<long double>();
  const LongVector exact = (V_long.transpose() * W.cast<long double>())
                               .eval()
                               .partialPivLu()
                               .solve(V_long.transpose() * Y.cast<long double>());
  // VᵀW = R_VVᵀ R_VW: their condition numbers, below 10 each here, bound the error.
  EXPECT_LT(static_cast<double>((chi.cast<long double>() - exact).norm()),
            10.0 * epsilon * 100.0 * static_cast<double>(exact.norm()));
}

TEST(JointFactorisation, OfRegressorsThatAreTheirOwnInstrumentsIsLeastSquares) {
  const Matrix W = with_condition(1e4, 74);
  const Vector Y = random_matrix(rows, 1, 75);
  Matrix carried(rows, columns + 1);
  carried << W, Y;
  StreamingQr joint(columns, columns + 1);
  joint.add(W, carried);
  StreamingQr ols(columns);
  ols.add(W, Y);
  const double tolerance = 64.0 * epsilon * W.norm();
  EXPECT_LT((joint.qt_carried().leftCols(columns) - Matrix(joint.R())).norm(), tolerance);
  EXPECT_EQ(joint.R(), ols.R());
  EXPECT_LT((joint.qty() - ols.qty()).norm(), 64.0 * epsilon * Y.norm());
  EXPECT_NEAR(joint.unreachable_norm(), ols.unreachable_norm(), 64.0 * epsilon * Y.norm());
  EXPECT_LT(joint.unreachable_norms().head(columns).norm(), tolerance) << "W lies in its own range";
  const Vector iv = joint.qt_carried().leftCols(columns).lu().solve(joint.qty());
  const Vector chi = ols.R().triangularView<Eigen::Upper>().solve(ols.qty());
  EXPECT_LT((iv - chi).norm(), 10.0 * epsilon * 1e4 * chi.norm());
}

}  // namespace
}  // namespace rivid
