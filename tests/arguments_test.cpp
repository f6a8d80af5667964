// What public functions refuse: arguments of other sizes, of another robot, or without content.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "rivid/data/adjust.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/data/time_stamps.hpp"
#include "rivid/excite/excitation.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/identify/comparison.hpp"
#include "rivid/identify/essential.hpp"
#include "rivid/identify/friction_choice.hpp"
#include "rivid/identify/friction_curves.hpp"
#include "rivid/identify/gains.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/log_factors.hpp"
#include "rivid/identify/loop_factors.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/identify/row_table.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/report/html.hpp"
#include "rivid/report/json.hpp"
#include "rivid/report/online.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/solve/inference.hpp"
#include "rivid/text.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

// A call, and words of what it throws.
struct Refused {
  std::string words;
  std::function<void()> call;
};

void expect_refused(const std::vector<Refused>& calls) {
  for (const Refused& each : calls) {
    EXPECT_TRUE(says(complaint_of(each.call), each.words));
  }
}

// Changes one value of a copy.
template <typename T, typename Change>
T changed(T value, const Change& change) {
  change(value);
  return value;
}

// The SCARA swinging for 5 s, without noise.
struct Swing {
  Robot robot = test::scara();
  BaseParameters base = base_parameters(robot);
  Vector chi{{3.5, 0.06, 0.8, 0.12, 0.25, 0.03, 0.06, 0.2}};
  Log log;
  SignalOptions signal = {.torque_held = false, .decimation = {5}};

  Swing() {
    constexpr Index samples = 1001;
    log.source = "swing.csv";
    log.f_m = 200.0;
    log.t = Vector::LinSpaced(samples, 0.0, 5.0);
    log.q.resize(samples, 2);
    log.q.col(0) = (2.0 * log.t.array()).sin() + 0.3 * (7.1 * log.t.array()).cos();
    log.q.col(1) = (3.0 * log.t.array()).cos() + 0.2 * (9.3 * log.t.array()).sin();
    log.tau = (observation(robot, base, motion()).dense() * chi).reshaped(samples, 2);
  }

  [[nodiscard]] Motion motion() const { return differentiate(log.q, log.f_m); }
  [[nodiscard]] Identification result() const {
    return identify(robot, log, {.method = Wls{}, .signal = signal});
  }
};

TEST(Arguments, SeriesOfALongRunCovarianceHaveTheSameColumns) {
  const std::vector<Matrix> unequal = {Matrix::Ones(10, 3), Matrix::Ones(10, 2)};
  EXPECT_TRUE(says(complaint_of([&] { return long_run_covariance(unequal, 2); }),
                   "long_run_covariance: a series has 2 columns, the first has 3"));
  EXPECT_TRUE(
      says(complaint_of([&] { return bartlett_lag(unequal); }), "bartlett_lag: a series has 2 columns"));
  EXPECT_TRUE(
      says(complaint_of([&] { return long_run_covariance(std::vector{Matrix(Matrix::Ones(10, 3))}, -1); }),
           "long_run_covariance: lag is -1"));
}

TEST(Arguments, TheBaseOfAnObservationIsThatOfItsRobot) {
  std::mt19937_64 random(1);
  const BaseParameters of_scara = base_parameters(test::scara());
  const Motion motion = test::random_motion(10, 1, random);
  EXPECT_TRUE(says(complaint_of([&] { return observation(test::slider(), of_scara, motion); }),
                   "observation: the base parameters are those of another robot than \"slider\", or of other "
                   "friction laws; take base_parameters(robot)"));
}

TEST(Arguments, ColumnsOfARegressorAreThoseOfItsRobot) {
  const std::vector<StandardParameter> beyond = {{ParameterKind::Fv, 7}};
  const std::vector<StandardParameter> below = {{ParameterKind::Fv, -1}};
  const std::vector<StandardParameter> unknown = {{static_cast<ParameterKind>(99), 0}};
  expect_refused({{"RegressorColumns: joint of a parameter Fv is 7, must be one of the 2 joints of robot "
                   "\"scara\", counted from 0",
                   [&] { RegressorColumns(test::scara(), beyond); }},
                  {"joint of a parameter Fv is -1", [&] { RegressorBatch(test::scara(), below); }},
                  {"kind of a parameter is 99", [&] { RegressorColumns(test::scara(), unknown); }}});
}

