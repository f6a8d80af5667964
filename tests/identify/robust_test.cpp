#include "rivid/identify/robust.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <optional>
#include <random>
#include <sstream>
#include <stdexcept>

#include "rivid/error.hpp"
#include "rivid/identify/least_squares_fit.hpp"
#include "support/robots.hpp"
#include "support/scara_study.hpp"

namespace rivid {
namespace {

using test::scara;
using test::slider;

// A value of statsmodels from robust_oracle.csv.
double oracle(const std::string& loss, const std::string& what, double index) {
  std::ifstream file(std::string(RIVID_TEST_DATA) + "/identify/robust_oracle.csv");
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    std::string first;
    std::string second;
    std::string third;
    std::string value;
    std::getline(cells, first, ',');
    std::getline(cells, second, ',');
    std::getline(cells, third, ',');
    std::getline(cells, value, ',');
    if (first == loss && second == what && std::stod(third) == index) {
      return std::stod(value);
    }
  }
  throw std::invalid_argument(loss + " " + what);
}

SignalOptions plain_rows() { return {.rows = RowScheme::paper}; }

Robust robust(RobustKind kind) { return {.kind = kind}; }

constexpr CovarianceOptions classical = {CovarianceKind::classical};

// Motions of sines, and torques that the model explains but for `error`, (n_m × n).
struct Experiment {
  static constexpr Index samples = 404;

  Robot robot;
  BaseParameters base;
  Log log;
  Vector truth;

  explicit Experiment(Robot its_robot) : robot(std::move(its_robot)), base(base_parameters(robot)) {
    const Index n = robot.size();
    log.source = "sines";
    log.f_m = 100.0;
    log.t = Vector::NullaryExpr(samples, [&](Index k) { return static_cast<double>(k) / log.f_m; });
    log.q = Matrix::NullaryExpr(samples, n, [](Index k, Index j) {
      const auto t = static_cast<double>(k);
      const auto joint = static_cast<double>(j);
      return 0.6 * std::sin((0.047 + 0.011 * joint) * t) +
             0.2 * std::sin((0.19 - 0.03 * joint) * t + 0.4 + joint);
    });
    log.tau = Matrix::Ones(samples, n);
    truth = Vector::LinSpaced(base.size(), 1.0, 2.0);
    const Rows rows = rivid::rows(robot, base, log, plain_rows());
    for (Index j = 0; j < n; ++j) {
      const auto at = static_cast<std::size_t>(j);
      const JointRows& joint = rows.W.joints[at];
      log.tau.col(j)(rows.samples[at]) = joint.W * truth(joint.columns);
    }
    clean_ = log.tau;
  }

  void disturb(const Matrix& error) { log.tau = clean_ + error; }

 private:
  Matrix clean_;
};

// Normal errors with `sigma` of each joint, of which a part is so many times larger.
Matrix errors(std::uint64_t seed, const Vector& sigma, double part, double factor) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::bernoulli_distribution outlier(part);
  return Matrix::NullaryExpr(Experiment::samples, sigma.size(), [&](Index, Index j) {
    const double size = outlier(random) ? factor : 1.0;
    return size * sigma[j] * normal(random);
  });
}

TEST(RobustLoss, IsThatOfStatsmodels) {
  constexpr double rounding = 1e-15;
  for (const RobustKind kind : {RobustKind::huber, RobustKind::bisquare}) {
    const RobustLoss loss = Robust{.kind = kind}.loss();
    for (const double u : {0.0, 0.3, 1.2, -1.4, 2.0, 3.7, -4.6, 6.0}) {
      const std::string which(name(kind));
      EXPECT_NEAR(loss.weight(u), oracle(which, "weight", u), rounding) << which << " of " << u;
      EXPECT_NEAR(loss.slope(u), oracle(which, "slope", u), rounding) << which << " of " << u;
    }
  }
}

TEST(RobustScale, IsTheMedianOfTheMagnitudes) {
  std::vector<double> odd = {-3.0, 1.0, -2.0};
  std::vector<double> even = {4.0, -1.0, 2.0, -3.0};
  EXPECT_NEAR(robust_scale(odd), 2.0 / 0.6744897501960817, 1e-15);
  EXPECT_NEAR(robust_scale(even), 2.5 / 0.6744897501960817, 1e-15);
}

