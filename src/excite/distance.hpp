#pragma once

#include "rivid/excite/space.hpp"
#include "rivid/types.hpp"

// Distances of straight lines from each other and from boxes.
namespace rivid::detail {

struct Segment {
  Eigen::Vector3d from;
  Eigen::Vector3d to;

  [[nodiscard]] Eigen::Vector3d at(double part) const { return from + part * (to - from); }
};

/// The nearest points of two bodies; where they touch, any that they share.
struct Nearest {
  Eigen::Vector3d first;
  Eigen::Vector3d second;

  [[nodiscard]] double distance() const { return (first - second).norm(); }
};

[[nodiscard]] Nearest nearest(const Segment& a, const Segment& b);
[[nodiscard]] Nearest nearest(const Segment& a, const Box& box);

}  // namespace rivid::detail
