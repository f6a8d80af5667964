#pragma once

#include <vector>

#include "rivid/simulate/closed_loop.hpp"

namespace rivid::detail {

// A control law on a computer: what it measures, what it makes of it, and when that acts.
class SampledController {
 public:
  SampledController(const ControlLaw& law, const Reference& reference, const Sampling& sampling, Index n);

  // One period: measures at t the true motion (q, q̇) and gives the control signals that act from t on.
  const Vector& tick(double t, const Eigen::Ref<const Vector>& q, const Eigen::Ref<const Vector>& qd);

  // Positions as measured at the last tick.
  [[nodiscard]] const Vector& q_measured() const { return q_; }

 private:
  const ControlLaw& law_;
  const Reference& reference_;
  const Sampling& sampling_;
  Index ticks_ = 0;
  Vector q_, qd_, x_, xd_, q_r_, qd_r_, qdd_r_, v_;
  Matrix measured_;  // (n × taps) the last positions, a ring
  Matrix computed_;  // (n × delay + 1) control signals that wait, a ring
};

}  // namespace rivid::detail
