#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rivid/excite/excitation.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/rehearsal.hpp"

namespace rivid::detail {

/// A robot that an identification knows nothing of.
struct HiddenRobot {
  Robot robot;
  Vector chi_st;  ///< true values of robot.standard_parameters(), (N_s)
};

/// drawn_about() a description. Rotors and friction that it does not know are drawn in proportion to inertias
/// and torques of the motion.
///
/// @param tau  a-priori torques of the motion, (n_m × n)
/// @throws NumericsError  where a joint of the description has no inertia
[[nodiscard]] HiddenRobot drawn_robot(const Robot& described, const Motion& motion, const Matrix& tau,
                                      double spread, std::uint64_t seed);

/// The same robot with what a trouble changes of the robot itself.
[[nodiscard]] HiddenRobot with_trouble(HiddenRobot hidden, std::optional<Trouble> trouble);

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
