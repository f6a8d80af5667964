#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "rivid/model/robot.hpp"

namespace rivid {

/// Who reads a sidecar. docs/write_back.md tells what each makes of its numbers.
enum class Sidecar {
  mujoco,    ///< default classes named after the joints: armature, damping, frictionloss
  drake,     ///< `<transmission>` elements for the URDF: drake:rotor_inertia, drake:gear_ratio
  pinocchio  ///< an SRDF with `<rotor_params>`
};

/// "mujoco", "drake", "pinocchio".
[[nodiscard]] std::string_view name(Sidecar sidecar);
[[nodiscard]] std::optional<Sidecar> sidecar_named(std::string_view name);

/// What a sidecar's file name ends in: ".mujoco.xml", ".drake.xml", ".srdf".
[[nodiscard]] std::string_view extension(Sidecar sidecar);

/// What a URDF has no place for, in the words of a program that reads URDFs: the rotor inertias. Ia is told on the
/// joint's side; where the format wants the rotor's, it is Ia / gear_ratio². Offsets, asymmetric friction and coupled
/// motors, which none of these formats knows either, are comments.
///
/// @param chi_st  values of robot.standard_parameters(), (N_s) [SI, joint side]
/// @return  well-formed XML, numbers with as many digits as it takes to read them back
/// @throws InputError  a wrong number of values, or one that is not finite; a negative Ia, damping or friction that the
///                     program would refuse
[[nodiscard]] std::string sidecar(Sidecar format, const Robot& robot, const Eigen::Ref<const Vector>& chi_st);

}  // namespace rivid
