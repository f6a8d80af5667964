#include "rivid/data/time_stamps.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "support/complaint.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;

constexpr double period = 0.01;

std::vector<double> uniform(int samples, double start = 0.0) {
  std::vector<double> t;
  for (int k = 0; k < samples; ++k) {
    t.push_back(start + period * k);
  }
  return t;
}

Vector vector(const std::vector<double>& t) {
  return Eigen::Map<const Vector>(t.data(), static_cast<Index>(t.size()));
}

Vector jittered(int samples, double deviation, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> noise(0.0, deviation * period);
  Vector t = vector(uniform(samples));
  for (double& value : t) {
    value += noise(generator);
  }
  return t;
}

Log log_at(const Vector& t) {
  Log log;
  log.source = "run1.csv";
  log.t = t;
  log.f_m = 1.0 / period;
  log.q.resize(t.size(), 2);
  log.q << t.array().sin(), t.array().cos();
  log.tau.resize(t.size(), 2);
  log.tau << t, 2.0 * t;
  log.lines.runs = {{0, 2}};
  return log;
}

TEST(InspectTime, FindsAUniformClockRegular) {
  const TimeReport report = inspect_time(vector(uniform(1000, 1.7e9)));  // time since 1970
  EXPECT_TRUE(report.regular);
  EXPECT_NEAR(report.period, period, 1e-6);
  EXPECT_NEAR(report.rate_hz, 100.0, 1e-3);
  EXPECT_LT(report.jitter_max, 1e-4);
  EXPECT_TRUE(says(inspect_time(vector(uniform(1000))).summary(),
                   "1000 samples at 100 Hz; jitter 0 % rms, 0 % at most"));
}

TEST(InspectTime, CountsFaultsAndTellsTheFirst) {
  std::vector<double> t = uniform(100);
  t[30] = t[29];
  t.erase(t.begin() + 60, t.begin() + 63);
  t.erase(t.begin() + 80);
  for (std::size_t i = 90; i < t.size(); ++i) {
    t[i] += 5.0;
  }
  t.insert(t.begin() + 10, {t[5], t[5]});
  const TimeReport report = inspect_time(vector(t));
  EXPECT_FALSE(report.regular);
  EXPECT_EQ(report.samples, 98);
  EXPECT_EQ(report.reversed.count, 1);
  EXPECT_EQ(report.reversed.row, 10);
  EXPECT_DOUBLE_EQ(report.reversed.time, 0.05);
  EXPECT_EQ(report.repeated.count, 2);
  EXPECT_EQ(report.repeated.row, 11);
  EXPECT_EQ(report.missing.count,
            4);  // behind the rows put in, behind the repeated one, and twice rows taken out
  EXPECT_EQ(report.missing_rows, 4 + 1 + 3 + 1);
  EXPECT_EQ(report.missing.row, 12);
  EXPECT_EQ(report.jumps.count, 1);
  EXPECT_EQ(report.jumps.row, 92);
  EXPECT_LT(report.jitter_max, 1e-9);
  const std::string summary = report.summary();
  EXPECT_TRUE(
      says(summary, "; 2 repeated (first at row 12, t = 0.05 s); 1 reversed (first at row 11, t = 0.05 s)"));
  EXPECT_TRUE(says(summary, "; 4 gaps of 9 missing rows (first at row 13"));
  EXPECT_TRUE(says(summary, "; 1 jump (first at row 93"));
}

TEST(InspectTime, TellsGapsFromJumpsByTheirLength) {
  std::vector<double> t = uniform(50);
  for (std::size_t i = 25; i < t.size(); ++i) {
    t[i] += 7.0 * period;
  }
  EXPECT_EQ(inspect_time(vector(t)).missing_rows, 7);
  EXPECT_EQ(inspect_time(vector(t), 5.0).jumps.count, 1);
  EXPECT_EQ(inspect_time(vector(t), 5.0).missing.count, 0);
}

TEST(InspectTime, MeasuresJitter) {
  constexpr std::uint64_t seed = 3;
  const TimeReport report = inspect_time(jittered(20000, 0.05, seed));
  EXPECT_NEAR(report.jitter_rms, 0.05, 0.05 * 4.0 / std::sqrt(2.0 * 20000.0)) << "seed " << seed;
  EXPECT_GT(report.jitter_max, 0.15);
  EXPECT_LT(report.shortest_step, 0.9 * period);
  EXPECT_GT(report.longest_step, 1.1 * period);
  EXPECT_TRUE(says(report.summary(), " % at most, steps of "));
  EXPECT_FALSE(report.regular);
  EXPECT_TRUE(inspect_time(jittered(20000, 0.005, seed)).regular) << "seed " << seed;
}

