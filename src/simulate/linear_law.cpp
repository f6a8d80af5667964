#include "simulate/linear_law.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "simulate/gains.hpp"

namespace rivid::detail {

LinearLaw::Mixed::Mixed(const Matrix& mixing, const LinearFeedback& feedback) {
  if (feedback.position.size() > 0) {
    position = mixing * feedback.position.asDiagonal();
    reference_velocity = mixing * feedback.reference_velocity.asDiagonal();
    velocity = mixing * feedback.velocity.asDiagonal();
  }
}

void LinearLaw::Mixed::add_to(Eigen::Ref<Vector> sum, const ControlInput& input) const {
  for (Index j = 0; j < position.cols(); ++j) {
    sum += (input.q_r[j] - input.q[j]) * position.col(j) + input.qd_r[j] * reference_velocity.col(j) -
           input.qd[j] * velocity.col(j);
  }
}

LinearLaw::LinearLaw(const LinearGains& gains, ControlDescription description)
    : direct_(gains.mixing, gains.direct),
      integral_(gains.mixing, gains.integral),
      tracking_rate_(Vector::Zero(integral_.position.cols())),
      v_tau_max_(or_constant(gains.v_tau_max, gains.mixing.rows(), std::numeric_limits<double>::infinity())),
      description_(std::move(description)) {
  for (Index i = 0; i < states(); ++i) {
    // Without an integral there is nothing that could wind up, and nothing that could unwind the correction.
    if (!integral_.position.row(i).isZero(0.0)) {
      tracking_rate_[i] = 1.0 / gains.tracking_time[i];
    }
  }
}

void LinearLaw::control(const ControlInput& input, const Eigen::Ref<const Vector>& x,
                        Eigen::Ref<Vector> v_tau, Eigen::Ref<Vector> xd) const {
  v_tau.setZero();
  direct_.add_to(v_tau, input);
  if (states() > 0) {
    v_tau += x;
    xd.setZero();
    integral_.add_to(xd, input);
  }
  for (Index i = 0; i < v_tau.size(); ++i) {
    const double saturated = std::clamp(v_tau[i], -v_tau_max_[i], v_tau_max_[i]);
    if (states() > 0) {
      xd[i] += tracking_rate_[i] * (saturated - v_tau[i]);
    }
    v_tau[i] = saturated;
  }
}

}  // namespace rivid::detail
