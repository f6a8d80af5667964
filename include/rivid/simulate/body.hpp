#pragma once

#include "rivid/model/parameters.hpp"
#include "rivid/regressor/kinematics.hpp"

namespace rivid::detail {

// Force and moment about the origin of a frame, in its axes.
template <typename Scalar>
struct Wrench {
  Vec3<Scalar> force;
  Vec3<Scalar> moment;

  friend Wrench operator+(const Wrench& a, const Wrench& b) {
    return {a.force + b.force, a.moment + b.moment};
  }

  // The same, told in frame j−1.
  [[nodiscard]] Wrench before(const Passage<Scalar>& passage) const {
    const Vec3<Scalar> f = passage.turned_back(force);
    return {f, passage.turned_back(moment) + cross(passage.origin(), f)};
  }
};

// A rigid body, or several that are fixed to each other, in a frame: inertia tensor about its origin, first moments,
// mass.
template <typename Scalar>
struct Body {
  Mat3<Scalar> I;
  Vec3<Scalar> h;
  Scalar m;

  static Body of(const Inertial& inertial) {
    const auto entry = [&](int k) { return Scalar(inertial[k]); };
    return {{{entry(0), entry(1), entry(2)}, {entry(1), entry(3), entry(4)}, {entry(2), entry(4), entry(5)}},
            {entry(6), entry(7), entry(8)},
            entry(9)};
  }

  friend Body operator+(const Body& a, const Body& b) {
    return {{a.I.r0 + b.I.r0, a.I.r1 + b.I.r1, a.I.r2 + b.I.r2}, a.h + b.h, a.m + b.m};
  }

  // The same body, told in frame j−1.
  [[nodiscard]] Body before(const Passage<Scalar>& passage) const {
    // Each row turned, then the columns of what is left: R I Rᵀ.
    const Mat3<Scalar> rows = {passage.turned_back(I.r0), passage.turned_back(I.r1),
                               passage.turned_back(I.r2)};
    const Vec3<Scalar> x = passage.turned_back({rows.r0.x, rows.r1.x, rows.r2.x});
    const Vec3<Scalar> y = passage.turned_back({rows.r0.y, rows.r1.y, rows.r2.y});
    const Vec3<Scalar> z = passage.turned_back({rows.r0.z, rows.r1.z, rows.r2.z});
    const Vec3<Scalar> turned = passage.turned_back(h);
    const Vec3<Scalar>& p = passage.origin();
    const Vec3<Scalar> moved = {m * p.x, m * p.y, m * p.z};
    // By the parallel-axis theorem I grows by 2 (p·h) E − p hᵀ − h pᵀ + m (p·p E − p pᵀ) = (p·u) E − …, u = 2 h + m p.
    const Vec3<Scalar> u = turned + turned + moved;
    const Vec3<Scalar> v = turned + moved;
    const Scalar all = dot(p, u);
    const Scalar xy = y.x - (p.x * v.y + turned.x * p.y);
    const Scalar xz = z.x - (p.x * v.z + turned.x * p.z);
    const Scalar yz = z.y - (p.y * v.z + turned.y * p.z);
    return {
        {{x.x + all - p.x * u.x, xy, xz}, {xy, y.y + all - p.y * u.y, yz}, {xz, yz, z.z + all - p.z * u.z}},
        v,
        m};
  }

  // What it takes to move it so.
  [[nodiscard]] Wrench<Scalar> wrench(const FrameMotion<Scalar>& motion) const {
    const Vec3<Scalar> inertial = {m * motion.accel.x, m * motion.accel.y, m * motion.accel.z};
    return {inertial + acceleration_field(motion).times(h),
            I.times(motion.omega_dot) + cross(motion.omega, I.times(motion.omega)) + cross(h, motion.accel)};
  }
};

}  // namespace rivid::detail
