#pragma once

#include <limits>

#include "model/link_poses.hpp"
#include "rivid/model/collision.hpp"

namespace rivid::detail {

/// The convex hull of points, where it is.
struct PlacedHull {
  const Eigen::Matrix3Xd& points;
  LinkPose pose = {};

  [[nodiscard]] Eigen::Vector3d placed(const Eigen::Vector3d& point) const { return pose.o + pose.R * point; }
  /// The point that is farthest in a direction.
  [[nodiscard]] Eigen::Vector3d farthest(const Eigen::Vector3d& direction) const;
};

/// How far two convex bodies are apart, or how far they must be moved to be so.
struct Separation {
  Eigen::Vector3d first = Eigen::Vector3d::Zero();   ///< point of the first body
  Eigen::Vector3d second = Eigen::Vector3d::Zero();  ///< point of the second one
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< direction, from the second body to the first one
  double distance = 0.0;                             ///< negative: the bodies overlap
};

/// What all of two hulls is apart along a direction: their distance is no less, whoever found it.
[[nodiscard]] double gap(const PlacedHull& a, const PlacedHull& b, const Eigen::Vector3d& normal);

/// The distance of two hulls, to 1e-9 m. Of those that overlap the direction is a local optimum.
///
/// @param start   a direction that is near the normal, from the second hull to the first one; zero: none is
///                known
/// @param enough  of hulls that are farther apart the distance is a lower bound that is so, too
[[nodiscard]] Separation separation(const PlacedHull& a, const PlacedHull& b,
                                    const Eigen::Vector3d& start = Eigen::Vector3d::Zero(),
                                    double enough = std::numeric_limits<double>::infinity());

/// A hull of at most `most` of the points, whose radius encloses the others.
[[nodiscard]] Hull enclosing_hull(const Eigen::Matrix3Xd& points, Index most = 128);

}  // namespace rivid::detail
