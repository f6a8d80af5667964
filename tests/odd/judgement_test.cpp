#include "odd/judgement.hpp"

#include <gtest/gtest.h>

namespace rivid::odd {
namespace {

// Two masses and a friction, all of them right.
struct Example {
  Identification result;
  Vector truth = Eigen::Vector3d(2.0, 0.1, 1.0);

  Example() {
    constexpr std::array kinds = {ParameterKind::ZZ, ParameterKind::MX, ParameterKind::Fc};
    constexpr std::array units = {"kg·m²", "kg·m", "N·m"};
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      const StandardParameter standard{kinds[i], 0};
      result.base.parameters.push_back(
          {.leading = standard, .name = standard.name(), .regrouped = {}, .unit = {}});
      ParameterEstimate& p = result.parameters.emplace_back();
      p.name = standard.name();
      p.unit = units[i];
      set(i, truth[static_cast<Index>(i)]);
    }
  }
  void set(std::size_t i, double value, double sigma = 0.01) {
    ParameterEstimate& p = result.parameters[i];
    p.value = value;
    p.sigma = sigma;
    p.interval_95 = {value - 2.0 * sigma, value + 2.0 * sigma};
  }
  [[nodiscard]] Judgement judgement(bool inertial_only = false) const {
    return judged(result, truth, inertial_only);
  }
};

TEST(OddJudgement, ARightResultIsHonest) {
  const Judgement it = Example().judgement();
  EXPECT_EQ(it.outcome, Outcome::honest);
  EXPECT_EQ(it.counted, 3);
  EXPECT_EQ(it.covered, 3);
  EXPECT_EQ(it.rms_error, 0.0);
}

TEST(OddJudgement, FiveDeviationsWithoutAWordAreConfidentlyWrong) {
  Example example;
  example.set(0, 2.049);
  EXPECT_EQ(example.judgement().outcome, Outcome::honest);
  example.set(0, 2.051);
  const Judgement it = example.judgement();
  EXPECT_EQ(it.outcome, Outcome::wrong);
  EXPECT_FALSE(it.material);
  EXPECT_EQ(it.worst, "ZZ1");
  EXPECT_NEAR(it.worst_sigmas, 5.1, 1e-9);
  EXPECT_EQ(it.covered, 2);
}

TEST(OddJudgement, ATenthOffIsMaterial) {
  Example example;
  example.set(0, 2.21);
  EXPECT_TRUE(example.judgement().material);
}

TEST(OddJudgement, WhatIsSmallAmongItsLikeIsNotMaterial) {
  Example example;
  example.result.parameters[1].unit = "kg·m²";
  example.set(1, 0.13, 0.001);  // 30 % of itself, 1.5 % of the other
  const Judgement it = example.judgement();
  EXPECT_EQ(it.outcome, Outcome::wrong);
  EXPECT_FALSE(it.material);
}

TEST(OddJudgement, AWarningOrAWeakVerdictIsAWord) {
  Example example;
  example.set(0, 2.5);
  example.result.warnings = {Finding{.code = "weak_excitation", .text = "hardly distinguish ZZ12 and MX1"}};
  EXPECT_EQ(example.judgement().outcome, Outcome::wrong);  // of another parameter
  example.result.warnings[0].text = "hardly distinguish ZZ1 and MX1";
  EXPECT_EQ(example.judgement().outcome, Outcome::warned);
  example.result.warnings = {Finding{.code = "torque_lag"}};
  EXPECT_EQ(example.judgement().outcome, Outcome::warned);
  example.result.warnings = {Finding{.code = "log_note"}};
  EXPECT_EQ(example.judgement().outcome, Outcome::wrong);  // notes do not warn
  example.result.warnings.clear();
  example.result.parameters[0].verdict = Verdict::weak;
  EXPECT_EQ(example.judgement().outcome, Outcome::honest);
}

TEST(OddJudgement, AnotherStatusIsARefusal) {
  Example example;
  example.set(0, 2.5);
  example.result.status = Status::rank_deficient;
  EXPECT_EQ(example.judgement().outcome, Outcome::refused);
  EXPECT_EQ(example.judgement().counted, 0);
}

TEST(OddJudgement, FrictionWithoutATruthIsNotJudged) {
  Example example;
  example.set(2, 1.5);
  EXPECT_EQ(example.judgement().outcome, Outcome::wrong);
  EXPECT_EQ(example.judgement(true).outcome, Outcome::honest);
  EXPECT_EQ(example.judgement(true).counted, 2);
}

}  // namespace
}  // namespace rivid::odd
