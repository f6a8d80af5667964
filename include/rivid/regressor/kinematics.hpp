#pragma once

#include "rivid/model/chain.hpp"
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

namespace rivid::detail {

// Rᵀ v with a constant rotation: from the parent's axes to the joint's at q = 0.
template <typename Scalar>
Vec3<Scalar> transposed_times(const Eigen::Matrix3d& R, const Vec3<Scalar>& v) {
  const auto row = [&](int k) {
    return Scalar(Scalar(R(0, k)) * v.x + Scalar(R(1, k)) * v.y + Scalar(R(2, k)) * v.z);
  };
  return {row(0), row(1), row(2)};
}

template <typename Scalar>
FrameMotion<Scalar> base_motion(const Chain& chain) {
  const Scalar zero(0);
  const Eigen::Vector3d& g = chain.gravity;
  return {{zero, zero, zero}, {zero, zero, zero}, {Scalar(-g.x()), Scalar(-g.y()), Scalar(-g.z())}};
}

// Passage from frame j−1 to frame j at joint position q: turns vectors and carries screws and motions along.
template <typename Scalar>
class Passage {
 public:
  Passage(const Chain::Link& link, const Scalar& q)
      : link_(link), p_{Scalar(link.p.x()), Scalar(link.p.y()), Scalar(link.p.z())} {
    if (link.type == JointType::revolute) {
      sin_cos(q, s_, c_);
    } else {
      const Eigen::Matrix3d& R = link.R;
      p_ = p_ + Vec3<Scalar>{Scalar(R(0, 2)) * q, Scalar(R(1, 2)) * q, Scalar(R(2, 2)) * q};
    }
  }

  // A vector of frame j−1 in the axes of frame j.
  [[nodiscard]] Vec3<Scalar> turned(const Vec3<Scalar>& v) const {
    const Vec3<Scalar> a = transposed_times(link_.R, v);
    if (link_.type == JointType::prismatic) {
      return a;
    }
    return {c_ * a.x + s_ * a.y, c_ * a.y - s_ * a.x, a.z};
  }

  [[nodiscard]] Screw<Scalar> carried(const Screw<Scalar>& s) const {
    return {turned(s.w), turned(s.v + cross(s.w, p_))};
  }

  [[nodiscard]] FrameMotion<Scalar> carried(const FrameMotion<Scalar>& m, const Scalar& qd,
                                            const Scalar& qdd) const {
    const Vec3<Scalar> accel = m.accel + acceleration_field(m).times(p_);
    FrameMotion<Scalar> out{turned(m.omega), turned(m.omega_dot), turned(accel)};
    if (link_.type == JointType::revolute) {
      // ω × z q̇ before the joint's own rate is added, which is along z.
      out.omega_dot = out.omega_dot + Vec3<Scalar>{out.omega.y * qd, -(out.omega.x * qd), qdd};
      out.omega.z = out.omega.z + qd;
    } else {
      const Scalar twice = qd + qd;
      out.accel = out.accel + Vec3<Scalar>{out.omega.y * twice, -(out.omega.x * twice), qdd};
    }
    return out;
  }

  // The joint's own screw in frame j.
  [[nodiscard]] Screw<Scalar> own_screw() const {
    const Scalar zero(0);
    const Scalar one(1);
    if (link_.type == JointType::revolute) {
      return {{zero, zero, one}, {zero, zero, zero}};
    }
    return {{zero, zero, zero}, {zero, zero, one}};
  }

 private:
  const Chain::Link& link_;
  Vec3<Scalar> p_;  // origin of frame j in frame j−1
  Scalar c_{1};
  Scalar s_{0};
};

}  // namespace rivid::detail
