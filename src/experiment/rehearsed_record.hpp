#pragma once

#include <optional>
#include <vector>

#include "experiment/hidden_robot.hpp"
#include "rivid/experiment/experiment.hpp"

namespace rivid::detail {

/// A motion as it is to be played and recorded.
struct Scene {
  Log motion;
  HiddenRobot hidden;
  ControlLoop loop;
  NoiseOptions noise;  ///< of the record
  Vector
      signal_needed;  ///< largest control signals of the motion as planned, (n); empty before it was played
};

/// What the robot records.
struct Record {
  Log log;
  Vector largest_signal;          ///< of control, (n)
  std::vector<Finding> findings;  ///< where the motion is not carried through, or not followed
};

/// Plays the motion with the hidden robot in the simulator.
///
/// @param trouble  Trouble::saturation needs `signal_needed`
/// @throws InputError  where loop, noise and motion do not fit together
[[nodiscard]] Record played(const Scene& scene, std::optional<Trouble> trouble);

}  // namespace rivid::detail
