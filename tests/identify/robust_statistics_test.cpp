// Robust estimates over many simulated experiments: what they cost, what they gain, and what their intervals
// are worth.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <iostream>
#include <optional>
#include <random>

#include "support/robots.hpp"
#include "support/robust_study.hpp"

namespace rivid {
namespace {

using test::errors;
using test::plain_rows;
using test::robust;
using test::scara;
using test::SineExperiment;

constexpr CovarianceOptions classical = {CovarianceKind::classical};

// Sums over simulated experiments of one robot.
struct Study {
  int runs = 0;
  Vector squares;      // of errors
  Vector bias;         // sums of errors
  double covered = 0;  // intervals that hold the truth
  double intervals = 0;

  void add(const Identification& found, const Vector& truth) {
    if (runs++ == 0) {
      squares = bias = Vector::Zero(truth.size());
    }
    const Vector error = found.chi - truth;
    squares += error.cwiseAbs2();
    bias += error;
    const Vector sigma = found.C_chi.diagonal().cwiseSqrt();
    covered +=
        static_cast<double>((error.array().abs() <= found.covariance.quantile_975 * sigma.array()).count());
    intervals += static_cast<double>(truth.size());
  }
  [[nodiscard]] double coverage() const { return covered / intervals; }
};

constexpr int study_runs = 300;

// Efficiency of 95 % where errors are normal: the mean over the parameters of the ratio of mean squared
// errors. The errors of both estimates have a correlation of 0.97, so a ratio is good to 0.02 and their mean
// to less: four of these.
TEST(RobustStatistics, LoseFivePerCentWithoutOutliers) {
  SineExperiment experiment(scara());
  const Eigen::Vector2d sigma(0.2, 0.05);
  Study wls;
  Study huber;
  Study bisquare;
  for (int run = 0; run < study_runs; ++run) {
    experiment.disturb(errors(100 + static_cast<std::uint64_t>(run), sigma, 0.0, 1.0));
    const auto found = [&](std::optional<Robust> options) {
      return identify(experiment.robot, experiment.log,
                      {.method = Wls{}, .signal = plain_rows(), .covariance = classical, .robust = options});
    };
    wls.add(found({}), experiment.truth);
    huber.add(found(robust(RobustKind::huber)), experiment.truth);
    bisquare.add(found(robust(RobustKind::bisquare)), experiment.truth);
  }
  constexpr double four_deviations = 0.04;
  EXPECT_NEAR((wls.squares.array() / huber.squares.array()).mean(), 0.95, four_deviations);
  EXPECT_NEAR((wls.squares.array() / bisquare.squares.array()).mean(), 0.95, four_deviations);
  std::cout << "efficiency " << (wls.squares.array() / huber.squares.array()).mean() << " Huber, "
            << (wls.squares.array() / bisquare.squares.array()).mean() << " bisquare\n";
}

// Five per cent of the torques are off by some twenty deviations, of either sign.
TEST(RobustStatistics, IntervalsHoldWithFivePerCentOfOutliers) {
  SineExperiment experiment(scara());
  const Eigen::Vector2d sigma(0.2, 0.05);
  for (const CovarianceKind covariance :
       {CovarianceKind::classical, CovarianceKind::hac, CovarianceKind::blocks}) {
    Study wls;
    std::array<Study, 2> studies;
    for (int run = 0; run < study_runs; ++run) {
      experiment.disturb(errors(1000 + static_cast<std::uint64_t>(run), sigma, 0.05, 20.0));
      const auto found = [&](std::optional<Robust> options) {
        return identify(
            experiment.robot, experiment.log,
            {.method = Wls{}, .signal = plain_rows(), .covariance = {covariance}, .robust = options});
      };
      wls.add(found({}), experiment.truth);
      studies[0].add(found(robust(RobustKind::huber)), experiment.truth);
      studies[1].add(found(robust(RobustKind::bisquare)), experiment.truth);
    }
    for (const Study& study : studies) {
      const Vector ratio = (study.squares.array() / wls.squares.array()).sqrt();
      const Vector spread = (study.squares / study_runs).cwiseSqrt();
      const Vector bias = study.bias.array() / study_runs / spread.array();
      std::cout << name(covariance) << ": coverage " << study.coverage() << ", RMSE over that of WLS "
                << ratio.mean() << ", largest bias " << bias.cwiseAbs().maxCoeff() << " deviations\n";
      // Intervals of eight parameters of a run are not independent, so that a run counts like one of them.
      EXPECT_NEAR(study.coverage(), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / study_runs));
      EXPECT_LT(ratio.maxCoeff(), 0.4);
      EXPECT_LT(bias.cwiseAbs().maxCoeff(), 4.0 / std::sqrt(study_runs));
    }
  }
}

// A part of the samples is off by many times the disturbance.
void spoil(Log& log, std::uint64_t seed, double part) {
  std::mt19937_64 random(seed);
  std::bernoulli_distribution outlier(part);
  std::normal_distribution<double> normal;
  const Eigen::Vector2d size(12.0, 3.0);
  for (Index k = 0; k < log.samples(); ++k) {
    for (Index j = 0; j < 2; ++j) {
      const double spike = size[j] * normal(random);
      log.v_tau(k, j) += outlier(random) ? spike : 0.0;
    }
  }
}

// Spikes in single samples of the torque. A row of a decimation by 20 reaches over some forty samples: with
// five spikes in a hundred samples hardly a row is without, and little is gained.
TEST(RobustStatistics, DependOnHowManyRowsASpikeReaches) {
  const test::ScaraStudy scara_study;
  constexpr int runs = 20;
  const auto study = [&](double part, const std::vector<int>& decimation) {
    Study wls;
    Study huber;
    Study bisquare;
    double below_half = 0.0;
    for (int run = 0; run < runs; ++run) {
      const auto seed = static_cast<std::uint64_t>(500 + run);
      Log log = scara_study.log(1.0, seed);
      spoil(log, seed, part);
      const SignalOptions signal = {
          .rows = RowScheme::exact, .torque_held = true, .cutoff_hz = 0.0, .decimation = decimation};
      const auto found = [&](std::optional<Robust> options) {
        return identify(scara_study.robot, log, {.method = Wls{}, .signal = signal, .robust = options});
      };
      wls.add(found({}), scara_study.truth);
      huber.add(found(robust(RobustKind::huber)), scara_study.truth);
      const Identification last = found(robust(RobustKind::bisquare));
      bisquare.add(last, scara_study.truth);
      const RobustJoint& joint = last.robust->joints[0];
      below_half += static_cast<double>(joint.below_half) / static_cast<double>(joint.rows) / runs;
    }
    const auto ratio = [&](const Study& of) {
      return (of.squares.array() / wls.squares.array()).sqrt().mean();
    };
    std::cout << "spikes in " << 100.0 * part << " % of the samples, decimation "
              << (decimation.empty() ? 1 : decimation.front()) << ": RMSE over that of WLS " << ratio(huber)
              << " Huber, " << ratio(bisquare) << " bisquare; below half " << 100.0 * below_half
              << " %; coverage " << wls.coverage() << ", " << huber.coverage() << ", " << bisquare.coverage()
              << '\n';
    return ratio(bisquare);
  };
  EXPECT_LT(study(0.001, {20}), 0.5);
  EXPECT_LT(study(0.005, {20}), 0.5);
  EXPECT_LT(study(0.02, {20}), 0.5);
  EXPECT_GT(study(0.05, {20}), 0.5);
}

struct RobustIvStatistics : public ::testing::Test, public test::RobustScara {};

// Errors of rows that are nearly white, as the efficiency asks for: noise of the encoder, differenced twice,
// is not.
TEST_F(RobustIvStatistics, IsNearPlainIvWithoutOutliers) {
  encoder_noise = 0.0;
  constexpr int runs = 10;
  for (const CovarianceKind covariance :
       {CovarianceKind::classical, CovarianceKind::hac, CovarianceKind::blocks}) {
    for (const RobustKind kind : {RobustKind::huber, RobustKind::bisquare}) {
      Vector ratio = Vector::Zero(8);
      for (int run = 0; run < runs; ++run) {
        const Log log = this->log(1.0, static_cast<std::uint64_t>(11 + run));
        Estimation plain_method = method({});
        plain_method.covariance.kind = covariance;
        Estimation robust_method = plain_method;
        robust_method.robust = robust(kind);
        const Identification plain = identify(robot, log, plain_method);
        const Identification found = identify(robot, log, robust_method);
        ASSERT_EQ(found.status, Status::identified);
        EXPECT_LT(found.robust->largest_shift, 1.0);  // 0.22 deviations are usual with an efficiency of 0.95
        EXPECT_EQ(found.robust->chi, plain.chi);
        ratio += (found.C_chi.diagonal().array() / plain.C_chi.diagonal().array()).sqrt().matrix() / runs;
      }
      // One over the root of the efficiency, on the average of all parameters.
      EXPECT_NEAR(ratio.mean(), std::sqrt(1.0 / 0.95), 0.05) << name(covariance) << ' ' << name(kind);
    }
  }
}

TEST_F(RobustIvStatistics, HoldsItsIntervalsWhereSpikesSpoilTheTorque) {
  constexpr int runs = 40;
  Study plain;
  std::array<Study, 2> studies;
  for (int run = 0; run < runs; ++run) {
    const auto seed = static_cast<std::uint64_t>(200 + run);
    Log log = this->log(1.0, seed);
    spoil(log, seed, 0.005);
    plain.add(identify(robot, log, method({})), truth);
    studies[0].add(identify(robot, log, method(robust(RobustKind::huber))), truth);
    studies[1].add(identify(robot, log, method(robust(RobustKind::bisquare))), truth);
  }
  for (const Study& study : studies) {
    const Vector ratio = (study.squares.array() / plain.squares.array()).sqrt();
    std::cout << "coverage " << study.coverage() << " (plain " << plain.coverage()
              << "), RMSE over that of plain IV " << ratio.mean() << '\n';
    EXPECT_NEAR(study.coverage(), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / runs));
    EXPECT_LT(ratio.maxCoeff(), 0.6);
  }
}

