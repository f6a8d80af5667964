// Least squares from logs that were reduced to factors, against the same from the logs.

#include "rivid/identify/log_factors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "rivid/signal/filter.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

const Vector truth{{3.44, 0.03, 0.82, 0.062, 0.242, 0.014, 0.013, 0.137}};
const SignalOptions signal_options = {.torque_held = false, .decimation = {8}};

// A log of the SCARA whose torques have errors of a slow first-order process.
Log scara_log(std::uint64_t seed, double seconds = 20.0) {
  const Robot robot = test::scara();
  const auto samples = static_cast<Index>(seconds * 200.0) + 1;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> phase(0.0, 6.0);
  Log log;
  log.source = "made_" + std::to_string(seed) + ".csv";
  log.f_m = 200.0;
  log.t = Vector::LinSpaced(samples, 0.0, seconds);
  log.q.resize(samples, 2);
  log.q.col(0) =
      (2.0 * log.t.array() + phase(random)).sin() + 0.5 * (5.3 * log.t.array() + phase(random)).sin();
  log.q.col(1) =
      (3.1 * log.t.array() + phase(random)).cos() + 0.7 * (7.7 * log.t.array() + phase(random)).sin();
  const Observation W = observation(robot, base_parameters(robot), differentiate(log.q, log.f_m));
  log.tau = (W.dense() * truth).reshaped(samples, 2);
  for (Index j = 0; j < 2; ++j) {
    double error = 0.0;
    for (Index k = 0; k < samples; ++k) {
      error = 0.95 * error + 0.05 * normal(random);
      log.tau(k, j) += (j == 0 ? 1.0 : 0.2) * error;
    }
  }
  return log;
}

std::vector<Log> scara_logs(int count) {
  std::vector<Log> out;
  for (int k = 0; k < count; ++k) {
    out.push_back(scara_log(static_cast<std::uint64_t>(k + 1)));
  }
  return out;
}

LogFactors merged_factors(std::span<const Log> logs, int blocks = 10) {
  const Robot robot = test::scara();
  LogFactors out = log_factors(robot, logs.front(), signal_options, blocks);
  for (const Log& log : logs.subspan(1)) {
    merge(out, log_factors(robot, log, signal_options, blocks));
  }
  return out;
}

template <typename Method>
class FactorsOf : public ::testing::Test {};
using FactorMethods = ::testing::Types<Ols, Wls>;
TYPED_TEST_SUITE(FactorsOf, FactorMethods);

TYPED_TEST(FactorsOf, LogsMergedOneByOneHaveTheEstimateOfTheLogsBitByBit) {
  const std::vector<Log> logs = scara_logs(3);
  const Estimation estimation = {.method = TypeParam{}, .signal = signal_options};
  const Identification together = identify(test::scara(), logs, estimation);
  const Identification merged = identify(test::scara(), merged_factors(logs), estimation);
  EXPECT_EQ(merged.status, Status::identified);
  EXPECT_EQ(merged.chi, together.chi);
  EXPECT_EQ(merged.weights, together.weights);
  EXPECT_EQ(merged.fit.relative_error, together.fit.relative_error);
  EXPECT_EQ(merged.fit.sigma_rho, together.fit.sigma_rho);
  EXPECT_EQ(merged.fit.joints[1].left_out, together.fit.joints[1].left_out);
  EXPECT_EQ(merged.condition, together.condition);
}

TYPED_TEST(FactorsOf, LogsMergedInATreeHaveTheEstimateToRounding) {
  const std::vector<Log> logs = scara_logs(5);
  const Robot robot = test::scara();
  const Estimation estimation = {.method = TypeParam{}, .signal = signal_options};
  LogFactors left = merged_factors(std::span(logs).first(2));
  LogFactors right = merged_factors(std::span(logs).subspan(2, 2));
  merge(right, log_factors(robot, logs[4], signal_options));
  merge(right, left);
  const Identification together = identify(robot, logs, estimation);
  const Identification merged = identify(robot, right, estimation);
  // A least-squares solution: 10 ε κ ‖χ‖.
  const double rounding = 10.0 * 2.3e-16 * together.condition * together.chi.norm();
  EXPECT_LT((merged.chi - together.chi).norm(), rounding);
}

TEST(LogFactors, ClassicalDeviationsAreThoseOfTheLogs) {
  const std::vector<Log> logs = scara_logs(2);
  const Estimation estimation = {
      .method = Wls{}, .signal = signal_options, .covariance = {.kind = CovarianceKind::classical}};
  EXPECT_EQ(identify(test::scara(), merged_factors(logs), estimation).C_chi,
            identify(test::scara(), logs, estimation).C_chi);
}

