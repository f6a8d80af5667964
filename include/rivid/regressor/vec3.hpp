#pragma once

#include <cmath>

namespace rivid::detail {

// Three numbers of any Scalar. Eigen's own vectors carry alignment and expression templates that a pack of
// samples as Scalar does not get along with; the kernels need no more than this. Nothing here may come from
// Eigen or be compiled out of line: the vector kernels include it under other instruction sets.
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
[[gnu::always_inline]] inline Vec3<Scalar> scaled(const Scalar& a, const Vec3<Scalar>& v) {
  return {a * v.x, a * v.y, a * v.z};
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

// Twist of an earlier joint, per unit of its rate, at the origin and in the axes of the present frame.
template <typename Scalar>
struct Screw {
  Vec3<Scalar> w;  // angular part
  Vec3<Scalar> v;  // linear part: velocity of the frame's origin
};

// Motion of the present link's frame, in its own axes.
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

// The step from frame j−1 to frame j where what is known of the chain beforehand is put to use: which
// rotations are quarter turns, which offsets are zero. Like vec3.hpp for the vector kernels: nothing from
// Eigen, nothing out of line.

// Rotation from frame j−1 to frame j at q_j = 0, apart from a constant angle about z_j.
enum class Turn : int {
  none,     // axes as before
  plus,     // a quarter about x
  minus,    // a quarter about −x
  about_x,  // any angle about x: tables of modified Denavit-Hartenberg parameters
  any
};

// Frame j in frame j−1, as the kernels read it.
struct Frame {
  double R[9];                   // rows of the rotation that `turn` speaks of, see turned()
  double p[3];                   // origin of frame j in frame j−1
  double cos_theta, sin_theta;   // constant angle about z_j beside it
  bool revolute, shifted_angle;  // θ is not zero
};

// Sine and cosine together; a Scalar with a faster way than two calls has its own overload.
template <typename Scalar>
[[gnu::always_inline]] inline void sin_cos(const Scalar& q, Scalar& s, Scalar& c) {
  using std::cos;
  using std::sin;
  s = sin(q);
  c = cos(q);
}

template <typename Scalar>
struct CosSin {
  Scalar c, s;
};

template <typename Scalar>
[[gnu::always_inline]] inline Vec3<Scalar> constant(const double* v) {
  return {Scalar(v[0]), Scalar(v[1]), Scalar(v[2])};
}

// Joint j's own rotation, after the constant one.
template <typename Scalar>
[[gnu::always_inline]] inline Vec3<Scalar> rotated(const Vec3<Scalar>& a, const Scalar& c, const Scalar& s) {
  return {c * a.x + s * a.y, c * a.y - s * a.x, a.z};
}

template <Turn turn, typename Scalar>
[[gnu::always_inline]] inline Vec3<Scalar> turned(const double* R, const Vec3<Scalar>& v) {
  if constexpr (turn == Turn::none) {
    return v;
  } else if constexpr (turn == Turn::plus) {
    return {v.x, v.z, -v.y};
  } else if constexpr (turn == Turn::minus) {
    return {v.x, -v.z, v.y};
  } else if constexpr (turn == Turn::about_x) {
    return {v.x, Scalar(R[4]) * v.y + Scalar(R[7]) * v.z, Scalar(R[5]) * v.y + Scalar(R[8]) * v.z};
  } else {
    return {Scalar(R[0]) * v.x + Scalar(R[3]) * v.y + Scalar(R[6]) * v.z,
            Scalar(R[1]) * v.x + Scalar(R[4]) * v.y + Scalar(R[7]) * v.z,
            Scalar(R[2]) * v.x + Scalar(R[5]) * v.y + Scalar(R[8]) * v.z};
  }
}

// v + w × p, where bits 0, 1, 2 of `offsets` say which of the components of p are not zero.
template <unsigned offsets, typename Scalar>
[[gnu::always_inline]] inline Vec3<Scalar> shifted(const Vec3<Scalar>& v, const Vec3<Scalar>& w,
                                                   const double* p) {
  Vec3<Scalar> out = v;
  if constexpr ((offsets & 1U) != 0U) {
    out.y = out.y + w.z * Scalar(p[0]);
    out.z = out.z - w.y * Scalar(p[0]);
  }
  if constexpr ((offsets & 2U) != 0U) {
    out.x = out.x - w.z * Scalar(p[1]);
    out.z = out.z + w.x * Scalar(p[1]);
  }
  if constexpr ((offsets & 4U) != 0U) {
    out.x = out.x + w.y * Scalar(p[2]);
    out.y = out.y - w.x * Scalar(p[2]);
  }
  return out;
}

// a + U p.
template <unsigned offsets, typename Scalar>
[[gnu::always_inline]] inline Vec3<Scalar> accelerated(const Vec3<Scalar>& a, const Mat3<Scalar>& U,
                                                       const double* p) {
  Vec3<Scalar> out = a;
  if constexpr ((offsets & 1U) != 0U) {
    const auto x = Scalar(p[0]);
    out = {out.x + U.r0.x * x, out.y + U.r1.x * x, out.z + U.r2.x * x};
  }
  if constexpr ((offsets & 2U) != 0U) {
    const auto y = Scalar(p[1]);
    out = {out.x + U.r0.y * y, out.y + U.r1.y * y, out.z + U.r2.y * y};
  }
  if constexpr ((offsets & 4U) != 0U) {
    const auto z = Scalar(p[2]);
    out = {out.x + U.r0.z * z, out.y + U.r1.z * z, out.z + U.r2.z * z};
  }
  return out;
}

// The angle of a joint with the constant one of its frame.
template <typename Scalar>
[[gnu::always_inline]] inline CosSin<Scalar> with_theta(const Frame& frame, const CosSin<Scalar>& angle) {
  if (!frame.shifted_angle) {
    return angle;
  }
  const auto cos_theta = Scalar(frame.cos_theta);
  const auto sin_theta = Scalar(frame.sin_theta);
  return {angle.c * cos_theta - angle.s * sin_theta, angle.s * cos_theta + angle.c * sin_theta};
}

// Motion of frame j−1 where and as frame j stands, before joint j's own.
template <Turn turn, unsigned offsets, typename Scalar>
[[gnu::always_inline]] inline FrameMotion<Scalar> carried(const Frame& frame, const FrameMotion<Scalar>& m,
                                                          const Mat3<Scalar>& U,
                                                          const CosSin<Scalar>& angle) {
  const auto into = [&](const Vec3<Scalar>& v) {
    return rotated(turned<turn>(frame.R, v), angle.c, angle.s);
  };
  return {into(m.omega), into(m.omega_dot), into(accelerated<offsets>(m.accel, U, frame.p))};
}

// A revolute joint's own rate: ω × z q̇ before the rate is added, which is along z.
template <typename Scalar>
[[gnu::always_inline]] inline void spin(FrameMotion<Scalar>& m, const Scalar& qd) {
  m.omega_dot.x = m.omega_dot.x + m.omega.y * qd;
  m.omega_dot.y = m.omega_dot.y - m.omega.x * qd;
  m.omega.z = m.omega.z + qd;
}

// A prismatic joint's own way and rate.
template <typename Scalar>
[[gnu::always_inline]] inline void slide(FrameMotion<Scalar>& m, const Mat3<Scalar>& U, const Scalar& q,
                                         const Scalar& qd) {
  const Scalar twice = qd + qd;
  m.accel.x = m.accel.x + U.r0.z * q + m.omega.y * twice;
  m.accel.y = m.accel.y + U.r1.z * q - m.omega.x * twice;
  m.accel.z = m.accel.z + U.r2.z * q;
}

// Calls add<turn, offsets>(of) for each case that is worth a step of its own, where `of` are the offsets it
// is meant for: rotations by any angle cost more than what offsets that are zero would save.
template <typename Add>
constexpr void for_each_step(const Add& add) {
  const auto quarter = [&]<Turn turn>() {
    add.template operator()<turn, 0>(0);
    add.template operator()<turn, 1>(1);
    add.template operator()<turn, 2>(2);
    add.template operator()<turn, 3>(3);
    add.template operator()<turn, 4>(4);
    add.template operator()<turn, 5>(5);
    add.template operator()<turn, 7>(6);
    add.template operator()<turn, 7>(7);
  };
  const auto oblique = [&]<Turn turn>() {
    for (unsigned offsets = 0; offsets < 8; ++offsets) {
      add.template operator()<turn, 7>(offsets);
    }
  };
  quarter.template operator()<Turn::none>();
  quarter.template operator()<Turn::plus>();
  quarter.template operator()<Turn::minus>();
  oblique.template operator()<Turn::about_x>();
  oblique.template operator()<Turn::any>();
}

}  // namespace rivid::detail