TEST(InspectTime, DoesNotLetOneLateRowHideInManyGoodOnes) {
  std::vector<double> t = uniform(100000);
  t[500] += 0.4 * period;
  const TimeReport report = inspect_time(vector(t));
  EXPECT_LT(report.jitter_rms, 0.01);
  EXPECT_NEAR(report.jitter_max, 0.4, 1e-3);
  EXPECT_FALSE(report.regular);
}

TEST(InspectTime, TakesNoDriftFromARoundedPeriod) {
  Vector t(100000);
  for (Index k = 0; k < t.size(); ++k) {
    t[k] = std::round(1e6 * static_cast<double>(k) / 3000.0) * 1e-6;
  }
  const TimeReport report = inspect_time(t);
  EXPECT_TRUE(report.regular);
  EXPECT_NEAR(report.rate_hz, 3000.0, 1e-3);
  EXPECT_LT(report.jitter_max, 0.002);
}

TEST(InspectTime, SurvivesDegenerateInput) {
  EXPECT_FALSE(inspect_time(Vector()).regular);
  EXPECT_FALSE(inspect_time(Vector::Zero(1)).regular);
  EXPECT_EQ(inspect_time(Vector::Zero(5)).repeated.count, 4);
  EXPECT_FALSE(inspect_time(Vector::LinSpaced(5, 1.0, 0.0)).regular);
  const Vector bad{{0.0, std::numeric_limits<double>::quiet_NaN()}};
  EXPECT_TRUE(
      says(complaint_of([&] { static_cast<void>(inspect_time(bad)); }), "t is nan at row 2, must be finite"));
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(inspect_time(bad, 1.0)); }),
                   "max_gap is 1 periods, must be at least 2"));
}

TEST(InspectTime, TellsNoJitterOfStampsThatAreNoSeconds) {
  for (const double step : {1e300, 5e-324, 1e-310, 1e13}) {
    const TimeReport report = inspect_time(Vector::LinSpaced(100, 0.0, 99.0 * step));
    EXPECT_FALSE(report.regular) << step;
    EXPECT_EQ(report.rate_hz, 0.0) << step;
    const std::string said = report.summary();
    EXPECT_TRUE(said.starts_with("100 samples; steps of ") && said.ends_with(" s")) << said;
    for (const char* const none : {"nan", "inf", "jitter"}) {
      EXPECT_FALSE(says(said, none)) << said;
    }
  }
}

TEST(Regularised, LeavesARegularLogAlone) {
  const Log log = log_at(vector(uniform(50)));
  for (const Irregular irregular : {Irregular::refuse, Irregular::resample, Irregular::ignore}) {
    const std::vector<Log> out = regularised(log, irregular);
    ASSERT_EQ(out.size(), 1U);
    EXPECT_EQ(out[0].t, log.t);
    EXPECT_EQ(out[0].q, log.q);
    EXPECT_TRUE(out[0].notes.empty());
  }
}

TEST(Regularised, RefusesWithThePlaceTheFindingAndTheRemedy) {
  std::vector<double> t = uniform(50);
  t[30] = t[29];
  const std::string message =
      complaint_of([&] { static_cast<void>(regularised(log_at(vector(t)), Irregular::refuse)); });
  EXPECT_TRUE(says(message, "run1.csv:32 (t = 0.29 s): the time stamps are irregular: 50 samples"));
  EXPECT_TRUE(says(message, "1 repeated (first at row 31, t = 0.29 s)"));
  EXPECT_TRUE(
      says(message, "resample the log, state its rate, or ignore the time stamps if only they are wrong"));
  EXPECT_TRUE(says(
      complaint_of([] { static_cast<void>(regularised(log_at(jittered(100, 0.1, 5)), Irregular::refuse)); }),
      "run1.csv: the time stamps are irregular: 100 samples"));
}

