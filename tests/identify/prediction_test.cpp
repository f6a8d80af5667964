#include "rivid/identify/prediction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "rivid/error.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/signal/filter.hpp"
#include "support/random_matrix.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// Two joints that swing, at 200 Hz, with torques of no meaning.
Log swinging_log() {
  constexpr Index samples = 2011;
  Log log;
  log.source = "swing.csv";
  log.f_m = 200.0;
  log.t = Vector::LinSpaced(samples, 3.0, 3.0 + static_cast<double>(samples - 1) / log.f_m);
  log.q.resize(samples, 2);
  log.q.col(0) = (2.0 * log.t.array()).sin() + 0.3 * (7.1 * log.t.array()).cos();
  log.q.col(1) = (3.0 * log.t.array()).cos() + 0.2 * (9.3 * log.t.array()).sin();
  log.tau = 10.0 * log.q + test::random_matrix(samples, 2, 11);
  return log;
}

// All that predict() asks of an identification.
Identification some_result(const Robot& robot, const SignalOptions& signal) {
  Identification out;
  out.base = base_parameters(robot);
  out.estimation.signal = signal;
  out.chi = Vector::LinSpaced(out.base.size(), -1.0, 2.0);
  return out;
}

std::vector<SignalOptions> ways() {
  return {
      {.rows = RowScheme::paper, .trim = {{0, 0}}},
      {.rows = RowScheme::paper, .cutoff_hz = 20.0, .velocity_threshold = {0.8, 0.1}},
      {.rows = RowScheme::paper, .cutoff_hz = 20.0, .decimation = {5, 4}, .velocity_threshold = {0.0, 0.5}},
      {.cutoff_hz = 20.0},
      {.torque_held = true, .cutoff_hz = 20.0, .decimation = {10}},
      {.decimation = {20}, .window = {{5.0, 9.0}}},
      {.cutoff_hz = 20.0, .decimation = {10}, .convention = Convention::matlab}};
}

Vector predicted(const Rows& rows, std::size_t joint, const Vector& chi) {
  return rows.W.joints[joint].W * chi(rows.W.joints[joint].columns);
}

// Sums of eight products in another order.
constexpr double rounding = 1e-12;

TEST(Prediction, HasTheResidualOfTheRowsOfTheFit) {
  const Robot robot = test::scara();
  const Log log = swinging_log();
  for (const SignalOptions& options : ways()) {
    const Identification result = some_result(robot, options);
    const Prediction found = predict(robot, result, log);
    const Rows fit = rows(robot, result.base, log, options);
    const Index first = std::lround((found.start - log.t[0]) * log.f_m);
    for (std::size_t j = 0; j < 2; ++j) {
      const Vector residual = fit.Y[j] - predicted(fit, j, result.chi);
      ASSERT_EQ(found.joints[j].residual.size(), residual.size());
      EXPECT_LT((found.joints[j].residual - residual).norm(), rounding * fit.Y[j].norm());
      for (std::size_t k = 0; k < fit.samples[j].size(); ++k) {
        ASSERT_EQ(found.joints[j].rows[k] + first, fit.samples[j][k]);
      }
    }
  }
}

// The same log at the positions of each sample, one sample a row: what the robot's dynamics say there, part
// by part.
TEST(Prediction, SplitsTorquesAsTheDynamicsDo) {
  Robot robot = test::scara();
  robot.chain.gravity = {3.0, -9.0, 1.0};
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::symmetric;
  }
  Identification result = some_result(robot, {.rows = RowScheme::paper, .trim = {{2, 2}}});
  robot.inertials[1] = Inertial::LinSpaced(0.1, 1.0);
  robot.joints[0].Fc = 0.75;
  const Log log = swinging_log();
  const Prediction found = predict(robot, result, log);
  const Motion motion = differentiate(log.q, log.f_m);
  const auto torques = [&](double speed, double acceleration, const Vector& chi) -> Matrix {
    const Motion at{motion.q, speed * motion.qd, acceleration * motion.qdd};
    return (observation(robot, result.base, at).dense() * chi).reshaped(log.samples(), 2);
  };
  Vector rigid = result.chi;
  for (Index i = 0; i < rigid.size(); ++i) {
    const std::string& name = result.base.parameters[static_cast<std::size_t>(i)].name;
    if (name.starts_with("F") || name.starts_with("off")) {
      rigid[i] = 0.0;
    }
  }
  const Vector a_priori = result.base.from_standard(robot.chi_st());
  const Matrix gravity = torques(0.0, 0.0, rigid);
  const Matrix inertia = torques(0.0, 1.0, rigid) - gravity;
  const Matrix coriolis = torques(1.0, 0.0, rigid) - gravity;
  const Matrix friction = torques(1.0, 1.0, result.chi - rigid);
  const Matrix expected = torques(1.0, 1.0, a_priori);
  for (Index j = 0; j < 2; ++j) {
    const FittedRows& rows = found.joints[static_cast<std::size_t>(j)].fitted;
    const Index count = rows.measured.size();
    ASSERT_EQ(count, log.samples() - 4);
    const auto of_fit = [&](const Matrix& series) { return series.col(j).segment(2, count); };
    const double bound = rounding * rows.predicted().norm();
    EXPECT_GT(of_fit(gravity).norm(), 1.0);
    EXPECT_LT((rows.gravity - of_fit(gravity)).norm(), bound);
    EXPECT_LT((rows.inertia - of_fit(inertia)).norm(), bound);
    EXPECT_LT((rows.coriolis - of_fit(coriolis)).norm(), bound);
    EXPECT_LT((rows.friction - of_fit(friction)).norm(), bound);
    EXPECT_LT((rows.a_priori - of_fit(expected)).norm(), bound);
    EXPECT_LT((rows.velocity - of_fit(motion.qd)).norm(), bound);
    EXPECT_EQ(rows.measured, of_fit(log.tau));
  }
}

