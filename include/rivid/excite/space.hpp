#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Free space: all points x of the base frame with normal · x ≥ offset, as above a floor or before a wall.
struct HalfSpace {
  std::string name = {};
  Eigen::Vector3d normal = {0.0, 0.0, 1.0};  ///< made a unit vector
  double offset = 0.0;                       ///< [m]
};

/// An obstacle along the axes of the base frame.
struct Box {
  std::string name = {};
  Eigen::Vector3d min = {0.0, 0.0, 0.0};  ///< [m]
  Eigen::Vector3d max = {0.0, 0.0, 0.0};  ///< [m]
};

/// All points within a radius of a straight line, fixed to a link.
struct Capsule {
  std::string link = {};                   ///< name of the link; the base of the robot stands still
  Eigen::Vector3d from = {0.0, 0.0, 0.0};  ///< ends of the line in the link's frame [m]
  Eigen::Vector3d to = {0.0, 0.0, 0.0};
  double radius = 0.05;  ///< [m]
};

/// What a robot must not touch, itself included.
struct Space {
  std::vector<HalfSpace> half_spaces = {};
  std::vector<Box> boxes = {};
  /// Bodies of the links; a link without one gets a capsule from the origin of its joint to that of the next.
  std::vector<Capsule> capsules = {};
  double radius = 0.06;        ///< of the capsules that are not given [m]
  double clearance = 0.03;     ///< distance to keep [m]
  bool self_collision = true;  ///< whether links that are no neighbours keep it from each other

  /// Whether there is anything to keep clear of.
  [[nodiscard]] bool wanted() const { return !half_spaces.empty() || !boxes.empty() || !capsules.empty(); }

  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  template <typename S = Space>
  static constexpr auto fields() {
    return std::tuple(Field{"radius",
                            &S::radius,
                            "of the capsules of links that none are given for: from the origin of the link's "
                            "joint to that of "
                            "the next",
                            {.unit = "m", .range = Range::above(0.0, 1e3)}},
                      Field{"clearance",
                            &S::clearance,
                            "distance to keep from everything",
                            {.unit = "m", .range = Range::from(0.0, 1e3)}},
                      Field{"self_collision", &S::self_collision,
                            "whether links that are no neighbours keep it from each other"});
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
