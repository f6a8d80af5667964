#pragma once

#include "rivid/simulate/control.hpp"

namespace rivid::detail {

// Feedback of one joint that is linear in the position error, the reference velocity and the velocity, (n) each:
// position (q_r − q) + reference_velocity q̇_r − velocity q̇.
struct LinearFeedback {
  Vector position;
  Vector reference_velocity;
  Vector velocity;

  [[nodiscard]] double of(const ControlInput& input, Index j) const {
    return position[j] * (input.q_r[j] - input.q[j]) + reference_velocity[j] * input.qd_r[j] -
           velocity[j] * input.qd[j];
  }
};

// What all laws with constant gains are: with u and w such feedbacks,
//
//   v = mixing u + x,   v_τ = sat(v),   ẋ = mixing w + (v_τ − v) / T_t
struct LinearGains {
  LinearFeedback direct;    // u
  LinearFeedback integral;  // w; empty vectors: no states
  Vector tracking_time;     // T_t, (n); used where there is an integral
  Matrix mixing;            // (n × n), empty: the identity
  Vector v_tau_max;         // (n), empty: no saturation
};

class LinearLaw final : public ControlLaw {
 public:
  LinearLaw(LinearGains gains, ControlDescription description);

  [[nodiscard]] Index states() const override { return gains_.integral.position.size(); }
  void control(const ControlInput& input, const Eigen::Ref<const Vector>& x, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> xd) const override;
  [[nodiscard]] ControlDescription description() const override { return description_; }

 private:
  void mixed(const LinearFeedback& feedback, const ControlInput& input, Eigen::Ref<Vector>& out) const;

  LinearGains gains_;
  Vector tracking_rate_;  // 1 / T_t, zero where there is no integral
  ControlDescription description_;
};

}  // namespace rivid::detail