TEST(Regularised, IgnoresAndSaysSo) {
  std::vector<double> t = uniform(51);
  t.erase(t.begin() + 25);
  const Log log = log_at(vector(t));
  const Log mean = regularised(log, Irregular::ignore).at(0);
  EXPECT_NEAR(mean.f_m, 98.0, 1e-9);
  EXPECT_EQ(mean.q, log.q);
  EXPECT_NEAR(mean.t[49], 0.5, 1e-12);
  EXPECT_EQ(mean.complaint(), std::nullopt);
  EXPECT_TRUE(says(mean.notes.at(0),
                   "time stamps ignored, rows taken as samples at the mean rate of 98 Hz; found: 50"));
  const Log stated = regularised(log, Irregular::ignore, {.rate_hz = 100.0}).at(0);
  EXPECT_EQ(stated.f_m, 100.0);
  EXPECT_DOUBLE_EQ(stated.t[49], 0.49);
  EXPECT_TRUE(says(stated.notes.at(0), "at the stated 100 Hz"));
}

TEST(Regularised, ResamplesJitteredRowsToWhatTheySample) {
  constexpr std::uint64_t seed = 9;
  const Log log = log_at(jittered(500, 0.1, seed));
  const Log out = regularised(log, Irregular::resample, {.rate_hz = 50.0}).at(0);
  EXPECT_EQ(out.f_m, 50.0);
  EXPECT_EQ(out.t[0], log.t[0]);
  EXPECT_LE(out.t[out.samples() - 1], log.t[499]);
  EXPECT_NEAR(static_cast<double>(out.samples()), 250.0, 1.0);
  const auto error = [&](const Vector& got, const Vector& wanted) {
    return (got - wanted).cwiseAbs().maxCoeff();
  };
  // Spline of steps up to 2 periods: (5/384) h⁴ |q⁗|, somewhat more at the ends; tau is linear in t.
  EXPECT_LT(error(out.q.col(0), out.t.array().sin()), 2e-8) << "seed " << seed;
  EXPECT_LT(error(out.q.col(1), out.t.array().cos()), 2e-8) << "seed " << seed;
  EXPECT_LT(error(out.tau.col(1), 2.0 * out.t), 1e-12) << "seed " << seed;
  EXPECT_TRUE(out.lines.empty());
  EXPECT_EQ(out.complaint(), std::nullopt);
  EXPECT_TRUE(says(out.notes.at(1), "resampled to 50 Hz, positions by cubic spline, all else linearly"));
  EXPECT_TRUE(says(out.notes.at(2), "what lies above 25 Hz is folded"));
}

TEST(Regularised, KeepsTheFirstOfRepeatedStampsAndInterpolatesOverGaps) {
  std::vector<double> t = uniform(60);
  t.erase(t.begin() + 40, t.begin() + 42);
  t.insert(t.begin() + 20, t[19]);
  Log log = log_at(vector(t));
  log.q.row(20).setConstant(99.0);
  const Log out = regularised(log, Irregular::resample).at(0);
  EXPECT_NEAR(out.f_m, 100.0, 1e-9);
  ASSERT_EQ(out.samples(), 60);
  EXPECT_NEAR(out.q(40, 0), std::sin(0.4), 1e-7);
  EXPECT_LT(out.q.maxCoeff(), 1.1);
  EXPECT_TRUE(says(out.notes.at(2), "dropped 1 row with repeated time stamps"));
  EXPECT_TRUE(says(out.notes.at(3), "interpolated over 1 gap, 2 missing rows"));
}

TEST(Regularised, SplitsAtJumpsAndDropsShortPieces) {
  std::vector<double> t = uniform(100);
  for (const double value : uniform(5, 10.0)) {
    t.push_back(value);
  }
  for (const double value : uniform(70, 20.0)) {
    t.push_back(value);
  }
  const std::vector<Log> out = regularised(log_at(vector(t)), Irregular::resample);
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].samples(), 100);
  EXPECT_EQ(out[1].samples(), 70);
  EXPECT_EQ(out[1].t[0], 20.0);
  EXPECT_TRUE(says(out[1].notes.at(2), "split at 2 jumps of the time stamps into 2 logs"));
  EXPECT_TRUE(says(out[1].notes.at(3), "dropped stretches of fewer than 20 samples: t = 10 to 10.04 s"));
  EXPECT_TRUE(says(complaint_of([&] {
                     static_cast<void>(
                         regularised(log_at(vector(t)), Irregular::resample, {.min_samples = 101}));
                   }),
                   "no stretch of the log without a gap of more than 10 periods has 101 samples at 100 Hz"));
}

