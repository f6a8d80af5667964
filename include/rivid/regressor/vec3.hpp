#pragma once

#include "rivid/types.hpp"

namespace rivid::detail {

// Three numbers of any Scalar. Eigen's own vectors carry alignment and expression templates that a pack of
// samples as Scalar does not get along with; the kernels need no more than this.
template <typename Scalar>
struct Vec3 {
  Scalar x, y, z;

  friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
};

template <typename Scalar>
Scalar dot(const Vec3<Scalar>& a, const Vec3<Scalar>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename Scalar>
Vec3<Scalar> cross(const Vec3<Scalar>& a, const Vec3<Scalar>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Rᵀ v with a constant rotation: from the parent's axes to the joint's at q = 0.
template <typename Scalar>
Vec3<Scalar> transposed_times(const Eigen::Matrix3d& R, const Vec3<Scalar>& v) {
  return {R(0, 0) * v.x + R(1, 0) * v.y + R(2, 0) * v.z, R(0, 1) * v.x + R(1, 1) * v.y + R(2, 1) * v.z,
          R(0, 2) * v.x + R(1, 2) * v.y + R(2, 2) * v.z};
}

// Rows of a 3 × 3 matrix; here the acceleration field U = [ω̇]× + [ω]×².
template <typename Scalar>
struct Mat3 {
  Vec3<Scalar> r0, r1, r2;

  [[nodiscard]] Vec3<Scalar> times(const Vec3<Scalar>& v) const {
    return {dot(r0, v), dot(r1, v), dot(r2, v)};
  }
  [[nodiscard]] Vec3<Scalar> transposed_times(const Vec3<Scalar>& v) const {
    return {r0.x * v.x + r1.x * v.y + r2.x * v.z, r0.y * v.x + r1.y * v.y + r2.y * v.z,
            r0.z * v.x + r1.z * v.y + r2.z * v.z};
  }
};

}  // namespace rivid::detail
