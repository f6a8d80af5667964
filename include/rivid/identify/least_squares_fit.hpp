#pragma once

#include <functional>
#include <span>
#include <string_view>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/rows.hpp"

namespace rivid {

/// Called on the way through a long computation with a name and the fraction done, 0 to 1.
using Progress = std::function<void(std::string_view stage, double fraction)>;

/// IDIM-OLS: ordinary least squares, Eqs. (15–19) of [RIV].
struct Ols {
  SignalOptions signal = {};
  CovarianceOptions covariance = {};
  int threads = 1;  ///< that share the work, see factors(); the result is the same whatever their number
  Progress progress = {};
  std::optional<Physical> physical = {};    ///< the physically consistent model as well
  std::optional<Essential> essential = {};  ///< the parameters that matter as well
  std::optional<Robust> robust = {};        ///< an estimate that outliers do not decide
};

/// IDIM-WLS: each joint's rows divided by the standard deviation of the error of a fit to these rows alone,
/// Eq. (20) of [RIV].
struct Wls {
  SignalOptions signal = {};
  CovarianceOptions covariance = {};
  int threads = 1;  ///< that share the work, see factors(); the result is the same whatever their number
  Progress progress = {};
  std::optional<Physical> physical = {};    ///< the physically consistent model as well
  std::optional<Essential> essential = {};  ///< the parameters that matter as well
  std::optional<Robust> robust = {};        ///< an estimate that outliers do not decide
};

/// Identifies the base parameters from logs of one robot; their rows are stacked.
///
/// @throws InputError where robot, logs and options do not fit together; the message names the culprit
Identification identify(const Robot& robot, std::span<const Log> logs, const Ols& method);
Identification identify(const Robot& robot, std::span<const Log> logs, const Wls& method);

/// The same from one log.
template <typename Method>
Identification identify(const Robot& robot, const Log& log, const Method& method) {
  return identify(robot, std::span<const Log>(&log, 1), method);
}

/// Cross-validation: the torques of a log that took no part in the fit, against the identified model on it, by the
/// same signal chain.
[[nodiscard]] Validation validate(const Robot& robot, const Identification& identification, const Log& log,
                                  int threads = 1);

}  // namespace rivid
