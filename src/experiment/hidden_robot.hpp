#pragma once

#include <cstdint>
#include <optional>

#include "rivid/excite/excitation.hpp"
#include "rivid/experiment/rehearsal.hpp"
#include "rivid/model/robot.hpp"

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

}  // namespace rivid::detail
