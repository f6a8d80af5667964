#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "rivid/excite/excitation.hpp"
#include "rivid/fields.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// Controllers that a designed motion can be written for.
enum class Player {
  ros,       ///< trajectory_msgs/JointTrajectory as YAML, for joint_trajectory_controller
  urscript,  ///< a program for arms of Universal Robots
  libfranka  ///< one row a millisecond, for a callback of libfranka
};

template <>
inline constexpr std::array names_of<Player> =
    std::to_array<std::string_view>({"ros", "urscript", "libfranka"});

/// Name of a player's file in the folder of a design.
[[nodiscard]] std::string_view file_name(Player player);

/// Why a player cannot play the motions of a design: the wrong number of joints, a prismatic joint, limits
/// that it checks and that are not given, a duration that is not a whole number of its samples. Nothing where
/// it can.
[[nodiscard]] std::optional<std::string> complaint(Player player, const Robot& robot,
                                                   const ExcitationOptions& options);

/// The file that a player reads.
///
/// - `ros`: positions, velocities and accelerations, so that the controller interpolates by polynomials of
///   fifth degree; 50 points a second or more, which leaves 1e-6 of the amplitude between them.
/// - `urscript`: moves to the first pose and evaluates the Fourier series at each step of the controller
///   (`servoj`).
/// - `libfranka`: columns t, q1 … q7, qd1 … qd7, qdd1 … qdd7 at 1 kHz.
///
/// @param robot  of the design
/// @throws InputError  complaint()
[[nodiscard]] std::string player_file(Player player, const Robot& robot, const ExcitationOptions& options,
                                      const Excitation& excitation);

}  // namespace rivid
