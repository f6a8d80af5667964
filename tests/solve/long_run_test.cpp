#include <gtest/gtest.h>

#include <Eigen/QR>
#include <array>
#include <cmath>
#include <random>

#include "rivid/solve/inference.hpp"
#include "solve/statistics_oracle.hpp"

namespace rivid {
namespace {

// White noise of deviation 1 through x[k] = ρ x[k−1] + e[k].
Matrix autoregression(double rho, Index samples, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Matrix out(samples, 1);
  double x = normal(random) / std::sqrt(1.0 - rho * rho);
  for (Index k = 0; k < samples; ++k) {
    out(k, 0) = x;
    x = rho * x + normal(random);
  }
  return out;
}

TEST(LongRun, IsTheCovarianceOfStatsmodels) {
  Matrix X(200, 3);
  Vector y(200);
  for (Index k = 0; k < 200; ++k) {
    const auto t = static_cast<double>(k);
    X.row(k) << 1.0, std::sin(0.13 * t), std::cos(0.31 * t);
    y[k] = X.row(k).dot(Eigen::RowVector3d(1.0, -2.0, 0.5)) + 0.3 * std::sin(0.05 * t) +
           0.2 * std::sin(1.7 * t + 0.2 * std::sin(t));
  }
  const Vector residual = y - X * X.householderQr().solve(y);
  const Matrix scores = X.array().colwise() * residual.array();
  const auto rows = test::statistics_oracle("hac");
  ASSERT_EQ(rows.size(), 27U);
  for (const auto& row : rows) {
    const Matrix S = long_run_covariance(std::span(&scores, 1), static_cast<Index>(row[0]));
    // Sums of 200 terms, in another order.
    EXPECT_NEAR(S(static_cast<Index>(row[1]), static_cast<Index>(row[2])), row[3], 1e-12 * S.norm());
  }
}

TEST(LongRun, OfSeveralSeriesIsTheSum) {
  const std::array<Matrix, 2> both = {autoregression(0.5, 90, 1), autoregression(0.5, 40, 2)};
  const Matrix together = long_run_covariance(both, 4);
  const Matrix apart =
      long_run_covariance(std::span(both).first(1), 4) + long_run_covariance(std::span(both).last(1), 4);
  EXPECT_NEAR(together(0, 0), apart(0, 0), 1e-12 * apart(0, 0));
}

// The variance of the sum of an autoregression is n / (1 − ρ)². Means over 200 series lie within 4 standard
// errors, and the estimate falls short by the part of the correlation that the lag leaves out.
TEST(LongRun, FindsTheVarianceOfASumWithTheLagOfTheRule) {
  constexpr Index samples = 2000;
  for (const double rho : {-0.5, 0.0, 0.5, 0.8}) {
    double mean = 0.0;
    Index lag = 0;
    constexpr std::uint64_t runs = 200;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) {
      const Matrix x = autoregression(rho, samples, seed);
      lag = bartlett_lag(std::span(&x, 1));
      mean += long_run_covariance(std::span(&x, 1), lag)(0, 0) / static_cast<double>(runs);
    }
    const double expected = static_cast<double>(samples) / std::pow(1.0 - rho, 2.0);
    EXPECT_NEAR(mean, expected, 0.15 * expected) << rho << ", lag " << lag;
  }
}

// Eigen's product of many columns of no rows divides by zero.
TEST(LongRun, OfNoInstantsIsZero) {
  const Matrix none(0, 60);
  EXPECT_EQ(long_run_covariance(std::span(&none, 1), 0), Matrix::Zero(60, 60));
}

TEST(LongRun, TheRuleWantsLongerLagsForLongerCorrelation) {
  Index last = -1;
  for (const double rho : {0.0, 0.3, 0.6, 0.9}) {
    const Matrix x = autoregression(rho, 5000, 3);
    const Index lag = bartlett_lag(std::span(&x, 1));
    EXPECT_GT(lag, last);
    last = lag;
  }
}

// Andrews (1991), eqs. 5.3 and 6.4, of an autoregression of order 1: 1.1447 (4 ρ² T / ((1 − ρ)² (1 + ρ)²))^⅓.
TEST(LongRun, TheRuleIsAndrewsOfTheCorrelationFound) {
  for (const double rho : {0.2, 0.5, 0.9}) {
    const Matrix x = autoregression(rho, 3000, 4);
    const double found = x.col(0).head(2999).dot(x.col(0).tail(2999)) / x.squaredNorm();
    const double alpha = std::pow(2.0 * found / (1.0 - found * found), 2.0);
    EXPECT_EQ(bartlett_lag(std::span(&x, 1)),
              static_cast<Index>(std::ceil(1.1447 * std::cbrt(alpha * 3000.0))));
  }
}

// Table 1 of Kiefer & Vogelsang (2005): 1.96 without a lag; with lag and series of one length 4.771 was
// simulated there, which its polynomial gives as 4.813.
TEST(LongRun, LongLagsWidenIntervals) {
  EXPECT_EQ(fixed_lag_widening(0.0), 1.0);
  EXPECT_NEAR(1.96 * fixed_lag_widening(1.0), 4.813, 1e-3);
}

}  // namespace
}  // namespace rivid
