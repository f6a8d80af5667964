// What exact rows and error bars are worth, by simulated experiments of the SCARA of [RIV].

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rivid/identify/covariance.hpp"
#include "rivid/identify/identification.hpp"
#include "support/scara_study.hpp"

namespace {

using rivid::CovarianceKind;
using rivid::CovarianceOptions;
using rivid::Estimation;
using rivid::Identification;
using rivid::Index;
using rivid::Iv;
using rivid::Log;
using rivid::Matrix;
using rivid::RowScheme;
using rivid::SignalOptions;
using rivid::Status;
using rivid::Vector;
using rivid::Wls;
using rivid::test::ScaraStudy;

constexpr double S1 = 1.0;

SignalOptions exact(std::vector<int> decimation = {20}) {
  return {.rows = RowScheme::exact, .torque_held = true, .decimation = std::move(decimation)};
}

struct Statistics : public ::testing::Test, public ScaraStudy {
  Statistics() { encoder_noise = 2e-5; }

  [[nodiscard]] Identification by_instruments(const Log& log, const SignalOptions& signal,
                                              double bandwidth = 1.0) const {
    Estimation method = iv(bandwidth);
    method.signal = signal;
    return identify(robot, log, method);
  }

  // The deviations that weighted least squares would have with regressors without noise, on all rows that
  // slip.
  [[nodiscard]] Vector bound() const {
    ScaraStudy quiet;
    quiet.encoder_noise = 0.0;
    quiet.disturbance.setZero();
    return deviation_bound(robot, quiet.log(S1, 1), disturbance);
  }
};

TEST_F(Statistics, ExactRowsHaveNoFloor) {
  encoder_noise = 0.0;
  disturbance.setZero();
  const Log log = this->log(S1, 1);
  const auto expect_truth = [&](const Identification& found) {
    ASSERT_EQ(found.status, Status::identified);
    EXPECT_LT(found.fit.relative_error, 2e-5);
    for (Index i = 0; i < 8; ++i) {
      EXPECT_NEAR(found.chi[i], truth[i], 0.002 * truth[i])
          << base.parameters[static_cast<std::size_t>(i)].name;
    }
  };
  for (const std::vector<int>& decimation : {std::vector<int>{}, std::vector<int>{20}}) {
    expect_truth(identify(robot, log, {.method = Wls{}, .signal = exact(decimation)}));
    expect_truth(by_instruments(log, exact(decimation)));
    expect_truth(by_instruments(log, exact(decimation), 0.5));
  }
}

// Errors and error bars of many runs.
struct MonteCarlo {
  Matrix errors;  // (runs × 8)
  Matrix sigmas;
  Matrix covered;  // whether the 95 % interval holds the truth

