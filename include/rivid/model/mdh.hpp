#pragma once

#include <cmath>
#include <span>
#include <string>

#include "rivid/error.hpp"
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

/// The robot of a modified Denavit-Hartenberg table. Its links are "link_1", …, their standard parameters are
/// given in the frames of the table, and their a-priori values are zero.
///
/// @param gravity  acceleration of free fall in frame 0 [m/s²]
/// @throws InputError  an empty table, a value that is not finite
[[nodiscard]] Robot robot_from(std::span<const MdhRow> table,
                               const Eigen::Vector3d& gravity = {0.0, 0.0, -9.80665});

#ifdef RIVID_DEFINITIONS

RIVID_INLINE Robot robot_from(std::span<const MdhRow> table, const Eigen::Vector3d& gravity) {
  Robot robot;
  robot.chain.gravity = gravity;
  for (const MdhRow& row : table) {
    const std::string number = std::to_string(robot.joints.size() + 1);
    Joint joint;
    joint.type = row.type;
    joint.name = row.name.empty() ? "joint_" + number : row.name;
    joint.link = "link_" + number;

    const double sa = std::sin(row.alpha);
    const double ca = std::cos(row.alpha);
    const double st = std::sin(row.theta);
    const double ct = std::cos(row.theta);
    Chain::Link link;
    link.type = row.type;
    link.R << ct, -st, 0.0, ca * st, ca * ct, -sa, sa * st, sa * ct, ca;
    link.p << row.a, -row.d * sa, row.d * ca;

    robot.joints.push_back(joint);
    robot.chain.links.push_back(link);
    robot.inertials.emplace_back(Inertial::Zero());
  }
  if (const auto fault = robot.complaint()) {
    throw InputError("robot_from(MDH): " + *fault);
  }
  return robot;
}

#endif

}  // namespace rivid
