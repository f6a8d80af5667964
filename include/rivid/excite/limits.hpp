#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/model/collision.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// What a designed motion must keep to. A list has one value a joint; one that is empty stands for the limits
/// of the robot's description, of which the motion uses the shares.
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
  /// Share by which masses, rotors and friction may be off: robots that differ from the description by so
  /// much, drawn at random, keep the whole torque limits too.
  double prior_spread = 0.0;

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
              "part of the torques that the motion may use",
              {.range = Range::within(0.01, 1.0)}},
        Field{"prior_spread",
              &L::prior_spread,
              "masses, rotors and friction may be off by this share: the whole torque limits hold for "
              "such robots too",
              {.range = Range::within(0.0, 0.9)}});
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

/// Limits of a robot's motion from its description and what is said besides. A revolute joint without a
/// position limit is kept above −π or below π. Without a-priori inertial parameters torques can not be
/// predicted, and have no limit.
///
/// @throws InputError  where the limits can not be used, or leave no room; the message names the joint
[[nodiscard]] MotionBounds motion_bounds(const Robot& robot, const MotionLimits& limits);

/// The first limit that is missing for a design, in words that name the joint; nothing where none is:
/// positions and velocities must be bounded, and accelerations or torques.
[[nodiscard]] std::optional<std::string> missing_limit(const Robot& robot, const MotionBounds& bounds);

/// Free space: all points x of the base frame with normal · x ≥ offset, as above a floor or before a wall.
struct HalfSpace {
  std::string name = {};
  Eigen::Vector3d normal = {0.0, 0.0, 1.0};  ///< made a unit vector
  double offset = 0.0;                       ///< [m]

  template <typename R = HalfSpace>
  static constexpr auto fields() {
    return std::tuple(
        Field{"normal", &R::normal, "direction of free space", {.required = "normal must be three numbers"}},
        Field{"offset",
              &R::offset,
              "the robot stays where normal · x is not below it",
              {.unit = "m", .required = "offset must be there"}},
        Field{"name", &R::name, "that messages and tables call it by", {.otherwise = "its number"}});
  }
};

/// An obstacle along the axes of the base frame.
struct Box {
  std::string name = {};
  Eigen::Vector3d min = {0.0, 0.0, 0.0};  ///< [m]
  Eigen::Vector3d max = {0.0, 0.0, 0.0};  ///< [m]

  template <typename R = Box>
  static constexpr auto fields() {
    return std::tuple(
        Field{"min", &R::min, "its lowest corner", {.unit = "m", .required = "min must be three numbers"}},
        Field{"max", &R::max, "its highest corner", {.unit = "m", .required = "max must be three numbers"}},
        Field{"name", &R::name, "that messages and tables call it by", {.otherwise = "its number"}});
  }
};

/// All points within a radius of a straight line, fixed to a link.
struct Capsule {
  std::string link = {};                   ///< name of the link; the base of the robot stands still
  Eigen::Vector3d from = {0.0, 0.0, 0.0};  ///< ends of the line in the link's frame [m]
  Eigen::Vector3d to = {0.0, 0.0, 0.0};
  double radius = 0.05;  ///< [m]

  template <typename R = Capsule>
  static constexpr auto fields() {
    return std::tuple(
        Field{"link", &R::link, "link that it is fixed to", {.otherwise = "required"}},
        Field{"from",
              &R::from,
              "one end of its line, in the link's frame",
              {.unit = "m", .required = "from must be three numbers"}},
        Field{"to", &R::to, "the other end", {.unit = "m", .required = "to must be three numbers"}},
        Field{"radius", &R::radius, "about the line", {.unit = "m", .required = "radius must be there"}});
  }
};

/// Two links that may come near each other.
struct LinkPair {
  std::string first = {};
  std::string second = {};

  template <typename R = LinkPair>
  static constexpr auto fields() {
    return std::tuple(Field{"first", &R::first, "link", {.otherwise = "required"}},
                      Field{"second", &R::second, "the other link", {.otherwise = "required"}});
  }
};

/// What a robot must not touch, itself included.
struct Space {
  std::vector<HalfSpace> half_spaces = {};
  std::vector<Box> boxes = {};
  /// Bodies of links, in place of those in `model`.
  std::vector<Capsule> capsules = {};
  /// Bodies of all other links; one without any gets a capsule from the origin of its joint to that of the
  /// next.
  CollisionModel model = {};
  std::vector<LinkPair> ignored = {};  ///< pairs of links that need no distance
  double radius = 0.06;                ///< of the capsules that are not given [m]
  double clearance = 0.03;             ///< distance to keep [m]
  bool self_collision = true;          ///< whether links keep it from each other

  /// Whether there is anything to keep clear of.
  [[nodiscard]] bool wanted() const {
    return !half_spaces.empty() || !boxes.empty() || !capsules.empty() || !model.hulls.empty();
  }

  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  template <typename S = Space>
  static constexpr auto fields() {
    return std::tuple(
        Field{"floor",
              Key<double>(),
              "height of the floor in the base frame",
              {.otherwise = "none", .unit = "m"}},
        Field{"half_spaces",
              Key<std::vector<HalfSpace>>(),
              "walls and ceilings: the robot stays where normal · x ≥ offset in the base frame",
              {.otherwise = "–", .unit = "m"}},
        Field{"boxes",
              Key<std::vector<Box>>(),
              "obstacles along the axes of the base frame",
              {.otherwise = "–", .unit = "m"}},
        Field{"capsules",
              Key<std::vector<Capsule>>(),
              "bodies of links: all points within a radius of a line in the link's frame",
              {.otherwise = "`<collision>` of the URDF", .unit = "m"}},
        Field{"radius",
              &S::radius,
              "of links without capsule and `<collision>`, about the lines between their frames",
              {.unit = "m", .range = Range::above(0.0, 1e3)}},
        Field{"clearance",
              &S::clearance,
              "distance to keep from everything",
              {.unit = "m", .range = Range::from(0.0, 1e3)}},
        Field{"self_collision", &S::self_collision, "whether links keep it from each other"},
        Field{"ignored",
              Key<std::vector<LinkPair>>(),
              "pairs of links that need not keep it",
              {.otherwise = "those that never do"}});
  }
};

/// How near a link comes to something.
struct ClearanceUse {
  std::string first;      ///< link
  std::string second;     ///< link or obstacle
  double distance = 0.0;  ///< the smallest [m]
  double wanted = 0.0;    ///< not a number for a pair that is left out [m]
  double time = 0.0;      ///< [s]

  template <typename R = ClearanceUse>
  static constexpr auto fields() {
    return std::tuple(Field{"first", &R::first, "link"}, Field{"second", &R::second, "link or obstacle"},
                      Field{"distance", &R::distance, "the smallest of the motion", {.unit = "m"}},
                      Field{"wanted",
                            &R::wanted,
                            "what it must not fall below; `null` for a pair that is left out",
                            {.unit = "m"}},
                      Field{"time", &R::time, "when", {.unit = "s"}});
  }
};

}  // namespace rivid
