#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// A joint that follows others, as a description names them:
///
///   q = offset + Σ factor q_k
///
/// A mimic joint of a URDF is one. A parallelogram is a tree whose loop is cut at one joint: its passive joints
/// are such sums of the driven ones, and no parameter of the loop is lost.
struct DependentJoint {
  std::string joint;
  std::map<std::string, double> of = {};  ///< factors by the names of the joints that it follows
  double offset = 0.0;                    ///< [rad | m]

  template <typename D = DependentJoint>
  static constexpr auto fields() {
    constexpr std::string_view named =
        "must name a joint and those that it follows: { joint = \"joint_3\", of = { joint_2 = -1 } }";
    return std::tuple(
        Field{"joint", &D::joint, "joint that follows others", {.required = named}},
        Field{"of",
              &D::of,
              "factors of the joints that it follows: `{ joint_2 = -1, joint_3 = 1 }`",
              {.unit = "unit of the joint per unit of the other", .required = named}},
        Field{"offset", &D::offset, "position where the others are at 0", {.unit = "rad or m"}});
  }
};

/// The same robot with these joints as Chain::dependents: its joints are the others, and torques,
/// positions and options are of these alone. One that follows a dependent joint follows what that one follows.
/// Friction, rotor inertia and limits of a dependent joint are no part of the robot.
///
/// @throws InputError  a joint that is named twice, is none of the robot or, in the end, follows itself; a factor
///                     of zero; no joint left
[[nodiscard]] Robot with_dependents(Robot robot, std::span<const DependentJoint> dependents);

/// The dependent joints of a robot by their names.
[[nodiscard]] std::vector<DependentJoint> dependent_joints(const Robot& robot);

}  // namespace rivid
