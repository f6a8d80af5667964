#pragma once

#include "rivid/regressor/vec3.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// R = turn · Rz(θ).
struct TurnAndAngle {
  Turn turn = Turn::any;
  Eigen::Matrix3d R;
  double cos_theta = 1.0;
  double sin_theta = 0.0;
};

[[nodiscard]] TurnAndAngle turn_and_angle(const Eigen::Matrix3d& R);

}  // namespace rivid::detail