// Wrong positions spoil W, which draws least squares by their leverage; instruments know nothing of them.
TEST_F(RobustIvStatistics, StandWrongPositionsWhereLeastSquaresDoNot) {
  constexpr int runs = 20;
  std::array<Study, 4> studies;
  for (int run = 0; run < runs; ++run) {
    const auto seed = static_cast<std::uint64_t>(700 + run);
    Log log = this->log(1.0, seed);
    std::mt19937_64 random(seed);
    std::bernoulli_distribution wrong(0.001);
    for (Index k = 0; k < log.samples(); ++k) {
      for (Index j = 0; j < 2; ++j) {
        log.q(k, j) += wrong(random) ? 0.01 : 0.0;
      }
    }
    const Estimation by_instruments = method({});
    const Estimation robust_iv = method(robust(RobustKind::bisquare));
    studies[0].add(identify(robot, log, {.method = Wls{}, .signal = by_instruments.signal}), truth);
    studies[1].add(
        identify(robot, log, {.method = Wls{}, .signal = by_instruments.signal, .robust = robust_iv.robust}),
        truth);
    studies[2].add(identify(robot, log, by_instruments), truth);
    studies[3].add(identify(robot, log, robust_iv), truth);
  }
  std::cout << "coverage " << studies[0].coverage() << " WLS, " << studies[1].coverage() << " WLS bisquare, "
            << studies[2].coverage() << " IV, " << studies[3].coverage() << " IV bisquare\n";
  EXPECT_LT(studies[0].coverage(), 0.8);
  EXPECT_LT(studies[1].coverage(), 0.8);
  EXPECT_NEAR(studies[3].coverage(), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / runs));
  for (const std::size_t other : {0U, 2U}) {
    const Vector ratio = (studies[3].squares.array() / studies[other].squares.array()).sqrt();
    std::cout << "RMSE of IV bisquare over that of the plain ones: " << ratio.transpose() << '\n';
    EXPECT_LT(ratio.mean(), 0.6);
    // Against plain IV little is gained on some parameters of joint 2.
    EXPECT_LT(ratio.maxCoeff(), other == 0U ? 0.6 : 1.0);
  }
}

}  // namespace
}  // namespace rivid