// Parameters, deviations, scale and weights on a log of sines with gross outliers.
TEST(RobustOracle, IsTheEstimateOfStatsmodels) {
  const Robot robot = slider(Friction::coulomb);
  Log log;
  log.source = "sines";
  log.f_m = 100.0;
  constexpr Index samples = 200;
  log.t = Vector::NullaryExpr(samples, [&](Index k) { return static_cast<double>(k) / log.f_m; });
  log.q = Matrix::NullaryExpr(samples, 1, [](Index i, Index) {
    const auto k = static_cast<double>(i);
    return 0.3 * std::sin(0.11 * k) + 0.1 * std::sin(0.37 * k + 0.4);
  });
  log.tau = Matrix::Ones(samples, 1);
  const BaseParameters base = base_parameters(robot);
  ASSERT_EQ(base.size(), 3);
  const Rows rows = rivid::rows(robot, base, log, plain_rows());
  const Vector clean = rows.W.joints[0].W * Eigen::Vector3d(12.0, 3.0, 1.5);
  for (Index i = 0; i < clean.size(); ++i) {
    const Index sample = rows.samples[0][static_cast<std::size_t>(i)];
    const auto k = static_cast<double>(sample);
    const double outlier =
        (sample % 13 == 0 ? 25.0 : 0.0) - (sample >= 5 && (sample - 5) % 31 == 0 ? 40.0 : 0.0);
    log.tau(sample, 0) = clean[i] + 0.4 * std::sin(1.7 * k + 3.0 * std::sin(0.9 * k)) +
                         0.3 * std::sin(2.9 * k * (1.0 + 0.01 * k)) + outlier;
  }
  for (const RobustKind kind : {RobustKind::huber, RobustKind::bisquare}) {
    // Far below the deviations, so that two ways to the same end agree.
    const Robust options = {.kind = kind, .tuning = {}, .max_rounds = 500, .tolerance = 1e-12};
    const Identification found =
        identify(robot, log, Ols{.signal = plain_rows(), .covariance = classical, .robust = options});
    const std::string which(name(kind));
    ASSERT_EQ(found.status, Status::identified) << which;
    constexpr double same = 1e-8;  // relative; iterations end there
    for (Index i = 0; i < 3; ++i) {
      const double chi = oracle(which, "chi", static_cast<double>(i));
      const double sigma = oracle(which, "sigma", static_cast<double>(i));
      EXPECT_NEAR(found.chi[i], chi, same * std::abs(chi)) << which << ' ' << i;
      EXPECT_NEAR(std::sqrt(found.C_chi(i, i)), sigma, same * sigma) << which << ' ' << i;
    }
    ASSERT_TRUE(found.robust);
    const RobustJoint& joint = found.robust->joints.front();
    EXPECT_NEAR(joint.scale, oracle(which, "scale", 0), same);
    EXPECT_EQ(static_cast<double>(joint.below_half), oracle(which, "below_half", 0));
    EXPECT_EQ(static_cast<double>(joint.rejected), oracle(which, "rejected", 0));
  }
}

// Σ_j ω_j² W_jᵀ ψ(ρ_j / s_j) s_j = 0, ω = 1 or 1/s, over the rows of two logs.
TEST(RobustLeastSquares, SolvesItsEquations) {
  Experiment experiment(scara());
  const Eigen::Vector2d sigma(0.2, 0.05);
  std::vector<Log> logs;
  for (const std::uint64_t seed : {1U, 2U}) {
    experiment.disturb(errors(seed, sigma, 0.1, 20.0));
    logs.push_back(experiment.log);
  }
  SignalOptions signal = plain_rows();
  signal.decimation = {2};
  for (const RobustKind kind : {RobustKind::huber, RobustKind::bisquare}) {
    const Robust options = {.kind = kind, .tuning = {}, .max_rounds = 500, .tolerance = 1e-11};
    for (const bool by_joint : {false, true}) {
      const Identification found =
          by_joint ? identify(experiment.robot, logs, Wls{.signal = signal, .robust = options})
                   : identify(experiment.robot, logs, Ols{.signal = signal, .robust = options});
      ASSERT_EQ(found.status, Status::identified);
      Vector sum = Vector::Zero(found.base.size());
      Vector magnitudes = sum;
      for (std::size_t j = 0; j < 2; ++j) {
        const double s = found.robust->joints[j].scale;
        const double weight = by_joint ? 1.0 / s : 1.0;
        EXPECT_DOUBLE_EQ(found.weights[j], weight);
        std::vector<double> all;
        for (const Log& log : logs) {
          const Rows rows = rivid::rows(experiment.robot, found.base, log, signal);
          const JointRows& joint = rows.W.joints[j];
          const Vector rho = rows.Y[j] - joint.W * found.chi(joint.columns);
          all.insert(all.end(), rho.begin(), rho.end());
          for (Index k = 0; k < rho.size(); ++k) {
            const Vector term =
                weight * weight * options.loss().weight(rho[k] / s) * rho[k] * joint.W.row(k).transpose();
            sum(joint.columns) += term;
            magnitudes(joint.columns) += term.cwiseAbs();
          }
        }
        EXPECT_NEAR(robust_scale(all), s, 1e-8 * s);
      }
      constexpr double small = 1e-8;  // of the terms: the last round moved nothing by more than 1e-11 σ
      EXPECT_LT((sum.array() / magnitudes.array()).abs().maxCoeff(), small) << name(kind);
    }
  }
}