TEST(Arguments, TheBaseOfRowsIsThatOfTheirRobot) {
  const Swing swing;
  std::mt19937_64 random(2);
  const BaseParameters larger = base_parameters(test::random_robot(6, random));
  const BaseParameters smaller = base_parameters(test::slider());
  const Identification other = changed(swing.result(), [&](Identification& result) {
    result.base = larger;
    result.chi = Vector::Ones(larger.size());
  });
  const std::string words = "rows: the base parameters are those of another robot than \"scara\"";
  expect_refused(
      {{words, [&] { static_cast<void>(rows(swing.robot, larger, swing.log, swing.signal)); }},
       {words, [&] { static_cast<void>(rows(swing.robot, smaller, swing.log, swing.signal)); }},
       {words, [&] { static_cast<void>(factors(swing.robot, larger, swing.log, swing.signal)); }},
       {words, [&] { static_cast<void>(predict(swing.robot, other, swing.log)); }},
       {words, [&] { static_cast<void>(validate(swing.robot, other, swing.log)); }},
       {words, [&] { static_cast<void>(row_table(swing.robot, other, std::span(&swing.log, 1))); }},
       {"observation: the base parameters are those of another robot",
        [&] { static_cast<void>(observation(swing.robot, smaller, swing.motion())); }}});
}

TEST(Arguments, AMotionIsFinite) {
  const Swing swing;
  const ExcitationOptions options{.noise = {.sigma = Vector::Ones(2)}};
  const auto with = [&](double value) {
    return changed(swing.motion(), [&](Motion& motion) { motion.qd(7, 1) = value; });
  };
  const Motion large = changed(swing.motion(), [](Motion& motion) { motion.qd *= 1e200; });
  const auto base = [&](const Motion& motion) {
    static_cast<void>(base_parameters(swing.robot, motion, 1e-9));
  };
  const auto forecast_of = [&](const Motion& motion) {
    static_cast<void>(forecast(swing.robot, motion, 200.0, options));
  };
  expect_refused(
      {{"base_parameters: qd of joint 2 at sample 7 is nan, must be finite", [&] { base(with(nan)); }},
       {"base_parameters: qd of joint 2 at sample 7 is inf", [&] { base(with(inf)); }},
       {"base_parameters: q, qd or qdd of the motion is so large", [&] { base(large); }},
       {"forecast: qd of joint 2 at sample 7 is nan", [&] { forecast_of(with(nan)); }},
       {"forecast: q, qd or qdd of the motion is so large", [&] { forecast_of(large); }},
       {"forecast: the motion has no sample",
        [&] { forecast_of({Matrix(0, 2), Matrix(0, 2), Matrix(0, 2)}); }}});
}

TEST(Arguments, WhatIsKnownBeforeAMotionIsPositiveSemidefinite) {
  const Robot robot = test::scara();
  const Index b = base_parameters(robot).size();
  ExcitationOptions options{.noise = {.sigma = Vector::Ones(2)}};
  EXPECT_FALSE(options.complaint(robot));
  options.known = Matrix::Ones(b, b);  // of one row
  EXPECT_FALSE(options.complaint(robot));
  for (const double corner : {nan, inf, -1.0, 0.5}) {
    options.known = Matrix::Ones(b, b);
    options.known(0, 0) = corner;
    EXPECT_TRUE(says(options.complaint(robot).value_or(""),
                     "known is (8 × 8), must be finite, symmetric and positive semidefinite"))
        << corner;
  }
}

TEST(Arguments, ACovarianceOfGainsIsPositiveSemidefinite) {
  const Swing swing;
  const Matrix good = 1e-4 * Matrix::Ones(2, 2);
  const Index b = swing.base.size();
  IdentifiedArm arm{swing.robot, swing.chi, Matrix::Identity(b, b), Matrix::Zero(b, 2), good};
  Estimation estimation{.method = Wls{}, .gain_covariance = good};
  EXPECT_FALSE(estimation.complaint(swing.robot));
  EXPECT_FALSE(arm.complaint());
  const Matrix asymmetric{{0.01, 0.005}, {0.0, 0.01}};
  const Matrix indefinite{{0.01, 0.02}, {0.02, 0.01}};
  for (const Matrix& bad : {Matrix(-0.01 * Matrix::Identity(2, 2)), asymmetric, indefinite}) {
    estimation.gain_covariance = arm.gain_covariance = bad;
    const std::string words = "gain_covariance is 2 × 2, must be n × n, finite, symmetric and positive";
    EXPECT_TRUE(says(estimation.complaint(swing.robot).value_or(""), words)) << bad;
    EXPECT_TRUE(says(arm.complaint().value_or(""), words)) << bad;
  }
}

