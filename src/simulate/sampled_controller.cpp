#include "simulate/sampled_controller.hpp"

#include <cmath>

namespace rivid::detail {

SampledController::SampledController(const ControlLaw& law, const Reference& reference,
                                     const Sampling& sampling, Index n)
    : law_(law),
      reference_(reference),
      sampling_(sampling),
      q_(n),
      qd_(Vector::Zero(n)),
      x_(Vector::Zero(law.states())),
      xd_(Vector::Zero(law.states())),
      q_r_(n),
      qd_r_(n),
      qdd_r_(n),
      v_(Vector::Zero(n)),
      measured_(n, static_cast<Index>(sampling.velocity_filter.size())),
      computed_(Matrix::Zero(n, sampling.delay + 1)) {}

const Vector& SampledController::tick(double t, const Eigen::Ref<const Vector>& q,
                                      const Eigen::Ref<const Vector>& qd) {
  q_ = q;
  if (ticks_ < sampling_.position_noise.rows()) {
    q_ += sampling_.position_noise.row(ticks_).transpose();
  }
  for (Index j = 0; j < sampling_.quantum.size(); ++j) {
    if (const double quantum = sampling_.quantum[j]; quantum > 0) {
      q_[j] = quantum * std::round(q_[j] / quantum);
    }
  }

  const Index taps = measured_.cols();
  if (taps == 0) {
    qd_ = qd;
  } else {
    if (ticks_ == 0) {
      measured_.colwise() = q_;
    }
    measured_.col(ticks_ % taps) = q_;
    qd_.setZero();
    for (Index i = 0; i < taps; ++i) {
      const double weight = sampling_.velocity_filter[static_cast<std::size_t>(i)] / sampling_.period;
      qd_ += weight * measured_.col((ticks_ + taps - i) % taps);
    }
  }

  reference_.at(t + sampling_.reference_lead * sampling_.period, q_r_, qd_r_, qdd_r_);
  const Index slots = computed_.cols();
  law_.control({t, q_, qd_, q_r_, qd_r_, qdd_r_}, x_, computed_.col(ticks_ % slots), xd_);
  x_ += sampling_.period * xd_;
  // Until the first signal has come through its delay nothing acts.
  v_ = computed_.col((ticks_ + 1) % slots);
  ++ticks_;
  return v_;
}

}  // namespace rivid::detail