// With a tuning that no residual reaches, and one joint, nothing is robust any more.
TEST(RobustLeastSquares, OfAnEndlessTuningIsLeastSquares) {
  Experiment experiment(slider(Friction::symmetric));
  experiment.disturb(errors(5, Vector::Constant(1, 0.3), 0.05, 10.0));
  const Robust endless = {.kind = RobustKind::huber, .tuning = 1e9};
  for (const CovarianceKind kind : {CovarianceKind::classical, CovarianceKind::hac}) {
    const Identification plain =
        identify(experiment.robot, experiment.log, Ols{.signal = plain_rows(), .covariance = {kind}});
    const Identification found =
        identify(experiment.robot, experiment.log,
                 Ols{.signal = plain_rows(), .covariance = {kind}, .robust = endless});
    constexpr double rounding = 1e-10;
    EXPECT_LT((found.chi - plain.chi).norm(), rounding * plain.chi.norm());
    EXPECT_LT((found.C_chi - plain.C_chi).norm(), rounding * plain.C_chi.norm());
    EXPECT_EQ(found.robust->joints[0].below_one, 0);
  }
}

TEST(RobustLeastSquares, IsTheSameWithAnyNumberOfThreads) {
  Experiment experiment(scara());
  experiment.disturb(errors(6, Eigen::Vector2d(0.2, 0.05), 0.1, 20.0));
  const Wls one = {.signal = plain_rows(), .robust = robust(RobustKind::bisquare)};
  Wls three = one;
  three.threads = 3;
  const Identification a = identify(experiment.robot, experiment.log, one);
  const Identification b = identify(experiment.robot, experiment.log, three);
  EXPECT_EQ(a.chi, b.chi);
  EXPECT_EQ(a.C_chi, b.C_chi);
}

// Forty torques are off by a hundred deviations in one direction, which carries the offset of least squares away.
TEST(RobustLeastSquares, TellsWhatItRejectsAndThatOutliersDecide) {
  Experiment experiment(slider(Friction::symmetric));
  Matrix error = errors(7, Vector::Constant(1, 0.1), 0.0, 1.0);
  constexpr Index outliers = 40;
  for (Index k = 0; k < outliers; ++k) {
    error(5 + 9 * k, 0) += 10.0;
  }
  experiment.disturb(error);
  const Identification found = identify(experiment.robot, experiment.log,
                                        Ols{.signal = plain_rows(), .robust = robust(RobustKind::bisquare)});
  EXPECT_EQ(found.title, "IDIM-OLS, bisquare");
  ASSERT_TRUE(found.robust);
  EXPECT_EQ(found.robust->joints[0].rejected, outliers);
  EXPECT_EQ(found.robust->parameter, "off1");
  EXPECT_GT(found.robust->largest_shift, 10.0);
  ASSERT_FALSE(found.warnings.empty());
  EXPECT_NE(found.warnings.front().find("outliers decide: weights on the rows move"), std::string::npos)
      << found.warnings.front();
  for (Index i = 0; i < found.base.size(); ++i) {
    EXPECT_LT(std::abs(found.chi[i] - experiment.truth[i]), 4.0 * std::sqrt(found.C_chi(i, i))) << i;
  }
}

TEST(RobustLeastSquares, OfPerfectRowsIsTheTruth) {
  const Experiment experiment(scara());
  for (const RobustKind kind : {RobustKind::huber, RobustKind::bisquare}) {
    const Identification found =
        identify(experiment.robot, experiment.log, Wls{.signal = plain_rows(), .robust = robust(kind)});
    EXPECT_LT((found.chi - experiment.truth).norm(), 1e-10) << name(kind);
  }
}

