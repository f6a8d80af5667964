#pragma once

#include <span>
#include <string>

#include "rivid/model/robot.hpp"

namespace rivid {

/// One row of a modified Denavit-Hartenberg table (Khalil and Kleinfinger; Craig): frame j in frame j−1 is
///
///   T_j = RotX(alpha) TransX(a) RotZ(theta) TransZ(d)
///
/// and the joint's position is added to theta (revolute) or to d (prismatic).
struct MdhRow {
  JointType type = JointType::revolute;
  double alpha = 0.0;     ///< angle from z_{j−1} to z_j about x_{j−1} [rad]
  double a = 0.0;         ///< distance from z_{j−1} to z_j along x_{j−1} [m]
  double d = 0.0;         ///< distance from x_{j−1} to x_j along z_j, at q = 0 if prismatic [m]
  double theta = 0.0;     ///< angle from x_{j−1} to x_j about z_j, at q = 0 if revolute [rad]
  std::string name = {};  ///< of the joint; "joint_1", … if empty
};

/// The robot of a modified Denavit-Hartenberg table. Its links are "link_1", …, their standard parameters are told
/// in the frames of the table, and their a-priori values are zero.
///
/// @param gravity  acceleration of free fall in frame 0 [m/s²]
/// @throws InputError  an empty table, a value that is not finite
[[nodiscard]] Robot robot_from(std::span<const MdhRow> table,
                               const Eigen::Vector3d& gravity = {0.0, 0.0, -9.80665});

}  // namespace rivid
