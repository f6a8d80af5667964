#include "rivid/identify/robust.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>
#include <stdexcept>

#include "rivid/identify/identification.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"
#include "support/robust_study.hpp"

namespace rivid {
namespace {

using test::errors;
using test::plain_rows;
using test::robust;
using test::scara;
using test::SineExperiment;
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

constexpr CovarianceOptions classical = {CovarianceKind::classical};

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
    const Identification found = identify(
        robot, log, {.method = Ols{}, .signal = plain_rows(), .covariance = classical, .robust = options});
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
  SineExperiment experiment(scara());
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
          by_joint ? identify(experiment.robot, logs, {.method = Wls{}, .signal = signal, .robust = options})
                   : identify(experiment.robot, logs, {.method = Ols{}, .signal = signal, .robust = options});
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
  SineExperiment experiment(slider(Friction::symmetric));
  experiment.disturb(errors(5, Vector::Constant(1, 0.3), 0.05, 10.0));
  const Robust endless = {.kind = RobustKind::huber, .tuning = 1e9};
  for (const CovarianceKind kind : {CovarianceKind::classical, CovarianceKind::hac, CovarianceKind::blocks}) {
    const Identification plain = identify(experiment.robot, experiment.log,
                                          {.method = Ols{}, .signal = plain_rows(), .covariance = {kind}});
    const Identification found =
        identify(experiment.robot, experiment.log,
                 {.method = Ols{}, .signal = plain_rows(), .covariance = {kind}, .robust = endless});
    constexpr double rounding = 1e-10;
    EXPECT_LT((found.chi - plain.chi).norm(), rounding * plain.chi.norm());
    EXPECT_LT((found.C_chi - plain.C_chi).norm(), rounding * plain.C_chi.norm());
    EXPECT_EQ(found.covariance.kind, kind);
    EXPECT_EQ(found.robust->joints[0].below_one, 0);
  }
}

TEST(RobustLeastSquares, IsTheSameWithAnyNumberOfThreads) {
  SineExperiment experiment(scara());
  experiment.disturb(errors(6, Eigen::Vector2d(0.2, 0.05), 0.1, 20.0));
  const Estimation one = {.method = Wls{}, .signal = plain_rows(), .robust = robust(RobustKind::bisquare)};
  Estimation three = one;
  three.threads = 3;
  const Identification a = identify(experiment.robot, experiment.log, one);
  const Identification b = identify(experiment.robot, experiment.log, three);
  EXPECT_EQ(a.chi, b.chi);
  EXPECT_EQ(a.C_chi, b.C_chi);
}

// Forty torques are off by a hundred deviations in one direction, which carries the offset of least squares
// away.
TEST(RobustLeastSquares, TellsWhatItRejectsAndThatOutliersDecide) {
  SineExperiment experiment(slider(Friction::symmetric));
  Matrix error = errors(7, Vector::Constant(1, 0.1), 0.0, 1.0);
  constexpr Index outliers = 40;
  for (Index k = 0; k < outliers; ++k) {
    error(5 + 9 * k, 0) += 10.0;
  }
  experiment.disturb(error);
  const Identification found =
      identify(experiment.robot, experiment.log,
               {.method = Ols{}, .signal = plain_rows(), .robust = robust(RobustKind::bisquare)});
  EXPECT_EQ(found.title, "IDIM-OLS, bisquare");
  ASSERT_TRUE(found.robust);
  EXPECT_EQ(found.robust->joints[0].rejected, outliers);
  EXPECT_EQ(found.robust->parameter, "off1");
  EXPECT_GT(found.robust->largest_shift, 10.0);
  ASSERT_FALSE(found.warnings.empty());
  EXPECT_NE(found.warnings.front().text.find("outliers decide: weights on the rows move"), std::string::npos)
      << found.warnings.front().text;
  EXPECT_EQ(found.warnings.front().code, "outliers_decide");
  for (Index i = 0; i < found.base.size(); ++i) {
    EXPECT_LT(std::abs(found.chi[i] - experiment.truth[i]), 4.0 * std::sqrt(found.C_chi(i, i))) << i;
  }
}

TEST(RobustLeastSquares, OfPerfectRowsIsTheTruth) {
  const SineExperiment experiment(scara());
  for (const RobustKind kind : {RobustKind::huber, RobustKind::bisquare}) {
    const Identification found = identify(experiment.robot, experiment.log,
                                          {.method = Wls{}, .signal = plain_rows(), .robust = robust(kind)});
    EXPECT_LT((found.chi - experiment.truth).norm(), 1e-10) << name(kind);
  }
}

TEST(RobustLeastSquares, RefusesWhatCanNotBeMeant) {
  const SineExperiment experiment(slider());
  const auto refusal = [&](const Robust& options) -> std::string {
    return test::complaint_of([&] {
      return identify(experiment.robot, experiment.log,
                      {.method = Ols{}, .signal = plain_rows(), .robust = options});
    });
  };
  EXPECT_EQ(refusal({.tuning = -1.0}), "identify(IDIM-OLS): robust: tuning is -1, must be positive");
  EXPECT_EQ(refusal({.max_rounds = 0}), "identify(IDIM-OLS): robust: max_rounds is 0, must be at least 1");
  EXPECT_EQ(refusal({.tolerance = 0.0}), "identify(IDIM-OLS): robust: tolerance is 0, must be positive");
}

struct RobustIv : public ::testing::Test, public test::RobustScara {};

TEST_F(RobustIv, OfAnEndlessTuningIsPlainIv) {
  const Log log = this->log(1.0, 12);
  Estimation plain_method = method({});
  std::get<Iv>(plain_method.method).weights = Iv::Weights::none;
  plain_method.covariance.kind = CovarianceKind::hac;
  Estimation endless = plain_method;
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
  Estimation both = method(robust(RobustKind::huber));
  std::get<Iv>(both.method).prefilter = true;
  EXPECT_TRUE(test::says(test::complaint_of([&] { return identify(robot, log, both); }),
                         "prefilter and robust do not go together"));
}

}  // namespace
}  // namespace rivid
