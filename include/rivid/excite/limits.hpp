#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// What a designed motion must keep to. A list has one value a joint; one that is empty stands for the limits of the robot's
/// description, of which the motion uses the shares.
struct MotionLimits {
  Vector lower = {};         ///< positions, (n) [rad | m]
  Vector upper = {};         ///< (n)
  Vector velocity = {};      ///< (n) [rad/s | m/s]
  Vector acceleration = {};  ///< (n); empty: no limit but that of the torques [rad/s² | m/s²]
  Vector jerk = {};          ///< (n); empty: no limit [rad/s³ | m/s³]
  Vector torque = {};        ///< (n) [N·m | N]
  double position_share = 0.95;
  double velocity_share = 0.9;
  double torque_share = 0.8;

  /// @param n  joints of the robot
  [[nodiscard]] std::optional<std::string> complaint(Index n) const;

  /// Of joints, in a search that has to find its way between them.
  static constexpr Range positions = Range::within(-1e4, 1e4);

  template <typename L = MotionLimits>
  static constexpr auto fields() {
    constexpr Range positive = Range::above(0.0, 1e12);
    return std::tuple(
        Field{"lower",
              &L::lower,
              "lowest positions",
              {.otherwise = "the robot's", .unit = "rad, m", .range = positions}},
        Field{"upper",
              &L::upper,
              "highest positions",
              {.otherwise = "the robot's", .unit = "rad, m", .range = positions}},
        Field{"velocity",
              &L::velocity,
              "largest velocities",
              {.otherwise = "the robot's", .unit = "rad/s, m/s", .range = positive}},
        Field{"acceleration",
              &L::acceleration,
              "largest accelerations; required where torques can not be limited",
              {.otherwise = "none", .unit = "rad/s², m/s²", .range = positive}},
        Field{"jerk",
              &L::jerk,
              "largest derivatives of the accelerations",
              {.otherwise = "none", .unit = "rad/s³, m/s³", .range = positive}},
        Field{"torque",
              &L::torque,
              "largest torques, of the a-priori model",
              {.otherwise = "the robot's", .unit = "N·m, N", .range = positive}},
        Field{"position_share",
              &L::position_share,
              "part of the range of positions, about its middle, that the motion may use",
              {.range = Range::within(0.01, 1.0)}},
        Field{"velocity_share",
              &L::velocity_share,
              "part of the velocities that the motion may use",
              {.range = Range::within(0.01, 1.0)}},
        Field{"torque_share",
              &L::torque_share,
              "part of the torques that the motion may use: the rest is for what the a-priori model "
              "does not know",
              {.range = Range::within(0.01, 1.0)}});
  }
};

/// What a motion may use of the limits, (n) each; infinite where there is no limit.
struct MotionBounds {
  Vector lower;                   ///< [rad | m]
  Vector upper;                   ///< [rad | m]
  Vector velocity;                ///< [rad/s | m/s]
  Vector acceleration;            ///< [rad/s² | m/s²]
  Vector jerk;                    ///< [rad/s³ | m/s³]
  Vector torque;                  ///< [N·m | N]
  std::vector<Finding> findings;  ///< what was taken for granted
};

/// Limits of a robot's motion from its description and what is said besides. A revolute joint without a position limit
/// is kept above −π or below π. Without a-priori inertial parameters torques can not be predicted, and have no limit.
///
/// @throws InputError  where the limits can not be used, or leave no room; the message names the joint
[[nodiscard]] MotionBounds motion_bounds(const Robot& robot, const MotionLimits& limits);

/// The first limit that is missing for a design, in words that name the joint; nothing where none is: positions and
/// velocities must be bounded, and accelerations or torques.
[[nodiscard]] std::optional<std::string> missing_limit(const Robot& robot, const MotionBounds& bounds);

}  // namespace rivid
