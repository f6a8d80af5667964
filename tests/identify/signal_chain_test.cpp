#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rivid/data/adjust.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/model/urdf.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// Two joints that swing, noise-free, 10 s at 200 Hz, with torques of no meaning.
Log swinging_log(Index samples = 2001) {
  Log log;
  log.source = "swing.csv";
  log.f_m = 200.0;
  log.t = Vector::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) / log.f_m);
  log.q.resize(samples, 2);
  log.q.col(0) = (2.0 * log.t.array()).sin();
  log.q.col(1) = (3.0 * log.t.array()).cos();
  log.tau = 10.0 * log.q;
  return log;
}

std::string refusal(const SignalOptions& options, const Log& log = swinging_log()) {
  const Robot robot = test::scara();
  return test::complaint_of([&] { return rows(robot, base_parameters(robot), log, options); });
}

TEST(Effort, IsTheControlSignalTimesGainAndGearUnlessTorquesAreRecorded) {
  Robot robot = test::scara();
  robot.joints[0].drive_gain = 3.0;
  robot.joints[1].gear_ratio = 50.0;
  Log log = swinging_log();
  EXPECT_EQ(effort(robot, log), log.tau);
  log.v_tau = Matrix::Ones(log.samples(), 2);
  log.tau.resize(0, 0);
  EXPECT_EQ(effort(robot, log).row(7), (Eigen::RowVector2d{3.0, 50.0}));
  log.v_tau.resize(0, 0);
  EXPECT_THROW((void)effort(robot, log), InputError);
}

TEST(Rows, AreLeftAloneWithEveryStepSwitchedOff) {
  const Robot robot = test::scara();
  const BaseParameters base = base_parameters(robot);
  const Log log = swinging_log();
  const Rows all = rows(robot, base, log, {.rows = RowScheme::paper, .trim = {{0, 0}}});
  EXPECT_EQ(all.Y[0], log.tau.col(0));
  EXPECT_EQ(all.W.joints[0].W.rows(), log.samples());
  EXPECT_EQ(all.samples[1].back(), log.samples() - 1);
  EXPECT_EQ(all.left_out, (std::vector<Index>{0, 0}));
}

TEST(Rows, AreTrimmedAtEachEndBeforeDecimation) {
  const Robot robot = test::scara();
  const Rows kept = rows(robot, base_parameters(robot), swinging_log(),
                         {.rows = RowScheme::paper, .decimation = {10}, .trim = {{49, 30}}});
  EXPECT_EQ(kept.samples[0].front(), 49);
  EXPECT_EQ(kept.samples[0][1], 59);
  EXPECT_EQ(kept.Y[0].size(), (2001 - 49 - 30 + 9) / 10);
}

TEST(Rows, AreTrimmedByTheSettlingTimeOfTheFilterIfNothingElseIsSaid) {
  const Robot robot = test::scara();
  const auto first = [&](double cutoff_hz) {
    return rows(robot, base_parameters(robot), swinging_log(),
                {.rows = RowScheme::paper, .cutoff_hz = cutoff_hz})
        .samples[0]
        .front();
  };
  EXPECT_EQ(first(0.0), 2) << "two central differences reach two samples far";
  EXPECT_GT(first(5.0), first(20.0));
}

TEST(Rows, OutsideOfTheTimeWindowAreDropped) {
  const Robot robot = test::scara();
  const Rows kept = rows(robot, base_parameters(robot), swinging_log(),
                         {.rows = RowScheme::paper, .trim = {{0, 0}}, .window = {{2.0, 8.0}}});
  // As of a log cut there, whose ends have no central differences.
  EXPECT_EQ(kept.samples[0].front(), 402);
  EXPECT_EQ(kept.samples[0].back(), 1598);
}

TEST(Rows, OfAJointAreLeftOutWhereItIsSlow) {
  const Robot robot = test::scara();
  const Log log = swinging_log();
  const Rows kept = rows(robot, base_parameters(robot), log,
                         {.rows = RowScheme::paper, .trim = {{2, 2}}, .velocity_threshold = {1.0, 0.0}});
  // |2 cos 2t| < 1 for a third of the time.
  EXPECT_NEAR(static_cast<double>(kept.left_out[0]) / 1997.0, 1.0 / 3.0, 0.02);
  EXPECT_EQ(kept.left_out[1], 0);
  for (const Index k : kept.samples[0]) {
    EXPECT_GE(std::abs(2.0 * std::cos(2.0 * log.t[k])), 0.999);
  }
  EXPECT_EQ(kept.Y[0].size(), kept.W.joints[0].W.rows());
  EXPECT_EQ(static_cast<Index>(kept.samples[0].size()), kept.Y[0].size());
}