// Blocks are those of the logs themselves, and half of each deviation comes from them.
TEST(LogFactors, DeviationsByBlocksAreNearThoseWithTheResiduals) {
  const std::vector<Log> logs = scara_logs(12);
  const Estimation estimation = {.method = Wls{}, .signal = signal_options};
  const Identification together = identify(test::scara(), logs, estimation);
  const Identification merged = identify(test::scara(), merged_factors(logs, 1), estimation);
  EXPECT_EQ(merged.covariance.kind, CovarianceKind::blocks);
  EXPECT_EQ(merged.covariance.blocks, 12);
  // Errors last 20 samples, rows are 8 apart: classical deviations are far too short, blocks know.
  EXPECT_GT(merged.covariance.block_ratio, 1.3);
  for (std::size_t i = 0; i < merged.parameters.size(); ++i) {
    EXPECT_NEAR(merged.parameters[i].sigma / together.parameters[i].sigma, 1.0, 0.25)
        << merged.parameters[i].name;
  }
}

// 95 % intervals of 60 merged identifications hold the truth as often as they say, within 4 binomial σ of all
// parameters taken as independent by half.
TEST(LogFactors, IntervalsByBlocksHoldTheTruth) {
  constexpr int studies = 60;
  int held = 0;
  int all = 0;
  for (int study = 0; study < studies; ++study) {
    std::vector<Log> logs;
    for (int k = 0; k < 4; ++k) {
      logs.push_back(scara_log(static_cast<std::uint64_t>(1000 + 4 * study + k), 10.0));
    }
    const Identification found =
        identify(test::scara(), merged_factors(logs, 4), {.method = Wls{}, .signal = signal_options});
    for (Index i = 0; i < truth.size(); ++i) {
      const auto& [low, high] = found.parameters[static_cast<std::size_t>(i)].interval_95;
      held += low <= truth[i] && truth[i] <= high ? 1 : 0;
      ++all;
    }
  }
  const double share = static_cast<double>(held) / all;
  const double sigma = std::sqrt(0.95 * 0.05 / (0.5 * all));
  EXPECT_GT(share, 0.95 - 4.0 * sigma);
  EXPECT_LT(share, 0.95 + 4.0 * sigma);
}

TEST(LogFactors, DoNotGrowWithTheNumberOfLogs) {
  const Robot robot = test::scara();
  const LogFactors one = log_factors(robot, scara_log(1), signal_options);
  LogFactors many = one;
  Index rows = 0;
  for (int k = 0; k < 99; ++k) {
    merge(many, one);
  }
  EXPECT_EQ(many.logs, 100);
  EXPECT_EQ(std::ssize(many.blocks), LogFactors::most_blocks);
  Index largest = 0;
  Index smallest = many.rows.groups.front().qr.rows();
  for (const std::vector<RowGroup>& block : many.blocks) {
    const Index own = block[0].qr.rows();
    rows += own;
    largest = std::max(largest, own);
    smallest = std::min(smallest, own);
  }
  EXPECT_EQ(rows, 100 * one.rows.groups[0].qr.rows());
  EXPECT_LT(largest, 8 * smallest) << "blocks of very different lengths";
}

TEST(LogFactors, RowsAreChosenAsIdentifyChoosesThem) {
  const std::vector<Log> logs = scara_logs(2);
  const Estimation open = {.method = Wls{}};
  const Identification found = identify(test::scara(), logs, open);
  const SignalOptions chosen = chosen_signal(test::scara(), logs, open);
  EXPECT_EQ(chosen.decimation, found.estimation.signal.decimation);
  EXPECT_EQ(chosen.velocity_threshold, found.estimation.signal.velocity_threshold);
  EXPECT_EQ(chosen.torque_held, found.estimation.signal.torque_held);
}

TEST(LogFactors, RefuseWhatNeedsSamples) {
  const Robot robot = test::scara();
  const Log log = scara_log(1);
  const LogFactors factors = log_factors(robot, log, signal_options);
  const auto complaint = [&](const Estimation& estimation) {
    return test::complaint_of([&] { return identify(robot, factors, estimation); });
  };
  EXPECT_TRUE(test::says(complaint({.method = Iv{}, .signal = signal_options}), "instrumental variables"));
  EXPECT_TRUE(
      test::says(complaint({.method = Wls{}, .signal = signal_options, .robust = Robust{}}), "robust"));
  EXPECT_TRUE(test::says(
      complaint({.method = Wls{}, .signal = signal_options, .covariance = {.kind = CovarianceKind::hac}}),
      "hac"));
  EXPECT_TRUE(test::says(test::complaint_of([&] { return log_factors(robot, log, {}); }), "chosen_signal"));
  EXPECT_TRUE(test::says(test::complaint_of([&] { return log_factors(robot, log, signal_options, 0); }),
                         "blocks is 0"));
  Robot other = robot;
  other.joints[0].friction = Friction::asymmetric;
  const LogFactors theirs = log_factors(other, log, signal_options);
  EXPECT_TRUE(test::says(test::complaint_of([&] {
                           LogFactors into = factors;
                           merge(into, theirs);
                           return into.logs;
                         }),
                         "different robots"));
}

}  // namespace
}  // namespace rivid
