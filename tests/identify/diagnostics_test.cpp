// The tests on a result: those of the residual against their textbook formulas, and these against SciPy
// (residual_oracle.csv); what a wrong deviation of the torque lag, wrong weights or a wrong factor of the
// decimation would hide.

#include "rivid/identify/diagnostics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "rivid/solve/inference.hpp"
#include "support/scara_study.hpp"

namespace rivid {
namespace {

constexpr Index lags = 20;
// Another order of the same sums over some thousand rows.
constexpr double rounding = 1e-9;

struct Textbook {
  double skewness = 0.0;
  double excess_kurtosis = 0.0;
  double jarque_bera = 0.0;
  double ljung_box = 0.0;
  double autocorrelation = 0.0;
};

// Of residuals in runs without a gap. The mean of the moments is that of all; correlations are those of
// [Ljung, Box 1978], with the part of the pairs that gaps leave.
Textbook textbook(const Vector& x, const std::vector<int>& run) {
  const auto n = static_cast<double>(x.size());
  const Eigen::ArrayXd centred = x.array() - x.mean();
  const double variance = centred.square().mean();
  Textbook out;
  out.skewness = centred.cube().mean() / std::pow(variance, 1.5);
  out.excess_kurtosis = centred.square().square().mean() / (variance * variance) - 3.0;
  out.jarque_bera = n / 6.0 * (std::pow(out.skewness, 2) + std::pow(out.excess_kurtosis, 2) / 4.0);
  for (Index l = 1; l <= lags; ++l) {
    double products = 0.0;
    double pairs = 0.0;
    for (Index t = l; t < x.size(); ++t) {
      if (run[static_cast<std::size_t>(t)] == run[static_cast<std::size_t>(t - l)]) {
        products += x[t] * x[t - l];
        ++pairs;
      }
    }
    const double r = products / pairs / x.array().square().mean();
    out.ljung_box += pairs * (n + 2.0) / n * r * r;
    out.autocorrelation = l == 1 ? r : out.autocorrelation;
  }
  return out;
}

TEST(ResidualTests, TextbookIsThatOfSciPy) {
  const std::map<std::string, double (*)(double)> series = {
      {"whitish", [](double t) { return std::sin(1.7 * t + 3.0 * std::sin(t) + 0.1 * t * t); }},
      {"coloured", [](double t) { return std::sin(0.05 * t) + 0.4 * std::sin(1.7 * t + std::sin(t)); }},
      {"skewed", [](double t) { return std::exp(1.5 * std::sin(2.3 * t + 0.07 * t * t)); }}};
  std::ifstream file(std::string(RIVID_TEST_DATA) + "/identify/residual_oracle.csv");
  int seen = 0;
  for (std::string name; std::getline(file, name, ','); ++seen) {
    std::vector<double> expected;
    std::string line;
    std::getline(file, line);
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) {
      expected.push_back(std::stod(cell));
    }
    ASSERT_EQ(expected.size(), 6U);
    Vector x = Vector::NullaryExpr(500, [&](Index k) { return series.at(name)(static_cast<double>(k)); });
    x.array() -= x.mean();
    const Textbook found = textbook(x, std::vector<int>(500, 0));
    EXPECT_NEAR(found.skewness, expected[0], rounding) << name;
    EXPECT_NEAR(found.excess_kurtosis, expected[1], rounding) << name;
    EXPECT_NEAR(found.jarque_bera, expected[2], rounding * expected[2]) << name;
    EXPECT_NEAR(chi_square_tail(found.jarque_bera, 2.0), expected[3], rounding) << name;
    EXPECT_NEAR(found.ljung_box, expected[4], rounding * expected[4]) << name;
    EXPECT_NEAR(chi_square_tail(found.ljung_box, lags), expected[5], rounding) << name;
  }
  EXPECT_EQ(seen, 3);
}

class OfTheScara : public testing::Test, public test::ScaraStudy {
 protected:
  static SignalOptions exact(std::vector<int> decimation) {
    return {.rows = RowScheme::exact, .torque_held = true, .decimation = std::move(decimation)};
  }
};

// Runs of rows of a joint that follow each other at this stride.
std::vector<int> runs(const std::vector<Index>& samples, Index stride) {
  std::vector<int> out(samples.size(), 0);
  for (std::size_t k = 1; k < samples.size(); ++k) {
    out[k] = out[k - 1] + (samples[k] - samples[k - 1] == stride ? 0 : 1);
  }
  return out;
}

void expect_textbook(const Robot& robot, const BaseParameters& base, const Log& log,
                     const SignalOptions& signal, Index stride) {
  const Identification result = identify(robot, log, {.method = Ols{}, .signal = signal});
  ASSERT_TRUE(result.diagnostics);
  const Rows all = rows(robot, base, log, signal);
  for (std::size_t j = 0; j < all.Y.size(); ++j) {
    const JointRows& own = all.W.joints[j];
    const Vector rho = all.Y[j] - own.W * Vector(result.chi(own.columns));
    const Textbook expected = textbook(rho, runs(all.samples[j], stride));
    const ResidualTests& found = result.diagnostics->residuals[j];
    EXPECT_EQ(found.joint, robot.joints[j].name);
    EXPECT_NEAR(found.skewness, expected.skewness, rounding);
    EXPECT_NEAR(found.excess_kurtosis, expected.excess_kurtosis, rounding);
    EXPECT_NEAR(found.normality.statistic, expected.jarque_bera, rounding * expected.jarque_bera);
    EXPECT_EQ(found.normality.freedom, 2.0);
    EXPECT_EQ(found.normality.p, chi_square_tail(found.normality.statistic, 2.0));
    EXPECT_NEAR(found.whiteness.statistic, expected.ljung_box, rounding * expected.ljung_box);
    EXPECT_EQ(found.whiteness.freedom, static_cast<double>(lags));
    EXPECT_EQ(found.whiteness.p, chi_square_tail(found.whiteness.statistic, lags));
    EXPECT_NEAR(found.autocorrelation, expected.autocorrelation, rounding);
  }
}

TEST_F(OfTheScara, ResidualTestsAreThoseOfTheTextbook) {
  expect_textbook(robot, base, log(1.0, 1), unfiltered(), 1);
  // With gaps where joints reverse.
  expect_textbook(robot, base, log(1.0, 2), exact({1}), 1);
  expect_textbook(robot, base, log(1.0, 3), exact({5}), 5);
}

TEST_F(OfTheScara, ClassicalDeviationsUndoTheDecimationOfExactRows) {
  constexpr int n_d = 10;
  // n_d Σ w² of a window of raised cosines, w_m = (1 + cos (π m / n_d)) / (2 n_d).
  const double factor = std::sqrt(0.75);
  const Log log = this->log(1.0, 1);
  const SignalOptions signal = exact({n_d});
  const Identification found = identify(
      robot, log, {.method = Ols{}, .signal = signal, .covariance = {.kind = CovarianceKind::classical}});
  EXPECT_NEAR(found.covariance.decimation_factor, factor, 1e-12);
  const Rows all = rows(robot, base, log, signal);
  const Matrix W = all.W.dense();
  const Matrix C = std::pow(found.fit.sigma_rho / factor, 2) * (W.transpose() * W).inverse();
  EXPECT_LT((found.C_chi - C).norm(), 1e-9 * C.norm());
}

// One torque recorded a sample late, the other a sample early: no lag of both, and a deviation that says so.
TEST_F(OfTheScara, TorqueLagIsUncertainWhereJointsDisagree) {
  const SignalOptions signal = exact({10});
  const auto lag_of = [&](const Log& log) {
    const Identification found = identify(robot, log, {.method = Wls{}, .signal = signal});
    return found.diagnostics->torque_lag.value();
  };
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Log good = log(2.0, seed);
    Log torn = good;
    const Index last = torn.samples() - 1;
    torn.v_tau.col(0).tail(last) = good.v_tau.col(0).head(last);
    torn.v_tau.col(1).head(last) = good.v_tau.col(1).tail(last);
    const TorqueLag found = lag_of(torn);
    EXPECT_LT(lag_of(good).sigma, 0.2) << "seed " << seed;
    EXPECT_GT(found.sigma, 0.35) << "seed " << seed;
    EXPECT_LT(std::abs(found.samples), 3.0 * found.sigma) << "seed " << seed;
  }
}

// Rows of IDIM-IV are weighted by the deviations that its own instruments leave, not by those that it began
// with.
TEST_F(OfTheScara, WeightsOfInstrumentsAreThoseOfTheirResiduals) {
  const Identification found = identify(robot, log(2.0, 1), iv());
  ASSERT_EQ(found.status, Status::identified);
  for (std::size_t j = 0; j < found.weights.size(); ++j) {
    // The last weights are those of the iterate before.
    EXPECT_NEAR(found.weights[j] * found.fit.joints[j].sigma_rho, 1.0, 0.05) << "joint " << j;
  }
}

}  // namespace
}  // namespace rivid