TEST(Rows, OfSeveralDecimationStagesAreThoseOfTheirProduct) {
  const Robot robot = test::scara();
  const Rows kept = rows(robot, base_parameters(robot), swinging_log(),
                         {.rows = RowScheme::paper, .decimation = {5, 4}, .trim = {{0, 0}}});
  EXPECT_EQ(kept.samples[0][3], 60);
  EXPECT_EQ(kept.Y[0].size(), 101);
}

TEST(Rows, ThatCanNotBeMadeAreRefusedWithTheCulprit) {
  EXPECT_EQ(refusal({.cutoff_hz = 150.0}), "swing.csv: cutoff_hz is 150 Hz, must lie below f_m / 2 = 100 Hz");
  EXPECT_EQ(refusal({.cutoff_hz = -1.0}), "rows: cutoff_hz is -1, must be positive, or 0 for no filter");
  EXPECT_EQ(refusal({.decimation = {0}}), "rows: decimation is 0, must be at least 1");
  EXPECT_EQ(
      refusal({.trim = {{2000, 1}}}),
      "swing.csv: no row is left of 2001 samples after trimming 2000 at the beginning and 1 at the end");
  EXPECT_EQ(
      refusal({.trim = {{0, 0}}, .window = {{20.0, 30.0}}}),
      "swing.csv: no row is left of 2001 samples after trimming 0 at the beginning and 0 at the end and the "
      "time window 20 to 30 s (the log spans 0 to 10 s)");
  EXPECT_EQ(refusal({.rows = RowScheme::paper, .velocity_threshold = {9.0, 0.0}}),
            "swing.csv: joint \"joint_1\" never moves faster than velocity_threshold 9; no row is left");
  EXPECT_EQ(refusal({.velocity_threshold = {1.0}}),
            "rows: velocity_threshold has 1 entries, must have one for each of the 2 joints");
  Log log = swinging_log();
  log.q.conservativeResize(Eigen::NoChange, 1);
  EXPECT_EQ(
      refusal({}, log),
      "swing.csv: position has 1 columns of 2001 samples, must have one for each of the 2 joints of robot "
      "\"scara\" and 2001 samples");
}

// Values by SciPy 1.17 (sosfiltfilt with butter(4, 20 Hz), two central differences, sosfiltfilt with
// cheby1(8, 0.05, 0.8 / 14) of Y and every column, Y being the mean of the control signal at this sample and
// the one before), on data/scara/scara_s2.csv at sample 1420, t = 7.1 s, far from the borders. The digits are
// those SciPy printed; its Chebyshev filter has a gain of -0.05 dB at rest in each direction, which
// Convention::standard takes out.
TEST(Rows, OfTheScaraAreThoseOfSciPy) {
  Robot robot = read_urdf(RIVID_DATA "/scara/scara.urdf");
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::coulomb;
    joint.rotor_inertia = false;
  }
  const Log log = shift_torque(read_csv(RIVID_DATA "/scara/scara_s2.csv"), -0.5);
  const Rows found =
      rows(robot, base_parameters(robot), log,
           {.rows = RowScheme::paper, .cutoff_hz = 20.0, .order = 4, .decimation = {14}, .trim = {{19, 20}}});
  constexpr Index row = 100;
  ASSERT_EQ(found.samples[0][row], 1419) << "the shifted log begins one sample later";
  constexpr double printed = 1e-7;
  const double at_rest = std::pow(10.0, -2.0 * 0.05 / 20.0);
  const Vector W1{{0.6249596, 0.7197639, 1.0058202, -3.8807534, -0.9270035, 3.7141072}};
  const Vector W2{{-3.8807534, -0.0783322, -0.4002955, 1.9887978, 0.9802296}};
  EXPECT_LT((at_rest * found.W.joints[0].W.row(row).transpose() - W1).cwiseAbs().maxCoeff(), printed)
      << found.W.joints[0].W.row(row);
  EXPECT_LT((at_rest * found.W.joints[1].W.row(row).transpose() - W2).cwiseAbs().maxCoeff(), printed)
      << found.W.joints[1].W.row(row);
  EXPECT_NEAR(at_rest * found.Y[0][row], 2.5613121, printed);
  EXPECT_NEAR(at_rest * found.Y[1][row], -0.0989196, printed);
}

}  // namespace
}  // namespace rivid
