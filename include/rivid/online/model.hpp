#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/text.hpp"

namespace rivid {

/// An identified robot with its uncertainty, as the estimators of a control loop take it. read_online_model()
/// makes it of a result.json.
struct OnlineModel {
  Robot robot;
  BaseParameters base;        ///< of the robot, (b)
  Vector chi;                 ///< their values, (b) [SI, joint side]
  Matrix C_chi;               ///< and covariance, (b × b)
  Vector sigma_rho;           ///< standard deviation of the residual of each joint's rows, (n) [N·m | N]
  Vector velocity_threshold;  ///< speed below which a joint has no rows, (n) [rad/s | m/s]

  /// The first fault, or nothing.
  [[nodiscard]] std::optional<std::string> complaint() const;
};

inline std::optional<std::string> OnlineModel::complaint() const {
  if (const auto fault = robot.complaint()) {
    return fault;
  }
  const Index b = base.size();
  const Index n = robot.size();
  if (auto fault = base.complaint(robot)) {
    return fault;
  }
  if (chi.size() != b || C_chi.rows() != b || C_chi.cols() != b) {
    return "chi and C_chi must have " + std::to_string(b) + " values and as many rows and columns, not " +
           std::to_string(chi.size()) + " and " + std::to_string(C_chi.rows());
  }
  if (!chi.allFinite() || !C_chi.allFinite()) {
    return "chi or C_chi holds what is no number: the log did not determine all parameters";
  }
  for (Index i = 0; i < b; ++i) {
    if (!(C_chi(i, i) > 0.0)) {
      return "the variance of " + base.parameters[static_cast<std::size_t>(i)].name + " is " +
             number(C_chi(i, i)) + ", must be positive";
    }
  }
  if (sigma_rho.size() != n || velocity_threshold.size() != n) {
    return "sigma_rho and velocity_threshold must have " + std::to_string(n) + " values, one a joint";
  }
  for (Index j = 0; j < n; ++j) {
    const std::string& name = robot.joints[static_cast<std::size_t>(j)].name;
    if (!std::isfinite(sigma_rho[j]) || sigma_rho[j] <= 0.0) {
      return "sigma_rho of joint \"" + name + "\" is " + number(sigma_rho[j]) + ", must be positive";
    }
    if (!std::isfinite(velocity_threshold[j]) || velocity_threshold[j] < 0.0) {
      return "velocity_threshold of joint \"" + name + "\" is " + number(velocity_threshold[j]) +
             ", must not be negative";
    }
  }
  return std::nullopt;
}

}  // namespace rivid
