#pragma once

namespace rivid::detail {

// Three numbers of any Scalar. Eigen's own vectors carry alignment and expression templates that a pack of
// samples as Scalar does not get along with; the kernels need no more than this. Nothing here may come from Eigen
// or be compiled out of line: the vector kernels include it under other instruction sets.
template <typename Scalar>
struct Vec3 {
  Scalar x, y, z;

  [[gnu::always_inline]] friend Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  [[gnu::always_inline]] friend Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
};

template <typename Scalar>
[[gnu::always_inline]] inline Scalar dot(const Vec3<Scalar>& a, const Vec3<Scalar>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <typename Scalar>
[[gnu::always_inline]] inline Vec3<Scalar> cross(const Vec3<Scalar>& a, const Vec3<Scalar>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Rows of a 3 × 3 matrix; here the acceleration field U = [ω̇]× + [ω]×².
template <typename Scalar>
struct Mat3 {
  Vec3<Scalar> r0, r1, r2;

  [[nodiscard, gnu::always_inline]] Vec3<Scalar> times(const Vec3<Scalar>& v) const {
    return {dot(r0, v), dot(r1, v), dot(r2, v)};
  }
  [[nodiscard, gnu::always_inline]] Vec3<Scalar> transposed_times(const Vec3<Scalar>& v) const {
    return {r0.x * v.x + r1.x * v.y + r2.x * v.z, r0.y * v.x + r1.y * v.y + r2.y * v.z,
            r0.z * v.x + r1.z * v.y + r2.z * v.z};
  }
};

}  // namespace rivid::detail