TEST(Prediction, PartsOfTorquesAddUpAndColumnsHaveTheirRootMeanSquare) {
  Robot robot = test::scara();
  robot.chain.gravity = {3.0, -9.0, 1.0};
  const Log log = swinging_log();
  for (const SignalOptions& options : ways()) {
    const Identification result = some_result(robot, options);
    const Prediction found = predict(robot, result, log);
    const Rows fit = rows(robot, result.base, log, options);
    for (std::size_t j = 0; j < 2; ++j) {
      const auto& [columns, W] = fit.W.joints[j];
      const FittedRows& parts = found.joints[j].fitted;
      EXPECT_LT((parts.measured - fit.Y[j]).norm(), rounding * fit.Y[j].norm());
      EXPECT_LT((parts.predicted() - W * result.chi(columns)).norm(), rounding * parts.predicted().norm());
      for (std::size_t c = 0; c < columns.size(); ++c) {
        const double rms = W.col(static_cast<Index>(c)).norm() / std::sqrt(static_cast<double>(W.rows()));
        EXPECT_NEAR(parts.column_rms[columns[c]], rms, rounding * rms);
      }
    }
  }
}

// q = ½ t² moves at t, and its mean over 5 samples to either side is ½ t² + ½ · 10 / f².
TEST(Prediction, HasTheMeanMotionOfItsRows) {
  const Robot robot = test::scara();
  Log log = swinging_log();
  log.q.col(0) = 0.5 * log.t.array().square();
  log.q.col(1) = log.t;
  const Prediction found =
      predict(robot, some_result(robot, {.rows = RowScheme::exact, .decimation = {10}}), log);
  const JointPrediction& joint = found.joints[0];
  ASSERT_GT(joint.rows.size(), 100U);
  for (std::size_t k = 0; k < joint.rows.size(); ++k) {
    const double t = found.start + static_cast<double>(joint.rows[k]) / log.f_m;
    const auto row = static_cast<Index>(k);
    EXPECT_NEAR(joint.fitted.velocity[row], t, 1e-9);
    // The averages of exact rows add 1 / f² at most.
    EXPECT_NEAR(joint.fitted.position[row], 0.5 * t * t + 5.0 / (200.0 * 200.0), 1.0 / (200.0 * 200.0));
  }
}

TEST(Prediction, HasEverySampleAndTellsThoseThatTheFitLeavesOut) {
  const Robot robot = test::scara();
  const Log log = swinging_log();
  for (const SignalOptions& options : ways()) {
    const Identification result = some_result(robot, options);
    const Prediction found = predict(robot, result, log);
    SignalOptions plain = options;
    plain.decimation.clear();
    const Rows every = rows(robot, result.base, log, plain);
    const Index first = std::lround((found.start - log.t[0]) * log.f_m);
    for (std::size_t j = 0; j < 2; ++j) {
      const JointPrediction& joint = found.joints[j];
      const Vector torque = predicted(every, j, result.chi);
      ASSERT_EQ(joint.measured.size(), every.Y[j].size() + every.left_out[j]);
      ASSERT_EQ(joint.kept.size(), static_cast<std::size_t>(joint.measured.size()));
      EXPECT_TRUE(joint.measured.allFinite() && joint.predicted.allFinite());
      EXPECT_EQ(std::ranges::count(joint.kept, 1), every.Y[j].size());
      for (std::size_t k = 0; k < every.samples[j].size(); ++k) {
        const Index at = every.samples[j][k] - first;
        const auto row = static_cast<Index>(k);
        ASSERT_EQ(joint.kept[static_cast<std::size_t>(at)], 1);
        ASSERT_EQ(joint.measured[at], every.Y[j][row]);
        ASSERT_NEAR(joint.predicted[at], torque[row], rounding * torque.lpNorm<Eigen::Infinity>());
      }
    }
  }
}

TEST(Prediction, IsNoNumberWhereTheParametersAreNone) {
  const Robot robot = test::scara();
  Identification result = some_result(robot, {.cutoff_hz = 20.0, .decimation = {10}});
  result.chi.setConstant(std::numeric_limits<double>::quiet_NaN());
  const Prediction found = predict(robot, result, swinging_log());
  EXPECT_TRUE(found.joints[0].measured.allFinite());
  EXPECT_TRUE(found.joints[0].predicted.array().isNaN().all());
  EXPECT_TRUE(found.joints[1].residual.array().isNaN().all());
}

TEST(Prediction, RefusesALogOfAnotherRobot) {
  const Robot robot = test::scara();
  Log log = swinging_log();
  log.q = log.q.leftCols(1).eval();
  EXPECT_THROW((void)predict(robot, some_result(robot, {}), log), InputError);
}

}  // namespace
}  // namespace rivid
