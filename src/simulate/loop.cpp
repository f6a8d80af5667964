#include "simulate/loop.hpp"

#include <algorithm>
#include <cmath>

#include "rivid/error.hpp"

namespace rivid::detail {

namespace {

// What a delay has beside whole periods; what is no longer than rounding is none.
double part_of_period(double delay) {
  constexpr double none = 1e-6;  // [periods] any value between the rounding of a delay and one that matters
  const double part = delay - std::floor(delay);
  return part < none || part > 1.0 - none ? 0.0 : part;
}

}  // namespace

LoopOde::LoopOde(const Robot& robot, const DynamicModel& model, const ControlLaw& law,
                 const Reference& reference, const SimulationOptions& options)
    : model_(model),
      law_(law),
      reference_(reference),
      n_(model.size()),
      states_(options.sampling.period > 0 ? 0 : law.states()),
      sampled_(options.sampling.period > 0),
      exact_(options.friction == DryFrictionScheme::exact),
      held_(options.friction == DryFrictionScheme::held),
      smooth_velocity_(options.smooth_velocity),
      smooth_elements_(std::ranges::any_of(
          model.dry_friction(), [](const DryFriction& element) { return element.sign_speed > 0.0; })),
      drive_(robot.drive_matrix()),
      diagonal_drive_(drive_.isDiagonal(0.0)),
      diagonal_viscous_(model.viscous().isDiagonal(0.0)),
      simple_(has_simple_torques()),
      dynamics_(model),
      stick_slip_(model),
      x_(Vector::Zero(states_)),
      xd_(Vector::Zero(states_)) {
  for (const DryFriction& element : model.dry_friction()) {
    if (held_ && element.load > 0.0) {
      throw InputError(
          "simulate: joint \"" + element.name +
          "\" has friction that follows its load, which can not be held for a step; take exact or "
          "smooth friction");
    }
  }
  for (Vector* v :
       {&q_, &qd_, &q_r_, &qd_r_, &qdd_r_, &v_tau_, &added_, &disturbance_, &tau_, &torque_, &friction_}) {
    *v = Vector::Zero(n_);
  }
}

bool LoopOde::has_simple_torques() const {
  const auto is_simple = [&](const DryFriction& law) {
    const auto terms = [&](Basis basis) {
      return std::ranges::count(law.terms, basis, &DryFriction::Term::basis);
    };
    const auto lines = terms(Basis::sign) + terms(Basis::speed);
    return law.load == 0.0 && (law.direction.array() != 0.0).count() == 1 &&
           (law.torque.array() != 0.0).count() == 1 && law.torque[law.joint()] != 0.0 &&
           terms(Basis::sign) <= 1 && terms(Basis::speed) <= 1 && lines == std::ssize(law.terms);
  };
  return sampled_ && exact_ && diagonal_viscous_ && !smooth_elements_ &&
         std::ranges::all_of(model_.dry_friction(), is_simple);
}

bool LoopOde::is_at(const double* y) const {
  return definite_ && std::equal(y, y + n_, q_.data()) && std::equal(y + n_, y + 2 * n_, qd_.data());
}

void LoopOde::return_to(const double* y) {
  const Index count = evaluations_;
  static_cast<void>(move_to(y));
  evaluations_ = count;
}

// M and N at y. Where only the torques have changed since the last call, at control instants, they are known.
bool LoopOde::move_to(const double* y) {
  if (is_at(y)) {
    return true;
  }
  ++evaluations_;
  q_ = Eigen::Map<const Vector>(y, n_);
  qd_ = Eigen::Map<const Vector>(y + n_, n_);
  const auto n = static_cast<std::size_t>(n_);
  definite_ = dynamics_.set_state({q_.data(), n}, {qd_.data(), n});
  return definite_;
}

void LoopOde::drive_torques() {
  if (diagonal_drive_) {
    tau_ = drive_.diagonal().cwiseProduct(v_tau_ + added_);
  } else {
    tau_.noalias() = drive_ * v_tau_;
    tau_.noalias() += drive_ * added_;
  }
  torque_ = tau_ + disturbance_;
}

const Vector& LoopOde::held_torque() {
  drive_torques();
  torque_ -= model_.offset();
  return torque_;
}

void LoopOde::torques_beside_bias(double t, const double* y, double* xd) {
  if (!sampled_) {
    x_ = Eigen::Map<const Vector>(y + 2 * n_, states_);
    reference_.at(t, q_r_, qd_r_, qdd_r_);
    law_.control({t, q_, qd_, q_r_, qd_r_, qdd_r_}, x_, v_tau_, xd_);
    Eigen::Map<Vector>(xd, states_) = xd_;
  }
  drive_torques();
  if (held_) {
    torque_ -= friction_;
    return;
  }
  torque_ -= model_.offset();
  if (diagonal_viscous_) {
    torque_ -= model_.viscous().diagonal().cwiseProduct(qd_);
  } else {
    torque_.noalias() -= model_.viscous() * qd_;
  }
  if (!exact_ || smooth_elements_) {
    brake_smoothly();
  }
}

bool LoopOde::torques(double t, const double* y, double* xd) {
  if (!move_to(y)) {
    return false;
  }
  torques_beside_bias(t, y, xd);
  torque_ -= Eigen::Map<const Vector>(dynamics_.N().data(), n_);
  return true;
}

void LoopOde::driving_torques(double t, const double* y, double* f) {
  q_ = Eigen::Map<const Vector>(y, n_);
  qd_ = Eigen::Map<const Vector>(y + n_, n_);
  definite_ = false;  // M and N are those of another state now
  torques_beside_bias(t, y, xd_.data());
  const auto n = static_cast<std::size_t>(n_);
  if (exact_) {
    stick_slip_.brake({qd_.data(), n}, {torque_.data(), n});
  }
  Eigen::Map<Vector>(f, n_) = torque_;
}

void LoopOde::smooth_friction(std::span<const double> qd, Vector& torque) const {
  const Eigen::Map<const Vector> velocities(qd.data(), n_);
  for (const DryFriction& law : model_.dry_friction()) {
    if (!exact_ || law.sign_speed > 0.0) {
      torque += law.lambda(law.direction.dot(velocities), smooth_velocity_) * law.torque;
    }
  }
}

void LoopOde::brake_smoothly() {
  friction_.setZero();
  smooth_friction({qd_.data(), static_cast<std::size_t>(n_)}, friction_);
  torque_ -= friction_;
  for (const DryFriction& law : model_.dry_friction()) {
    if (law.load > 0.0 && (!exact_ || law.sign_speed > 0.0)) {
      const Index j = law.joint();
      const double slope = law.load * sign(qd_[j], law.sign_speed > 0.0 ? law.sign_speed : smooth_velocity_);
      torque_[j] = DryFriction::carried(torque_[j], slope);
    }
  }
}

void LoopOde::hold_friction(const double* y) {
  const Eigen::Map<const Vector> qd(y + n_, n_);
  friction_ = model_.offset() + model_.viscous() * qd;
  smooth_friction({qd.data(), static_cast<std::size_t>(n_)}, friction_);
}

bool LoopOde::rate(double t, const double* y, double* yd) {
  const auto n = static_cast<std::size_t>(n_);
  if (!torques(t, y, yd + 2 * n_)) {
    return false;
  }
  Eigen::Map<Vector>(yd, n_) = qd_;
  const std::span<double> qdd(yd + n_, n);
  const std::span<const double> qd(qd_.data(), n);
  if (exact_) {
    stick_slip_.accelerate(dynamics_, qd, {torque_.data(), n}, qdd);
    return true;
  }
  Eigen::Map<Vector>(yd + n_, n_) = torque_;
  dynamics_.solve(qdd);
  return true;
}

void LoopOde::margins(const double* y, double* g) const {
  const std::span<const double> qd(y + n_, static_cast<std::size_t>(n_));
  for (Index e = 0; e < stick_slip_.size(); ++e) {
    g[e] = stick_slip_.margin(e, qd);
  }
}

bool LoopOde::settle(double t, double* y, Index ended) {
  if (!exact_ || (ended < 0 && stick_slip_.sticking() == 0)) {
    return true;
  }
  if (!torques(t, y, xd_.data())) {
    return false;
  }
  const auto n = static_cast<std::size_t>(n_);
  stick_slip_.settle(dynamics_, ended, {y + n_, n}, {torque_.data(), n});
  return true;
}

void LoopOde::reset_modes(const double* y) { stick_slip_.reset({y + n_, static_cast<std::size_t>(n_)}); }

SampledController::SampledController(const ControlLaw& law, const Reference& reference,
                                     const Sampling& sampling, Index n, bool in_control)
    : law_(law),
      reference_(reference),
      sampling_(sampling),
      in_control_(in_control),
      switches_at_(part_of_period(sampling.delay)),
      q_(n),
      qd_(Vector::Zero(n)),
      x_(Vector::Zero(law.states())),
      xd_(Vector::Zero(law.states())),
      q_r_(n),
      qd_r_(n),
      qdd_r_(n),
      v_(Vector::Zero(n)),
      measured_(n, static_cast<Index>(sampling.velocity_filter.size())),
      computed_(Matrix::Zero(n, std::lround(sampling.delay - switches_at_) + (switches_at_ > 0.0 ? 2 : 1))) {}

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
      // The past of a loop that begins in motion is the same motion.
      for (Index i = 0; i < taps; ++i) {
        measured_.col((taps - i) % taps) = q_ - static_cast<double>(i) * sampling_.period * qd;
      }
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
  if (ticks_ == 0 && in_control_) {
    computed_ = computed_.col(0).eval().replicate(1, slots);
  }
  // Until the first signal has come through its delay nothing acts.
  v_ = computed_.col((ticks_ + 1) % slots);
  ++ticks_;
  return v_;
}

}  // namespace rivid::detail
