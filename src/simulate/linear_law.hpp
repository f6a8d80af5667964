#pragma once

#include "rivid/simulate/control.hpp"

namespace rivid::detail {

// Feedback that is linear in the position error, the reference velocity and the velocity, joint by joint, (n) each:
// position (q_r − q) + reference_velocity q̇_r − velocity q̇.
struct LinearFeedback {
  Vector position;
  Vector reference_velocity;
  Vector velocity;
};

// What all laws with constant gains are: with u and w such feedbacks,
//
//   v = mixing u + x,   v_τ = sat(v),   ẋ = mixing w + (v_τ − v) / T_t
struct LinearGains {
  LinearFeedback direct;    // u
  LinearFeedback integral;  // w; empty vectors: no states
  Vector tracking_time;     // T_t, (n); used where there is an integral
  Matrix mixing;            // (n × n)
  Vector v_tau_max;         // (n), or empty
};

class LinearLaw final : public ControlLaw {
 public:
  LinearLaw(const LinearGains& gains, ControlDescription description);

  [[nodiscard]] Index states() const override { return integral_.position.cols(); }
  void control(const ControlInput& input, const Eigen::Ref<const Vector>& x, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> xd) const override;
  [[nodiscard]] ControlDescription description() const override { return description_; }

 private:
  // A feedback with the mixing multiplied in, (n × n) each.
  struct Mixed {
    Matrix position;
    Matrix reference_velocity;
    Matrix velocity;

    Mixed(const Matrix& mixing, const LinearFeedback& feedback);
    void add_to(Eigen::Ref<Vector> sum, const ControlInput& input) const;
  };

  Mixed direct_;
  Mixed integral_;
  Vector tracking_rate_;  // 1 / T_t, zero where there is no integral
  Vector v_tau_max_;
  ControlDescription description_;
};

}  // namespace rivid::detail
