// Verdicts on parameters: what the data say, and the motion that would help.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "rivid/identify/identification.hpp"
#include "rivid/signal/filter.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

const Vector truth{{3.44, 0.03, 0.82, 0.062, 0.242, 0.014, 0.013, 0.137}};

// A log of the SCARA whose torques are those of the model, plus noise; `still` makes a joint stand in place.
Log scara_log(double torque_noise, std::optional<Index> still = {}, const Vector& chi = truth) {
  const Robot robot = test::scara();
  Log log;
  log.source = "made.csv";
  log.f_m = 200.0;
  log.t = Vector::LinSpaced(2001, 0.0, 10.0);
  log.q.resize(2001, 2);
  log.q.col(0) = 2.0 * (2.0 * log.t.array()).sin() + 0.5 * (5.3 * log.t.array()).sin();
  log.q.col(1) = 1.5 * (3.1 * log.t.array()).cos() + 0.7 * (7.7 * log.t.array()).sin();
  if (still) {
    log.q.col(*still) *= 1e-4;
  }
  const Observation W = observation(robot, base_parameters(robot), differentiate(log.q, log.f_m));
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  log.tau = (W.dense() * chi).reshaped(2001, 2);
  log.tau += Matrix::NullaryExpr(2001, 2, [&]() { return torque_noise * normal(random); });
  return log;
}

Identification identified(const Log& log) {
  return identify(test::scara(), log, {.method = Wls{}, .signal = {.trim = {{2, 2}}}});
}

const ParameterEstimate& named(const Identification& result, std::string_view name) {
  return *std::ranges::find(result.parameters, name, &ParameterEstimate::name);
}

TEST(Verdict, IsIdentifiedWithoutAdviceWhereNoiseIsSmall) {
  const Identification result = identified(scara_log(1e-3));
  for (const ParameterEstimate& p : result.parameters) {
    EXPECT_EQ(p.verdict, Verdict::identified) << p.name << ": " << p.advice;
    EXPECT_EQ(p.advice, "");
  }
}

TEST(Verdict, IsIdentifiedExactlyWhereTheIntervalIsNarrowAndExcludesZero) {
  for (const double noise : {1e-3, 0.05, 0.5, 5.0}) {
    for (const ParameterEstimate& p : identified(scara_log(noise)).parameters) {
      const bool excludes_zero = p.interval_95[0] > 0.0 || p.interval_95[1] < 0.0;
      EXPECT_EQ(p.verdict == Verdict::identified, excludes_zero && p.relative_sigma_percent <= 30.0)
          << p.name << " at " << noise;
      EXPECT_EQ(p.advice.empty(), p.verdict == Verdict::identified) << p.name << " at " << noise;
      EXPECT_DOUBLE_EQ(p.relative_sigma_percent, 100.0 * p.sigma / std::abs(p.value)) << p.name;
    }
  }
}

TEST(Verdict, IsWeakAndCalledSmallWhereAParameterIsZero) {
  Vector chi = truth;
  chi[5] = 0.0;  // MY2, which MX2 has the unit of
  const ParameterEstimate p = named(identified(scara_log(3.0, {}, chi)), "MY2");
  ASSERT_EQ(p.verdict, Verdict::weak) << p.value << " ± " << p.sigma;
  EXPECT_TRUE(p.advice.starts_with("small rather than unseen: within ")) << p.advice;
}

TEST(Verdict, IsNotExcitedWhereNoiseWouldHideAnyUsualValue) {
  const Identification result = identified(scara_log(0.3, 1));
  for (const std::string_view name : {"ZZ2", "MX2", "Fv2"}) {
    EXPECT_EQ(named(result, name).verdict, Verdict::not_excited) << name;
  }
  EXPECT_EQ(named(result, "Fc1").verdict, Verdict::identified);
}

// An estimate that is all noise must not make the others of its unit look small.
TEST(Verdict, MeasuresAParameterAgainstValuesThatAreSeen) {
  const Identification result = identified(scara_log(3.0, 1));
  ASSERT_GT(std::abs(named(result, "Fv2").value), 100.0 * truth[6]);
  EXPECT_EQ(named(result, "Fv1").advice.find("small"), std::string::npos) << named(result, "Fv1").advice;
}

TEST(Verdict, NamesTheJointThatHardlyMoves) {
  const Identification result = identified(scara_log(0.05, 1));
  const ParameterEstimate& friction = named(result, "Fv2");
  EXPECT_NE(friction.verdict, Verdict::identified);
  EXPECT_NE(friction.advice.find("slow and fast motion of joint_2 (which hardly moves)"), std::string::npos)
      << friction.advice;
}

TEST(Verdict, NamesTheParameterThatAnotherIsHardToTellFrom) {
  const Identification result = identified(scara_log(0.05, 1));
  const std::string& advice = named(result, "MX2").advice;
  EXPECT_NE(advice.find("hard to distinguish from ZZ2"), std::string::npos) << advice;
  EXPECT_NE(advice.find("while joint_2 (which hardly moves) moves"), std::string::npos) << advice;
}

TEST(Verdict, IsNotExcitedWhereTheRankIsDeficient) {
  Log log = scara_log(1e-3);
  log.q.col(1).setConstant(0.4);
  const Identification result = identified(log);
  ASSERT_EQ(result.status, Status::rank_deficient);
  const ParameterEstimate& p = named(result, "Fv2");
  EXPECT_EQ(p.verdict, Verdict::not_excited);
  EXPECT_TRUE(p.advice.starts_with("not determined; needs ")) << p.advice;
}

}  // namespace
}  // namespace rivid
