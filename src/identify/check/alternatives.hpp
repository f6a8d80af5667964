#pragma once

#include <span>
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

// What speaks for an alternative.
struct AlternativeTest {
  std::size_t of = 0;      // place among the alternatives
  Vector estimate;         // of its parameters, (k)
  Vector sigma;            // (k)
  double statistic = 0.0;  // F
  double freedom = 0.0;    // its parameters that the rows can tell from others
  double p = 1.0;
  double held_out = 0.0;  // part of the sum of squares that goes with it, on blocks of time that took no part
  Matrix directions;      // combinations of its parameters that the rows show, (k × freedom)
  Vector shift;           // of the parameters χ̂ by it, (b)
};

// The score test of each alternative that explains anything, with a covariance of its scores by blocks of
// time.
[[nodiscard]] std::vector<AlternativeTest> tests(const ProbedRows& rows,
                                                 std::span<const Alternative> alternatives);

// An alternative for which something speaks, in a log of that sampling rate.
struct Told {
  const Robot& robot;
  const Alternative& it;
  const AlternativeTest& test;
  double f_m = 0.0;
  double value = test.estimate[0];  // of the first parameter
  double sigma = test.sigma[0];
};

// Words of an alternative, and its cure, which may be empty.
struct AlternativeWords {
  std::string what;
  std::string cure;
};

// What is known of a kind of alternatives, whatever the robot.
struct AlternativeKind {
  std::string_view code;
  bool fault = false;     // of robot or log, which makes parameters wrong; else what the model lacks
  bool positive = false;  // exists with positive coefficients alone
  double large =
      0.0;  // norm of the estimate above which it is no small error that something else looks like; 0: none
  AlternativeWords (*words)(const Told&) = nullptr;
  // What an experiment would change; none where no key of the file stands for it.
  std::vector<Change> (*changes)(const Told&) = nullptr;
};

[[nodiscard]] const AlternativeKind& kind_of(const Alternative& alternative);

}  // namespace rivid::detail
