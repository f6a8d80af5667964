#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "rivid/data/log.hpp"
#include "rivid/simulate/closed_loop.hpp"

namespace rivid {

/// Random errors of a simulated experiment: white, Gaussian, by CounterNoise.
struct NoiseOptions {
  Vector position = {};  ///< standard deviation of measured positions, (n) or empty [rad | m]
  Vector torque = {};    ///< of recorded torques; the drives never feel it, (n) or empty [N·m | N]
  Vector disturbance =
      {};  ///< of torques beside the drives, held for a period, not recorded, (n) or empty [N·m | N]
  /// Whether position noise and the quantum of the sampling go through the controller; else they are in the log alone.
  bool feedback = true;
  std::uint64_t seed = 1;

  /// The first fault found, nothing if the options can be used.
  ///
  /// @param n  joints
  [[nodiscard]] std::optional<std::string> complaint(Index n) const;
};

/// Options of a simulation with the errors that act while the robot moves: disturbance, and position noise where it is
/// fed back. Without feedback the controller measures without an error.
///
/// @param options  what is simulated, position_noise and disturbance empty; samples not 0
/// @param n        joints
/// @throws InputError  the noise's complaint(); where feedback is asked for of errors of the measurement and the law is
///                     continuous, or samples of the log fall between the instants of the controller; where the periods are too
///                     many to draw noise for
[[nodiscard]] SimulationOptions with_noise(SimulationOptions options, const NoiseOptions& noise, Index n);

/// What a recorder keeps of a simulation, a Log as read_csv() reads it: measured positions, control signals and torques
/// that act from t_k on, references. Rows from the first one that is not finite are left out: a loop that diverges may
/// end in such.
///
/// @param options  those of the simulation before with_noise()
/// @param noise    errors of the record: torque noise, and position noise where it is not fed back
[[nodiscard]] Log measured_log(const Simulation& simulation, const SimulationOptions& options,
                               const NoiseOptions& noise);

}  // namespace rivid
