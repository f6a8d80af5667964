#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Outcome of a statistical test.
struct TestResult {
  double statistic = 0.0;
  double freedom = 0.0;
  double p = 0.0;  ///< probability of such a statistic, or a larger one, if nothing is the matter

  template <typename R = TestResult>
  static constexpr auto fields() {
    return std::tuple(
        Field{"statistic", &R::statistic, ""}, Field{"freedom", &R::freedom, "degrees of freedom"},
        Field{"p", &R::p, "probability of such a statistic, or a larger one, if nothing is the matter"});
  }
};

/// What the residual ρ = Y − W χ̂ of a joint's rows looks like.
struct ResidualTests {
  std::string joint;
  TestResult whiteness;          ///< Ljung & Box (1978), over 20 rows
  double autocorrelation = 0.0;  ///< of neighbouring rows: the effect size
  TestResult normality;          ///< Jarque & Bera (1980)
  double skewness = 0.0;
  double excess_kurtosis = 0.0;

  template <typename R = ResidualTests>
  static constexpr auto fields() {
    return std::tuple(Field{"joint", &R::joint, "name of the joint"},
                      Field{"whiteness", &R::whiteness, "Ljung-Box over 20 rows"},
                      Field{"autocorrelation", &R::autocorrelation, "of neighbouring rows", {.unit = "1"}},
                      Field{"normality", &R::normality, "Jarque-Bera"},
                      Field{"skewness", &R::skewness, "of the residual", {.unit = "1"}},
                      Field{"excess_kurtosis", &R::excess_kurtosis, "of the residual", {.unit = "1"}});
  }
};

/// Whether least squares would have been enough: Durbin, Wu and Hausman's comparison of the estimates by
/// instruments and by least squares on the same rows, with the covariance of their difference from the scores
/// of both (robust: it is positive semidefinite, which the difference of classical covariances is not).
struct HausmanTest {
  TestResult test;             ///< as an F statistic
  double largest_shift = 0.0;  ///< max |χ̂_IV − χ̂_LS| / σ_IV: the effect size
  std::string parameter;       ///< where it is

  template <typename R = HausmanTest>
  static constexpr auto fields() {
    return std::tuple(
        Field{"statistic",
              [](const HausmanTest& r) { return r.test.statistic; },
              "of the Durbin-Wu-Hausman test with a robust covariance",
              {.unit = "1"}},
        Field{"freedom", [](const HausmanTest& r) { return r.test.freedom; }, "degrees of freedom"},
        Field{"p",
              [](const HausmanTest& r) { return r.test.p; },
              "probability of such a statistic if least squares would have done",
              {.unit = "1"}},
        Field{"largest_shift",
              &R::largest_shift,
              "largest difference of the two estimates in σ",
              {.unit = "1"}},
        Field{"parameter", &R::parameter, "that it is of"});
  }
};

/// By how many samples the torques are late, beyond what the experiment says of it, from the residual's
/// regression on the rate of the torques.
struct TorqueLag {
  double samples = 0.0;        ///< of all joints; positive: recorded late, as `torque_lag` counts it
  double sigma = 0.0;          ///< its deviation, widened where the joints disagree
  double largest_shift = 0.0;  ///< max |Δχ̂| / σ by that lag: the effect size
  std::string parameter;       ///< where it is

  template <typename R = TorqueLag>
  static constexpr auto fields() {
    return std::tuple(
        Field{"samples",
              &R::samples,
              "by how much the torques are late beside the motion, as `[log] torque_lag` counts it",
              {.unit = "samples"}},
        Field{"sigma", &R::sigma, "its deviation", {.unit = "samples"}},
        Field{"largest_shift",
              &R::largest_shift,
              "by how many σ that moves a parameter at most",
              {.unit = "1"}},
        Field{"parameter", &R::parameter, "that it is of"});
  }
};

/// An alternative to the model of robot and log that explains the torques better, by a score test whose
/// covariance comes from blocks of time, see identify().
struct ModelTest {
  std::string code;            ///< of the finding that it makes
  std::string subject;         ///< joint or joints
  TestResult test;             ///< as an F statistic
  Vector estimate;             ///< of its parameters, whose units are in docs/diagnostics.md, (k)
  Vector sigma;                ///< their standard deviations, (k)
  double explained = 0.0;      ///< part of the squared residual, on blocks of time that took no part
  double largest_shift = 0.0;  ///< max |Δχ̂| / σ with it: the effect size
  std::string parameter;       ///< where it is

  template <typename R = ModelTest>
  static constexpr auto fields() {
    return std::tuple(
        Field{"code", &R::code, "of the finding that it makes"},
        Field{"subject", &R::subject, "joint or joints"},
        Field{"test", &R::test, "score test as an F statistic"},
        Field{"estimate", &R::estimate, "of its parameters", {.unit = "by `code`"}},
        Field{"sigma", &R::sigma, "their standard deviations", {.unit = "by `code`"}},
        Field{"explained",
              &R::explained,
              "part of the squared residual that goes with it, on blocks of time that took no part",
              {.unit = "1"}},
        Field{"largest_shift", &R::largest_shift, "largest change of a parameter with it", {.unit = "σ"}},
        Field{"parameter", &R::parameter, "that it is of"});
  }
};

/// Tests on a result. Small p-values with small effects are no reason for concern.
struct Diagnostics {
  std::vector<ResidualTests> residuals;  ///< one a joint
  std::optional<HausmanTest> hausman;    ///< of IDIM-IV
  std::optional<TorqueLag> torque_lag;   ///< of exact rows; not of a robust estimate

  template <typename R = Diagnostics>
  static constexpr auto fields() {
    return std::tuple(
        Field{"residuals", &R::residuals,
              "one a joint: `whiteness` (Ljung-Box over 20 rows) with the `autocorrelation` of neighbouring "
              "rows, `normality` (Jarque-Bera) with `skewness` and `excess_kurtosis`"},
        Field{"hausman", &R::hausman,
              "of `\"iv\"`, else null: whether least squares on the same rows would have been enough "
              "(Durbin-Wu-Hausman); `largest_shift` from it in σ, and its `parameter`"},
        Field{"torque_lag", &R::torque_lag,
              "by how many `samples` the torques are late, with `sigma`; `largest_shift` by it in σ, and its "
              "`parameter`. Null with the paper's rows, with `robust`, and where it is too uncertain"});
  }
};

}  // namespace rivid
