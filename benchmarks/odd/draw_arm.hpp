#pragma once

#include "odd/arm.hpp"
#include "odd/machine.hpp"
#include "odd/motion.hpp"
#include "odd/recipe.hpp"

namespace rivid::odd {

/// A serial chain with physically consistent bodies that get lighter towards the tip.
[[nodiscard]] Arm drawn_arm(const Recipe& recipe, Random& random);

/// What the torques along a reference are like, without friction, (n) each.
struct Load {
  Numbers inertia;  ///< largest diagonal entry of M + Ia
  Numbers rms;      ///< of the torques
  Numbers largest;
};
[[nodiscard]] Load load_of(const Arm& arm, const Numbers& Ia, const RandomMotion& motion);

/// Rotors, friction and what the recipe adds, in proportion to the torques of a motion.
[[nodiscard]] Machine drawn_machine(const Recipe& recipe, const Arm& arm, const RandomMotion& motion,
                                    Random& random);

}  // namespace rivid::odd
