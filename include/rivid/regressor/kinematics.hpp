#pragma once

#include "rivid/model/chain.hpp"
#include "rivid/regressor/vec3.hpp"

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