TEST(Arguments, ModelsToCompareHaveFiniteValues) {
  const Swing swing;
  const ComparedModel good = {"good", swing.robot, swing.base.to_standard(swing.chi)};
  const auto compare_with = [&](const Vector& chi_st) {
    const std::vector<ComparedModel> models = {good, {"bad", swing.robot, chi_st}};
    static_cast<void>(compare(models, std::span(&swing.log, 1), {.signal = swing.signal}));
  };
  const auto test_of = [](const Vector& series) { return paired_test(std::span(&series, 1), 12); };
  expect_refused(
      {{"compare: bad has 24 values, must have one, finite, for each of 25 standard parameters",
        [&] { compare_with(good.chi_st.head(good.chi_st.size() - 1)); }},
       {"compare: bad has 25 values, must have one, finite", [&] { compare_with(nan * good.chi_st); }},
       {"paired_test: a difference is not finite",
        [&] { static_cast<void>(test_of(Vector::Constant(500, nan))); }}});
  EXPECT_TRUE(std::isnan(test_of(Vector()).p));
  EXPECT_TRUE(std::isnan(paired_test({}, 12).p));
}

TEST(Arguments, LogsToJudgeAResultByAreUsable) {
  const Swing swing;
  const std::vector<std::pair<std::string, Log>> logs = {
      {"swing.csv: the log has 0 samples", changed(Log(), [](Log& log) { log.source = "swing.csv"; })},
      {"swing.csv: v_tau is 1001 × 3, must be 1001 × 2",
       changed(swing.log, [](Log& log) { log.v_tau = Matrix::Ones(1001, 3); })},
      {"q of joint 1 is nan", changed(swing.log, [](Log& log) { log.q(3, 0) = nan; })},
      {"swing.csv: the time stamps are irregular", changed(swing.log, [](Log& log) { log.t[5] = log.t[4]; })},
      {"swing.csv: neither torque nor control signal",
       changed(swing.log, [](Log& log) { log.tau.resize(0, 0); })},
      {"swing.csv: f_m is -200 Hz", changed(swing.log, [](Log& log) { log.f_m = -200.0; })},
      {"swing.csv: position has 1 columns", changed(swing.log, [](Log& log) {
         log.q = log.q.leftCols(1).eval();
         log.tau = log.tau.leftCols(1).eval();
       })}};
  const auto identify_by = [&](const Log& log, const Log& validation) {
    static_cast<void>(
        identify(swing.robot, std::span(&log, 1), {.signal = swing.signal}, std::span(&validation, 1)));
  };
  const auto check_by = [&](const Log& log, const Log& validation) {
    static_cast<void>(check(swing.robot, std::span(&log, 1), std::span(&validation, 1)));
  };
  for (const auto& [words, log] : logs) {
    expect_refused({{words, [&, &bad = log] { identify_by(bad, swing.log); }},
                    {words, [&, &bad = log] { identify_by(swing.log, bad); }},
                    {words, [&, &bad = log] { check_by(bad, swing.log); }},
                    {words, [&, &bad = log] { check_by(swing.log, bad); }}});
  }
  expect_refused({{"check: threads is 0, must be at least 1", [&] {
                     static_cast<void>(check(swing.robot, std::span(&swing.log, 1), {}, {.threads = 0}));
                   }}});
}

