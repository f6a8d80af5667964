#pragma once

#include <cmath>
#include <limits>

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

[[nodiscard]] inline TurnAndAngle turn_and_angle(const Eigen::Matrix3d& R) {
  // An entry of a rotation this small is a rounding error of the sine or cosine of a quarter turn.
  const auto is_nil = [](double x) { return std::abs(x) <= 4.0 * std::numeric_limits<double>::epsilon(); };
  TurnAndAngle out;
  out.R = R;
  if (!is_nil(R(0, 2))) {
    return out;
  }
  const double c = R(2, 2);
  const double s = -R(1, 2);
  out.R << 1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c;
  out.cos_theta = R(0, 0);
  out.sin_theta = -R(0, 1);
  if (is_nil(out.sin_theta) && out.cos_theta > 0.0) {
    out.cos_theta = 1.0;
    out.sin_theta = 0.0;
  }
  out.turn = Turn::about_x;
  if (is_nil(s) && c > 0.0) {
    out.turn = Turn::none;
  } else if (is_nil(c)) {
    out.turn = s > 0.0 ? Turn::plus : Turn::minus;
  }
  return out;
}

}  // namespace rivid::detail
