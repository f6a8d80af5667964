#pragma once

#include <span>
#include <string>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// Friction of one joint over its velocity, the other joints at rest: by its law, and in the rows of the fit.
struct FrictionCurve {
  std::string joint;  ///< its name
  /// Mean |τ| of what is no friction, at which friction in proportion to the load is shown [N·m | N].
  double load = 0.0;
  Vector velocity;  ///< points on either side of rest, ascending, (v) [rad/s | m/s]
  Vector torque;    ///< of the law, its offset included, (v) [N·m | N]
  Vector sigma;     ///< standard deviation of that by C_χχ; not a number without a covariance, (v) [N·m | N]
  Vector half_width;  ///< of the 95 % confidence interval, (v) [N·m | N]
  Vector a_priori;    ///< friction of the robot description, (v) [N·m | N]
  /// Mean over the rows of the fit that are nearest to the point: the measured torque less all of the model
  /// that is no friction; not a number without a row, (v) [N·m | N].
  Vector measured;
  Vector rows;  ///< their number, (v)
};

/// The friction curves of all joints whose law has a parameter, up to 1.05 times the largest velocity of the
/// rows.
///
/// @param logs  predictions() of a result; those of a validation take no part
/// @throws InputError  where robot, result and predictions are of different joints or parameters
[[nodiscard]] std::vector<FrictionCurve> friction_curves(const Robot& robot, const Identification& result,
                                                         std::span<const Prediction> logs);

/// A line a point: joint, velocity, friction, sigma, low_95, high_95, a_priori, measured, rows. Numbers read
/// back bit by bit.
[[nodiscard]] std::string to_csv(std::span<const FrictionCurve> curves);

}  // namespace rivid