TEST(Arguments, FactorsThatAreMergedFitEachOther) {
  const Swing swing;
  const LogFactors good = log_factors(swing.robot, swing.log, swing.signal);
  const std::vector<LogFactors> others = {LogFactors(),
                                          changed(good, [](LogFactors& f) { f.rows.thresholds.clear(); }),
                                          changed(good, [](LogFactors& f) { f.rows.left_out.push_back(1); }),
                                          changed(good, [](LogFactors& f) { f.velocities.sums.resize(1); }),
                                          changed(good, [](LogFactors& f) { f.blocks.front().pop_back(); })};
  for (const LogFactors& other : others) {
    expect_refused({{"merge: the factors are of different robots or options",
                     [&] {
                       LogFactors into = good;
                       merge(into, other);
                     }},
                    {"identify", [&] {
                       static_cast<void>(
                           identify(swing.robot, other, {.method = Wls{}, .signal = swing.signal}));
                     }}});
  }
}

TEST(Arguments, FactorsOfLoopsFitEachOther) {
  const Swing swing;
  const auto own = [](Index size) { return InstrumentalGroup{{0}, StreamingQr(size, size + 1)}; };
  LoopFactors into;
  into.logs = 1;
  into.groups = {own(1), own(1)};
  LoopFactors without_rows = into;
  without_rows.groups.clear();
  const LoopFactors shorter = changed(into, [](LoopFactors& f) { f.groups.pop_back(); });
  const LoopFactors wider = changed(into, [&](LoopFactors& f) { f.groups[1] = own(2); });
  for (const LoopFactors& other : {without_rows, shorter, wider}) {
    expect_refused({{"merge: the factors are of different robots, options or requests", [&] {
                       LoopFactors copy = into;
                       merge(copy, other);
                     }}});
  }
  merge(into, LoopFactors());
  EXPECT_EQ(into.logs, 1);
  EXPECT_EQ(into.groups.size(), 2U);

  const Estimation estimation{
      .method = Iv{.control = PdControl{.omega_n = Eigen::Vector2d(1, 10), .zeta = Eigen::Vector2d(1, 1)}},
      .signal = swing.signal};
  const LogFactors factors = log_factors(swing.robot, swing.log, swing.signal);
  expect_refused(
      {{"identify: ask is empty",
        [&] { static_cast<void>(identify(swing.robot, factors, estimation, LoopAsk())); }},
       {"identify: what is returned by ask is not what the pass over robot \"scara\" was to come to", [&] {
          static_cast<void>(identify(swing.robot, factors, estimation,
                                     [](const LoopRequest& /*request*/) { return LoopFactors(); }));
        }}});
}

TEST(Arguments, WhatWasChosenForAJointIsOfTheRobot) {
  const Robot robot = test::scara();
  const FrictionChoice choice{.joints = {9}, .law = Friction::root};
  const GainReport gains = changed(GainReport(), [](GainReport& report) { report.joints.resize(6); });
  expect_refused({{"with_friction: joint is 9, must be one of the 2 joints of robot \"scara\"",
                   [&] { static_cast<void>(with_friction(robot, std::span(&choice, 1))); }},
                  {"FrictionChoice::text: joint is 9", [&] { static_cast<void>(choice.text(robot)); }},
                  {"with_gains: there are 6 gains, must be one for each of the 2 joints",
                   [&] { static_cast<void>(with_gains(robot, gains)); }}});
}

TEST(Arguments, AnEliminationHasFreedomAndFiniteMotions) {
  const Swing swing;
  const Index b = swing.base.size();
  const Matrix unit = Matrix::Identity(b, b);
  const auto with = [&](double freedom, const Matrix& q) {
    static_cast<void>(essential(swing.robot, swing.base, swing.chi, unit, unit, freedom, std::span(&q, 1)));
  };
  expect_refused({{"essential: freedom is 0, must be positive", [&] { with(0.0, swing.log.q); }},
                  {"essential: freedom is nan", [&] { with(nan, swing.log.q); }},
                  {"essential: q is 10 × 3, must be finite with a column for each of the 2 joints",
                   [&] { with(100.0, Matrix::Zero(10, 3)); }}});
}

