#pragma once

#include "rivid/regressor/vec3.hpp"

namespace rivid::detail {

// Twist of an earlier joint, per unit of its rate, at the origin and in the axes of the present frame.
template <typename Scalar>
struct Screw {
  Vec3<Scalar> w;  // angular part
  Vec3<Scalar> v;  // linear part: velocity of the frame's origin
};

// Motion of the present link's frame, told in its own axes.
template <typename Scalar>
struct FrameMotion {
  Vec3<Scalar> omega;      // angular velocity
  Vec3<Scalar> omega_dot;  // angular acceleration
  Vec3<Scalar> accel;      // acceleration of the origin, less that of free fall
};

// [ω̇]× + [ω]×²: a point of the link at r accelerates with accel + U r.
template <typename Scalar>
[[gnu::always_inline]] inline Mat3<Scalar> acceleration_field(const FrameMotion<Scalar>& m) {
  const Scalar xx = m.omega.x * m.omega.x;
  const Scalar yy = m.omega.y * m.omega.y;
  const Scalar zz = m.omega.z * m.omega.z;
  const Scalar xy = m.omega.x * m.omega.y;
  const Scalar xz = m.omega.x * m.omega.z;
  const Scalar yz = m.omega.y * m.omega.z;
  return {{-(yy + zz), xy - m.omega_dot.z, xz + m.omega_dot.y},
          {xy + m.omega_dot.z, -(xx + zz), yz - m.omega_dot.x},
          {xz - m.omega_dot.y, yz + m.omega_dot.x, -(xx + yy)}};
}

// Moments that unit entries XX XY XZ YY YZ ZZ of the inertia tensor exert about the link's origin,
// I ω̇ + ω × I ω.
template <typename Scalar>
struct TensorMoments {
  Vec3<Scalar> k[6];

  // Most terms are also those of the acceleration field U.
  [[gnu::always_inline]] static TensorMoments of(const FrameMotion<Scalar>& m, const Mat3<Scalar>& U) {
    const Vec3<Scalar>& a = m.omega_dot;
    const Scalar xy = m.omega.x * m.omega.y;
    const Scalar xz = m.omega.x * m.omega.z;
    const Scalar yz = m.omega.y * m.omega.z;
    return {{{a.x, xz, -xy},
             {-U.r2.x, U.r2.y, U.r0.x - U.r1.y},
             {U.r1.x, U.r2.z - U.r0.x, -U.r1.z},
             {-yz, a.y, xy},
             {U.r1.y - U.r2.z, -U.r0.y, U.r0.z},
             {yz, -xz, a.z}}};
  }
};

}  // namespace rivid::detail
