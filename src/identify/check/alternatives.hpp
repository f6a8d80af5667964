#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "identify/check/probed_rows.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// A way in which robot or log may be other than the experiment says, by what it would do to the torques.
struct Alternative {
  std::string_view code;   // of the finding
  std::string subject;     // joint or joints
  Matrix effect;           // of each of its parameters, per unit, in weighted rows, (rows × k)
  bool turns = true;       // whether the joint is a revolute one
  double from = 0.0;       // of load_changed: part of the time that is over by then; 0: it comes and goes
  double inertia = 0.0;    // of joint_elasticity: mean of what the link alone has about its axis [kg·m² | kg]
  bool load = false;       // of logs_differ: whether the last link alone is another one
  bool by_blocks = false;  // tested by what goes of each block, for it may have many parameters
};

// Gravity turned by two small angles about the axes of gravity_tilt.
[[nodiscard]] Eigen::Vector3d tilted_gravity(const Robot& robot, const Vector& angles);

// All that are looked at: gains and zeros of joints, the direction of gravity, the clock, the geometry, a
// load that changes, friction laws, elastic joints, springs, motors that two joints turn.
[[nodiscard]] std::vector<Alternative> alternatives(const Robot& robot, const BaseParameters& base,
                                                    const ProbedRows& rows);

// A log by itself: bodies of its own, the last one or all, and columns of friction of its own.
struct OwnLog {
  std::vector<Alternative> bodies;
  Matrix friction;
};
[[nodiscard]] OwnLog own_log(const Robot& robot, const BaseParameters& base, const ProbedRows& rows,
                             std::size_t log);

}  // namespace rivid::detail