TEST(Regularised, RefusesARateThatNoMemoryHolds) {
  EXPECT_TRUE(says(
      complaint_of([] {
        static_cast<void>(regularised(log_at(vector(uniform(50))), Irregular::resample, {.rate_hz = 1e12}));
      }),
      "run1.csv: resampling to 1e+12 Hz, recorded at 100 Hz; at most 100 times the recorded rate"));
}

TEST(Regularised, RefusesReversedStampsEvenToResample) {
  std::vector<double> t = uniform(50);
  t[30] = t[10];
  EXPECT_TRUE(says(
      complaint_of([&] { static_cast<void>(regularised(log_at(vector(t)), Irregular::resample)); }),
      "run1.csv:32: the time stamps go back, 1 time, first to t = 0.1 s; such a log can not be resampled"));
}

// One in a hundred comes up to 40 ms late, and what waits for it at the same time.
TEST(TimeReport, KnowsStampsOfTheArrival) {
  std::vector<double> t = uniform(2000);
  EXPECT_EQ(inspect_time(vector(t)).late, 0);
  std::vector<double> early = t;
  double arrived = 0.0;
  for (std::size_t k = 0; k < t.size(); ++k) {
    arrived = std::max(arrived + 1e-6, t[k] + (k % 97 == 50 ? 0.037 : 0.0));
    t[k] = arrived;
    early[k] -= k % 97 == 50 ? 0.004 : 0.0;
  }
  // Each with the three that come while it is late.
  EXPECT_EQ(inspect_time(vector(t)).late, 4 * 21);
  EXPECT_EQ(inspect_time(vector(early)).late, 0);
  const std::vector<Log> out = regularised(log_at(vector(t)), Irregular::resample);
  ASSERT_FALSE(out.front().warnings.empty());
  EXPECT_EQ(out.front().warnings.front().code, "late_stamps");
  EXPECT_TRUE(says(out.front().warnings.front().text, "84 stamps late, none early"));
  EXPECT_TRUE(says(out.front().warnings.front().text, "rate_hz = 100"));
  EXPECT_TRUE(
      says(complaint_of([&] { static_cast<void>(regularised(log_at(vector(t)), Irregular::refuse)); }),
           "irregular = \"ignore\" with rate_hz = 100"));
}

TEST(TimeReport, KnowsTheClockOfStampsThatAreMostlyLate) {
  // A buffer that is read every 40 ms: two of five are in time, where the log ends late too.
  std::vector<double> t = uniform(2004);
  for (std::size_t k = 0; k < t.size(); ++k) {
    t[k] = k % 5 < 2 ? t[k] : t[k - k % 5] + 0.05 + 1e-6 * static_cast<double>(k % 5);
  }
  const TimeReport report = inspect_time(vector(t));
  EXPECT_EQ(report.late, 2004 / 5 * 3 + 2);
  EXPECT_NEAR(report.rate_hz, 100.0, 1e-9);
}

TEST(TimeReport, TakesNoGapAndNoJitterForLateStamps) {
  for (const std::size_t gap : {400U, 1000U, 1700U, 1950U}) {
    std::vector<double> t = uniform(2000);
    for (std::size_t k = gap; k < t.size(); ++k) {
      t[k] += 0.04;
    }
    EXPECT_EQ(inspect_time(vector(t)).late, 0) << gap;
  }
  std::mt19937 engine(5);
  for (const double deviation : {0.02, 0.1, 0.2, 0.3}) {
    std::normal_distribution<double> normal(0.0, deviation * 0.01);
    std::vector<double> t = uniform(2000);
    for (double& stamp : t) {
      stamp += normal(engine);
    }
    EXPECT_EQ(inspect_time(vector(t)).late, 0) << deviation;
  }
}

TEST(Regularised, RefusesOptionsAndLogsThatCanNotBeUsed) {
  const Log log = log_at(vector(uniform(50)));
  const auto message = [&](const ResampleOptions& options) {
    return complaint_of([&] { static_cast<void>(regularised(log, Irregular::resample, options)); });
  };
  EXPECT_TRUE(says(message({.rate_hz = -1.0}), "regularised: rate_hz is -1 Hz, must be positive"));
  EXPECT_TRUE(says(message({.max_gap = 1.0}), "max_gap is 1 periods, must be at least 2"));
  EXPECT_TRUE(says(message({.min_samples = 1}), "min_samples is 1, must be at least 2"));
  EXPECT_TRUE(says(complaint_of([] { static_cast<void>(regularised({}, Irregular::ignore)); }),
                   "the log has 0 samples"));
}

}  // namespace
}  // namespace rivid