  explicit MonteCarlo(Index runs) : errors(runs, 8), sigmas(runs, 8), covered(runs, 8) {}
  void add(Index run, const Identification& found, const Vector& truth) {
    for (Index i = 0; i < 8; ++i) {
      const rivid::ParameterEstimate& p = found.parameters[static_cast<std::size_t>(i)];
      errors(run, i) = p.value - truth[i];
      sigmas(run, i) = p.sigma;
      covered(run, i) = p.interval_95[0] <= truth[i] && truth[i] <= p.interval_95[1] ? 1.0 : 0.0;
    }
  }
  [[nodiscard]] Vector bias() const { return errors.colwise().mean(); }
  [[nodiscard]] Vector rmse() const { return errors.cwiseAbs2().colwise().mean().cwiseSqrt(); }
  [[nodiscard]] Vector deviation() const { return (rmse().cwiseAbs2() - bias().cwiseAbs2()).cwiseSqrt(); }
};

TEST_F(Statistics, IntervalsMeanWhatTheySay) {
  constexpr Index runs = 300;
  MonteCarlo wls(runs);
  MonteCarlo iv(runs);
  for (Index run = 0; run < runs; ++run) {
    const Log log = this->log(S1, static_cast<std::uint64_t>(run) + 1);
    wls.add(run, identify(robot, log, {.method = Wls{}, .signal = exact()}), truth);
    const Identification found = by_instruments(log, exact());
    ASSERT_EQ(found.status, Status::identified) << "seed " << run + 1;
    iv.add(run, found, truth);
  }
  const Vector bound = this->bound();
  for (const MonteCarlo* method : {&wls, &iv}) {
    const Vector bias = method->bias().cwiseAbs().cwiseQuotient(method->deviation());
    EXPECT_LE(bias.maxCoeff(), 0.2) << bias.transpose();
    const Vector rmse = method->rmse().cwiseQuotient(bound);
    EXPECT_LE(rmse.maxCoeff(), 1.35) << rmse.transpose();
    const Vector coverage = method->covered.colwise().mean();
    EXPECT_GE(coverage.minCoeff(), 0.90) << coverage.transpose();
    EXPECT_GE(coverage.mean(), 0.93) << coverage.transpose();
    EXPECT_LE(coverage.mean(), 0.97) << coverage.transpose();
  }
}

// Whitened rows without decimation.
TEST_F(Statistics, PrefilteredIntervalsMeanWhatTheySay) {
  constexpr Index runs = 300;
  MonteCarlo piv(runs);
  Index warned = 0;
  for (Index run = 0; run < runs; ++run) {
    const Log log = this->log(S1, static_cast<std::uint64_t>(run) + 1);
    Estimation method = iv();
    method.signal = exact();
    std::get<Iv>(method.method).prefilter = true;
    const Identification found = identify(robot, log, method);
    ASSERT_EQ(found.status, Status::identified) << "seed " << run + 1;
    warned += found.warnings.empty() ? 0 : 1;
    piv.add(run, found, truth);
  }
  const Vector bias = piv.bias().cwiseAbs().cwiseQuotient(piv.deviation());
  EXPECT_LE(bias.maxCoeff(), 0.2) << bias.transpose();
  const Vector rmse = piv.rmse().cwiseQuotient(bound());
  EXPECT_LE(rmse.maxCoeff(), 1.25) << rmse.transpose();
  const Vector coverage = piv.covered.colwise().mean();
  EXPECT_GE(coverage.minCoeff(), 0.90) << coverage.transpose();
  EXPECT_GE(coverage.mean(), 0.93) << coverage.transpose();
  EXPECT_LE(coverage.mean(), 0.97) << coverage.transpose();
  // The model is right, and the prefilter moves nothing far.
  EXPECT_LE(warned, runs / 20);
}

// The paper's rows have a floor that no error bar tells of.
TEST_F(Statistics, ThePapersRowsBiasFriction) {
  constexpr Index runs = 40;
  MonteCarlo iv(runs);
  SignalOptions paper = filtered();
  paper.rows = RowScheme::paper;
  for (Index run = 0; run < runs; ++run) {
    iv.add(run, by_instruments(this->log(S1, static_cast<std::uint64_t>(run) + 1), paper), truth);
  }
  const Vector bias = iv.bias().cwiseAbs().cwiseQuotient(iv.deviation());
  EXPECT_GT(bias.maxCoeff(), 2.0) << bias.transpose();
}

TEST_F(Statistics, HausmanAcceptsLeastSquaresWhereTheEncoderIsPerfect) {
  encoder_noise = 0.0;
  disturbance.setZero();
  constexpr int runs = 200;
  int rejected = 0;
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    Log log = this->log(S1, seed);
    log.v_tau += rivid::white_noise(seed, 5, log.samples(), Vector(Eigen::Vector2d(0.06, 0.015)));
    const Identification found = by_instruments(log, exact());
    ASSERT_TRUE(found.diagnostics && found.diagnostics->hausman) << "seed " << seed;
    rejected += found.diagnostics->hausman->test.p < 0.05 ? 1 : 0;
    sum += found.diagnostics->hausman->test.statistic;
  }
  EXPECT_LE(rejected, 16);
  // The mean of F is about one: the covariance is that of the difference of the estimates, not of their sum.
  EXPECT_NEAR(sum / runs, 1.0, 0.25);
}

TEST_F(Statistics, HausmanRejectsLeastSquaresWhereTheEncoderIsCoarse) {
  encoder_noise = 4.5e-5;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Identification found = by_instruments(this->log(2.0, seed), exact({1}));
    ASSERT_TRUE(found.diagnostics && found.diagnostics->hausman) << "seed " << seed;
    EXPECT_LT(found.diagnostics->hausman->test.p, 1e-3) << "seed " << seed;
    EXPECT_GT(found.diagnostics->hausman->largest_shift, 3.0) << "seed " << seed;
  }
}

}  // namespace
