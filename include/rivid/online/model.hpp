#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

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
  if (robot.base_joints > 0) {
    return "the estimators of a control loop know no pose of the base, and that of robot \"" + robot.name +
           "\" floats";
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

namespace detail {

// The same model with friction that follows the load in each joint whose law has dry friction and lacks it:
// as nothing, with this deviation. Few identifications show it, and all gears with teeth have some.
inline OnlineModel with_load_friction(OnlineModel model, double sigma) {
  std::vector<int> joints;
  for (const BaseParameter& p : model.base.parameters) {
    const KindRow& row = about(p.leading.kind);
    if (row.basis == Basis::sign && !row.coupled && model.robot.couplings.empty()) {
      joints.push_back(p.leading.joint);
    }
  }
  for (const BaseParameter& p : model.base.parameters) {
    std::erase_if(joints,
                  [&](int j) { return about(p.leading.kind).basis == Basis::load && p.leading.joint == j; });
  }
  joints.erase(std::unique(joints.begin(), joints.end()), joints.end());  // both directions have a row
  const Index b = model.base.size();
  const auto more = sigma > 0.0 ? static_cast<Index>(joints.size()) : 0;
  Vector chi = Vector::Zero(b + more);
  Matrix C = Matrix::Zero(b + more, b + more);
  chi.head(b) = model.chi;
  C.topLeftCorner(b, b) = model.C_chi;
  for (Index i = 0; i < more; ++i) {
    const StandardParameter p = {ParameterKind::Fl, joints[static_cast<std::size_t>(i)]};
    model.base.parameters.push_back({p, p.name(), p.name(), ""});
    C(b + i, b + i) = sigma * sigma;
  }
  model.chi = chi;
  model.C_chi = C;
  return model;
}

}  // namespace detail

}  // namespace rivid
