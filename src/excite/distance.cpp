#include <algorithm>
#include <array>

#include "excite/clearance.hpp"

namespace rivid::detail {

namespace {

// A line shorter than this is a point [m²].
constexpr double nothing = 1e-18;

double within_one(double part) { return std::clamp(part, 0.0, 1.0); }

}  // namespace

// Least squares over both parts, one after the other put back to the ends that it passes [Ericson 2005,
// 5.1.9].
Nearest nearest(const Segment& a, const Segment& b) {
  const Eigen::Vector3d u = a.to - a.from;
  const Eigen::Vector3d v = b.to - b.from;
  const Eigen::Vector3d w = a.from - b.from;
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  if (uu <= nothing) {
    return {a.from, b.at(vv <= nothing ? 0.0 : within_one(v.dot(w) / vv))};
  }
  if (vv <= nothing) {
    return {a.at(within_one(-u.dot(w) / uu)), b.from};
  }
  const double uv = u.dot(v);
  const double determinant = uu * vv - uv * uv;
  constexpr double parallel = 1e-14;
  double s =
      determinant > parallel * uu * vv ? within_one((uv * v.dot(w) - vv * u.dot(w)) / determinant) : 0.0;
  const double t = (v.dot(w) + s * uv) / vv;
  if (t < 0.0 || t > 1.0) {
    s = within_one((within_one(t) * uv - u.dot(w)) / uu);
  }
  return {a.at(s), b.at(within_one(t))};
}

// The squared distance along the line is convex, and quadratic between the planes of the box.
Nearest nearest(const Segment& a, const Box& box) {
  const Eigen::Vector3d u = a.to - a.from;
  std::array<double, 8> ends = {0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
  std::size_t count = 1;
  for (Index k = 0; k < 3; ++k) {
    for (const double plane : {box.min[k], box.max[k]}) {
      const double part = (plane - a.from[k]) / u[k];
      if (part > 0.0 && part < 1.0) {
        ends.at(count++) = part;
      }
    }
  }
  std::ranges::sort(ends);
  const auto out_of_box = [&](double part) -> Eigen::Vector3d {
    const Eigen::Vector3d x = a.at(part);
    return x - x.cwiseMax(box.min).cwiseMin(box.max);
  };
  const auto slope = [&](double part) { return u.dot(out_of_box(part)); };
  double part = slope(0.0) >= 0.0 ? 0.0 : 1.0;
  for (std::size_t k = 0; part == 1.0 && k + 1 < ends.size(); ++k) {
    const double low = slope(ends.at(k));
    const double high = slope(ends.at(k + 1));
    if (high >= 0.0) {
      part = high > low ? ends.at(k) - low * (ends.at(k + 1) - ends.at(k)) / (high - low) : ends.at(k);
    }
  }
  const Eigen::Vector3d x = a.at(part);
  return {x, x.cwiseMax(box.min).cwiseMin(box.max)};
}

}  // namespace rivid::detail
