#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/types.hpp"

namespace rivid {

/// Outcome of a statistical test.
struct TestResult {
  double statistic = 0.0;
  double freedom = 0.0;
  double p = 0.0;  ///< probability of such a statistic, or a larger one, if nothing is the matter
};

/// What the residual ρ = Y − W χ̂ of a joint's rows looks like.
struct ResidualTests {
  std::string joint;
  TestResult whiteness;          ///< Ljung & Box (1978), over 20 rows
  double autocorrelation = 0.0;  ///< of neighbouring rows: the effect size
  TestResult normality;          ///< Jarque & Bera (1980)
  double skewness = 0.0;
  double excess_kurtosis = 0.0;
};

/// Whether least squares would have been enough: Durbin, Wu and Hausman's comparison of the estimates by instruments and
/// by least squares on the same rows, with the covariance of their difference from the scores of both (robust: it is
/// positive semidefinite, which the difference of classical covariances is not).
struct HausmanTest {
  TestResult test;             ///< as an F statistic
  double largest_shift = 0.0;  ///< max |χ̂_IV − χ̂_LS| / σ_IV: the effect size
  std::string parameter;       ///< where it is
};

/// By how many samples the torques are late, beyond what the experiment says of it, from the residual's regression on the
/// rate of the torques.
struct TorqueLag {
  double samples = 0.0;        ///< of all joints; positive: recorded late, as `torque_lag` counts it
  double sigma = 0.0;          ///< its deviation, widened where the joints disagree
  double largest_shift = 0.0;  ///< max |Δχ̂| / σ by that lag: the effect size
  std::string parameter;       ///< where it is
};

/// Tests on a result. Small p-values with small effects are no reason for concern.
struct Diagnostics {
  std::vector<ResidualTests> residuals;  ///< one a joint
  std::optional<HausmanTest> hausman;    ///< of IDIM-IV
  std::optional<TorqueLag> torque_lag;   ///< of exact rows; not of a robust estimate
};

}  // namespace rivid
