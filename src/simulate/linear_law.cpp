#include "simulate/linear_law.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "simulate/gains.hpp"

namespace rivid::detail {

LinearLaw::LinearLaw(LinearGains gains, ControlDescription description)
    : gains_(std::move(gains)), tracking_rate_(Vector::Zero(states())), description_(std::move(description)) {
  gains_.v_tau_max =
      or_constant(gains_.v_tau_max, gains_.direct.position.size(), std::numeric_limits<double>::infinity());
  const Vector& integral = gains_.integral.position;
  for (Index i = 0; i < states(); ++i) {
    const bool integrates = gains_.mixing.size() == 0
                                ? integral[i] != 0.0
                                : (gains_.mixing.row(i).transpose().array() * integral.array() != 0.0).any();
    // Without an integral there is nothing that could wind up, and nothing that could unwind the correction.
    if (integrates) {
      tracking_rate_[i] = 1.0 / gains_.tracking_time[i];
    }
  }
}

void LinearLaw::mixed(const LinearFeedback& feedback, const ControlInput& input,
                      Eigen::Ref<Vector>& out) const {
  if (gains_.mixing.size() == 0) {
    for (Index j = 0; j < out.size(); ++j) {
      out[j] = feedback.of(input, j);
    }
    return;
  }
  out.setZero();
  for (Index j = 0; j < out.size(); ++j) {
    out += feedback.of(input, j) * gains_.mixing.col(j);
  }
}

void LinearLaw::control(const ControlInput& input, const Eigen::Ref<const Vector>& x,
                        Eigen::Ref<Vector> v_tau, Eigen::Ref<Vector> xd) const {
  mixed(gains_.direct, input, v_tau);
  const bool integrates = states() > 0;
  if (integrates) {
    v_tau += x;
    mixed(gains_.integral, input, xd);
  }
  for (Index i = 0; i < v_tau.size(); ++i) {
    const double saturated = std::clamp(v_tau[i], -gains_.v_tau_max[i], gains_.v_tau_max[i]);
    if (integrates) {
      xd[i] += tracking_rate_[i] * (saturated - v_tau[i]);
    }
    v_tau[i] = saturated;
  }
}

}  // namespace rivid::detail