TEST(Arguments, ColumnsOfALogAreAsLongAsItsTime) {
  const Swing swing;
  const Log uneven = changed(swing.log, [](Log& log) { log.v_tau = Matrix::Ones(5, 2); });
  const Log short_torque = changed(swing.log, [](Log& log) { log.tau = Matrix::Ones(5, 2); });
  const TorqueTable table{"table.csv", Vector{{-9.0, 9.0}}, Vector{{0.0, 1.0}}};
  const auto reference = changed(swing.log, [](Log& log) { log.q_r = log.q; });
  const auto with_instant = [&](double t) { return changed(swing.log, [&](Log& log) { log.t[9] = t; }); };
  expect_refused({{"excerpt: swing.csv: v_tau has 5 rows, must have one for each of the 1001 samples",
                   [&] { static_cast<void>(excerpt(uneven, 0, 10)); }},
                  {"excerpt: swing.csv has 1001 samples",
                   [&] { static_cast<void>(excerpt(swing.log, 1, std::numeric_limits<Index>::max())); }},
                  {"to_csv: swing.csv: v_tau has 5 rows", [&] { static_cast<void>(to_csv(uneven)); }},
                  {"shift_torque: swing.csv: tau has 5 rows",
                   [&] { static_cast<void>(shift_torque(short_torque, 1.0)); }},
                  {"subtract_torque: swing.csv: tau has 5 rows",
                   [&] { static_cast<void>(subtract_torque(short_torque, 0, table)); }},
                  {"with_reference: swing.csv: t must be finite",
                   [&] { static_cast<void>(with_reference(with_instant(nan), reference)); }},
                  {"inspect_time: max_gap is inf periods, must be at most 1e+09",
                   [&] { static_cast<void>(inspect_time(swing.log.t, inf)); }}});
}

TEST(Arguments, PartsOfAReportBelongTogether) {
  const Swing swing;
  const Identification result = swing.result();
  const Prediction good = predict(swing.robot, result, swing.log);
  const Prediction none = {.source = "swing.csv"};
  const Prediction one_joint = changed(good, [](Prediction& log) { log.joints.pop_back(); });
  const Prediction uneven = changed(good, [](Prediction& log) { log.joints[1].fitted.velocity.resize(3); });
  const auto page = [&](const Prediction& log) {
    static_cast<void>(html_report(swing.robot, result, std::span(&log, 1), {}));
  };
  const auto curves = [&](const Prediction& log) {
    static_cast<void>(friction_curves(swing.robot, result, std::span(&log, 1)));
  };
  expect_refused(
      {{"html_report: the prediction of \"swing.csv\" is of 0 joints, robot \"scara\" has 2",
        [&] { page(none); }},
       {"friction_curves: the prediction of \"swing.csv\" is of 1 joint", [&] { curves(one_joint); }},
       {"html_report: the prediction of \"swing.csv\" for joint \"joint_2\" has series of different lengths",
        [&] { page(uneven); }},
       {"to_json: the result is of 2 joints, robot \"slider\" has 1",
        [&] { static_cast<void>(to_json(test::slider(), result, {})); }},
       {"row_table: no log is given", [&] { static_cast<void>(row_table(swing.robot, result, {})); }},
       {"to_csv: payload of the replay is 0 × 0, must be 0 × 6",
        [] { static_cast<void>(to_csv(OnlineReplay{})); }},
       {"to_html: payload of the replay is 0 × 0", [] { static_cast<void>(to_html(OnlineReplay{})); }}});
}

TEST(Arguments, AnIdentificationToValidateHasValues) {
  EXPECT_TRUE(says(complaint_of([] { return validate(test::scara(), Identification(), Log()); }),
                   "validate: the identification has 0 values"));
}

TEST(Arguments, TextOnALineIsUtf8WithoutControlCharacters) {
  EXPECT_EQ(on_one_line("q̇ · 日本 😀"), "q̇ · 日本 😀");
  EXPECT_EQ(on_one_line("a\x1B[31mb\x7F\n"), "a?[31mb??");
  EXPECT_EQ(on_one_line("\xC2\x9B"
                        "31m"),
            "??31m")
      << "CSI as one character";
  EXPECT_EQ(on_one_line("\xFF\xC0\xAF"), "???");
  EXPECT_EQ(on_one_line("\xED\xA0\x80"), "???") << "a surrogate";
  EXPECT_EQ(on_one_line("\xF4\x90\x80\x80"), "????") << "beyond the last character";
  EXPECT_EQ(on_one_line("cut \xE6\x97"), "cut ??");
}

}  // namespace
}  // namespace rivid
