#pragma once

#include <array>
#include <vector>

#include "rivid/regressor/regressor.hpp"

// The regressor without any short way: every frame is turned by all nine entries of its rotation, every
// offset counts, every link gives all ten entries.
namespace rivid::test {

using detail::FrameMotion;
using detail::Mat3;
using detail::Screw;
using detail::Vec3;

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
      detail::sin_cos(q, s_, c_);
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

// Torque of joint i per unit of each inertial parameter of frame j, for all i ≤ j: every link's motion is
// carried from base to tip, and with it the screws of all joints before it; a joint's torque is the power of
// the link's wrench on that joint's screw. emit: called as emit(i, j, entries).
template <typename Scalar, typename Emit>
void inertial_regressor(const Chain& chain, const State<Scalar>& state, const Emit& emit) {
  std::vector<Screw<Scalar>> screws(chain.links.size());
  FrameMotion<Scalar> motion = base_motion<Scalar>(chain);
  std::array<Scalar, inertial_count> entries;
  for (std::size_t j = 0; j < chain.links.size(); ++j) {
    const Passage<Scalar> passage(chain.links[j], state.q[j]);
    for (std::size_t i = 0; i < j; ++i) {
      screws[i] = passage.carried(screws[i]);
    }
    screws[j] = passage.own_screw();
    motion = passage.carried(motion, state.qd[j], state.qdd[j]);

    const Mat3<Scalar> U = acceleration_field(motion);
    const auto moments = detail::TensorMoments<Scalar>::of(motion, U);
    for (std::size_t i = 0; i <= j; ++i) {
      const Screw<Scalar>& s = screws[i];
      for (std::size_t k = 0; k < 6; ++k) {
        entries[k] = dot(s.w, moments.k[k]);
      }
      // Force U MS through the linear part, moment MS × accel through the angular one.
      const Vec3<Scalar> first = U.transposed_times(s.v) + cross(motion.accel, s.w);
      entries[6] = first.x;
      entries[7] = first.y;
      entries[8] = first.z;
      entries[9] = dot(s.v, motion.accel);
      emit(i, j, entries);
    }
  }
}

/// Rows of all joints, (n) of as many entries as there are parameters.
template <typename Scalar>
std::vector<std::vector<Scalar>> regressor_oracle(const Robot& robot,
                                                  const std::vector<StandardParameter>& parameters,
                                                  const State<Scalar>& state) {
  const std::size_t n = robot.joints.size();
  std::vector<std::vector<Scalar>> out(n, std::vector<Scalar>(parameters.size(), Scalar(0)));
  const auto for_each = [&](const auto& use) {
    for (std::size_t c = 0; c < parameters.size(); ++c) {
      use(c, parameters[c].kind, static_cast<std::size_t>(parameters[c].joint));
    }
  };
  inertial_regressor(robot.chain, state, [&](std::size_t i, std::size_t j, const auto& entries) {
    for_each([&](std::size_t c, ParameterKind kind, std::size_t joint) {
      if (joint == j && role(kind) == Role::inertial) {
        const InertialColumn at = inertial_column(robot.chain.links[j], kind);
        out[i][c] = Scalar(at.sign) * entries[static_cast<std::size_t>(at.index)];
      }
    });
  });
  for_each([&](std::size_t c, ParameterKind kind, std::size_t j) {
    if (role(kind) != Role::inertial && !about(kind).coupled) {
      out[j][c] = role(kind) == Role::rotor ? state.qdd[j]
                                            : friction_entry(kind, state.qd[j], robot.joints[j].sign_speed);
    }
  });
  return out;
}

}  // namespace rivid::test