TEST(RobustLeastSquares, RefusesWhatCanNotBeMeant) {
  const Experiment experiment(slider());
  const auto refusal = [&](const Robust& options) -> std::string {
    try {
      static_cast<void>(
          identify(experiment.robot, experiment.log, Ols{.signal = plain_rows(), .robust = options}));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({.tuning = -1.0}), "identify(IDIM-OLS): robust: tuning is -1, must be positive");
  EXPECT_EQ(refusal({.max_rounds = 0}), "identify(IDIM-OLS): robust: max_rounds is 0, must be at least 1");
  EXPECT_EQ(refusal({.tolerance = 0.0}), "identify(IDIM-OLS): robust: tolerance is 0, must be positive");
}

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

// Efficiency of 95 % where errors are normal: the mean over the parameters of the ratio of mean squared errors. The errors
// of both estimates have a correlation of 0.97, so a ratio is good to 0.02 and their mean to less: four of these.
TEST(RobustStatistics, LoseFivePerCentWithoutOutliers) {
  Experiment experiment(scara());
  const Eigen::Vector2d sigma(0.2, 0.05);
  Study wls;
  Study huber;
  Study bisquare;
  for (int run = 0; run < study_runs; ++run) {
    experiment.disturb(errors(100 + static_cast<std::uint64_t>(run), sigma, 0.0, 1.0));
    const auto found = [&](std::optional<Robust> options) {
      return identify(experiment.robot, experiment.log,
                      Wls{.signal = plain_rows(), .covariance = classical, .robust = options});
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
  Experiment experiment(scara());
  const Eigen::Vector2d sigma(0.2, 0.05);
  for (const CovarianceKind covariance : {CovarianceKind::classical, CovarianceKind::hac}) {
    Study wls;
    std::array<Study, 2> studies;
    for (int run = 0; run < study_runs; ++run) {
      experiment.disturb(errors(1000 + static_cast<std::uint64_t>(run), sigma, 0.05, 20.0));
      const auto found = [&](std::optional<Robust> options) {
        return identify(experiment.robot, experiment.log,
                        Wls{.signal = plain_rows(), .covariance = {covariance}, .robust = options});
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

// Spikes in single samples of the torque. A row of a decimation by 20 reaches over some forty samples: with five spikes in
// a hundred samples hardly a row is without, and little is gained.
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
        return identify(scara_study.robot, log, Wls{.signal = signal, .robust = options});
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

// IDIM-IV with the SCARA of [RIV], whose torques are logged with spikes that its controller knew nothing of.
struct RobustIv : public ::testing::Test, public test::ScaraStudy {
  RobustIv() { encoder_noise = 2e-5; }

  [[nodiscard]] Iv method(std::optional<Robust> options) const {
    Iv out = iv();
    out.signal = {.rows = RowScheme::exact, .torque_held = true, .decimation = {4}};
    out.robust = options;
    return out;
  }
};

// Errors of rows that are nearly white, as the efficiency asks for: noise of the encoder, differenced twice, is not.
TEST_F(RobustIv, IsNearPlainIvWithoutOutliers) {
  encoder_noise = 0.0;
  constexpr int runs = 10;
  for (const CovarianceKind covariance : {CovarianceKind::classical, CovarianceKind::hac}) {
    for (const RobustKind kind : {RobustKind::huber, RobustKind::bisquare}) {
      Vector ratio = Vector::Zero(8);
      for (int run = 0; run < runs; ++run) {
        const Log log = this->log(1.0, static_cast<std::uint64_t>(11 + run));
        Iv plain_method = method({});
        plain_method.covariance.kind = covariance;
        Iv robust_method = plain_method;
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

TEST_F(RobustIv, OfAnEndlessTuningIsPlainIv) {
  const Log log = this->log(1.0, 12);
  Iv plain_method = method({});
  plain_method.weights = Iv::Weights::none;
  Iv endless = plain_method;
  endless.robust = Robust{.kind = RobustKind::huber, .tuning = 1e9};
  const Identification plain = identify(robot, log, plain_method);
  const Identification found = identify(robot, log, endless);
  const Vector sigma = plain.C_chi.diagonal().cwiseSqrt();
  // One more iterate of the same map, which had come to rest.
  EXPECT_LT(((found.chi - plain.chi).array() / sigma.array()).abs().maxCoeff(), 0.1);
  EXPECT_LT((found.C_chi.diagonal().cwiseSqrt() - sigma).norm(), 0.02 * sigma.norm());
}

TEST_F(RobustIv, RefusesThePrefilterBeside) {
  const Log log = this->log(1.0, 13);
  Iv both = method(robust(RobustKind::huber));
  both.prefilter = true;
  try {
    static_cast<void>(identify(robot, log, both));
    FAIL() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("prefilter and robust do not go together"), std::string::npos)
        << error.what();
  }
}

TEST_F(RobustIv, HoldsItsIntervalsWhereSpikesSpoilTheTorque) {
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

}  // namespace
}  // namespace rivid
