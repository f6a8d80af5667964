#pragma once

#include <vector>

#include "odd/draw_arm.hpp"
#include "odd/machine.hpp"
#include "odd/motion.hpp"
#include "odd/recipe.hpp"

namespace rivid::odd {

/// A controller: PD or PID on the readings of the encoders, with the gravity torques of a model that is
/// nearly right.
struct Controller {
  bool continuous = false;
  Numbers k_p, k_v, k_i;
  double velocity_cutoff = 0.0;  ///< of its filter of differenced readings [rad/s]
  double gravity_share = 1.0;    ///< of the true gravity torques that it feeds forward
  int delay = 0;                 ///< periods
  Numbers limit;                 ///< of the torques; empty: none
};
[[nodiscard]] Controller drawn_controller(const Recipe& recipe, const Machine& machine,
                                          const RandomMotion& motion, Random& random);

/// What was recorded of one motion: one row a sample, one column a joint.
struct Recording {
  Vector t;
  Matrix q, tau, q_r;
};

/// Thrown where a loop is not stable.
struct Diverged {};

/// Runs the machine and records it as the recipe says, before anything goes wrong with the log.
///
/// @throws Diverged
[[nodiscard]] Recording recorded(const Recipe& recipe, const Plant& plant, const Controller& controller,
                                 const RandomMotion& motion, Random& random);

/// What goes wrong with a log, by the recipe.
void spoil(const Recipe& recipe, Recording& log, Random& random);

}  // namespace rivid::odd
