#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/types.hpp"

namespace rivid::detail {

/// Drive gains that follow from what a controller logged of its own model: currents and torques that it wants.
struct TargetGains {
  Vector gains;        ///< joint-side torque per unit of current, (n)
  double error = 0.0;  ///< of the currents by these gains and friction, relative, of the worst joint
};

/// Gains by least squares of each joint's wanted current over its wanted torque, velocity, the sign of that and 1, since
/// the current has the friction that the torque lacks; nothing where the log has no such columns ("itarget1" and
/// "tautarget1", "target_current_0" and "target_moment_0"), where they do not move, or where they do not fit together.
///
/// @param names     of all columns of the log
/// @param velocity  columns of the velocities, one a joint; empty: none
[[nodiscard]] std::optional<TargetGains> target_gains(const std::filesystem::path& log,
                                                      std::span<const std::string> names,
                                                      std::span<const std::string> velocity, Index joints);

}  // namespace rivid::detail
