#pragma once

#include <numbers>
#include <vector>

#include "rivid/model/mdh.hpp"

namespace rivid::test {

/// Staubli TX40 by its modified Denavit-Hartenberg table (BIRDy, TX40.m).
inline Robot tx40(Friction friction) {
  constexpr double quarter = std::numbers::pi / 2.0;
  const std::vector<MdhRow> table = {{.alpha = 0.0, .a = 0.0, .d = 0.32, .theta = 0.0},
                                     {.alpha = -quarter, .a = 0.0, .d = 0.0, .theta = -quarter},
                                     {.alpha = 0.0, .a = 0.225, .d = 0.035, .theta = quarter},
                                     {.alpha = quarter, .a = 0.0, .d = 0.225, .theta = 0.0},
                                     {.alpha = -quarter, .a = 0.0, .d = 0.0, .theta = 0.0},
                                     {.alpha = quarter, .a = 0.0, .d = 0.0, .theta = 0.0}};
  Robot robot = robot_from(table);
  for (Joint& joint : robot.joints) {
    joint.friction = friction;
  }
  return robot;
}

/// Its motor 6, which joint 5 turns as well: three columns of their own, the sign of the motor's velocity.
inline Coupling tx40_wrist() { return {.motor = 5, .joints = {4}, .ratios = {1.0}}; }

/// The same in BIRDy's reading: Iam6 is Ia6, and the signs are those of the single velocities.
inline Coupling tx40_wrist_of_birdy() {
  Coupling out = tx40_wrist();
  out.inertia = Coupling::Inertia::tied;
  out.coulomb = Coupling::Coulomb::single;
  return out;
}

}  // namespace rivid::test
