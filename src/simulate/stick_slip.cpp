#include "rivid/simulate/stick_slip.hpp"

#include <algorithm>
#include <cmath>

#include "simulate/loop_step_kernel.hpp"

namespace rivid {

namespace {

// By how much a limit or a sign may be missed in settle(): the rounding of a small linear system.
constexpr double slack = 1e-12;
// of a joint that stuck before: a choice, so that it does not stick and slip by turns
constexpr double release_slack = 1e-6;

Index only_joint(const Vector& direction) {
  Index joint = -1;
  for (Index j = 0; j < direction.size(); ++j) {
    if (direction[j] != 0.0) {
      if (joint >= 0) {
        return -1;
      }
      joint = j;
    }
  }
  return joint;
}

Eigen::Map<const Vector> as_vector(std::span<const double> values) {
  return {values.data(), static_cast<Index>(values.size())};
}
Eigen::Map<Vector> as_vector(std::span<double> values) {
  return {values.data(), static_cast<Index>(values.size())};
}

}  // namespace

StickSlip::StickSlip(const DynamicModel& model) : n_(model.size()) {
  for (const DryFriction& law : model.dry_friction()) {
    if (law.sign_speed > 0.0) {
      continue;
    }
    const Index joint = only_joint(law.direction);
    elements_.push_back(
        {law, joint, joint >= 0 && only_joint(law.torque) == joint, law.Fc_plus, law.Fc_minus});
  }
  const Index count = size();
  stuck_.reserve(elements_.size());
  resting_.reserve(elements_.size());
  before_.resize(elements_.size());
  lambda_ = Vector::Zero(count);
  response_ = Matrix::Zero(n_, count);
  G_ = Matrix::Zero(count, count);
  system_ = Matrix::Zero(count, count);
  rhs_ = Vector::Zero(count);
  solution_ = Vector::Zero(count);
  qdd_ = Vector::Zero(n_);
  list_stuck();
}

double StickSlip::speed(Index e, std::span<const double> qd) const {
  const Element& element = elements_[static_cast<std::size_t>(e)];
  if (element.joint >= 0) {
    return element.law.direction[element.joint] * qd[static_cast<std::size_t>(element.joint)];
  }
  return element.law.direction.dot(as_vector(qd));
}

void StickSlip::list_stuck() {
  stuck_.clear();
  for (Index e = 0; e < size(); ++e) {
    if (mode(e) == FrictionMode::stick) {
      stuck_.push_back(e);
    }
  }
}

void StickSlip::reset(std::span<const double> qd) {
  for (Index e = 0; e < size(); ++e) {
    const double s = speed(e, qd);
    Element& element = elements_[static_cast<std::size_t>(e)];
    element.mode = s > 0 ? FrictionMode::slip_plus : s < 0 ? FrictionMode::slip_minus : FrictionMode::stick;
    element.changes = 0;
  }
  list_stuck();
}

double StickSlip::slipping_lambda(const Element& element, bool plus, double speed, double driving) {
  const DryFriction& law = element.law;
  const double sign = plus ? 1.0 : -1.0;
  const double lambda = law.dry(plus, speed, sign) + law.viscous(plus, speed);
  return law.load > 0.0 ? driving - DryFriction::carried(driving - lambda, sign * law.load) : lambda;
}

void StickSlip::load_limits(std::span<const double> f, std::span<const double> N) {
  for (Element& element : elements_) {
    if (element.law.load > 0.0) {
      const auto j = static_cast<std::size_t>(element.joint);
      const double driving = f[j] + N[j];
      element.Fc_plus = slipping_lambda(element, true, 0.0, driving);
      element.Fc_minus = -slipping_lambda(element, false, 0.0, driving);
    }
  }
}

// M⁻¹ b_e of the given elements, and c_eᵀ M⁻¹ b_l among them.
void StickSlip::responses(const Dynamics<double>& dynamics, std::span<const Index> elements) {
  for (const Index e : elements) {
    response_.col(e) = elements_[static_cast<std::size_t>(e)].law.torque;
    dynamics.solve({response_.col(e).data(), static_cast<std::size_t>(n_)});
  }
  for (const Index e : elements) {
    const Vector& c = elements_[static_cast<std::size_t>(e)].law.direction;
    for (const Index l : elements) {
      G_(e, l) = c.dot(response_.col(l));
    }
    G_(e, e) *= 1.0 + detail::stick_slip_regularisation;
  }
}

// λ that keeps the speeds of the given elements, from rhs_[e] = c_eᵀ q̈ without these λ: G λ = rhs by
// elimination with row pivoting, in place and without allocation.
void StickSlip::hold(std::span<const Index> elements) {
  const auto m = static_cast<Index>(elements.size());
  for (Index r = 0; r < m; ++r) {
    const Index e = elements[static_cast<std::size_t>(r)];
    for (Index c = 0; c < m; ++c) {
      system_(c, r) = G_(e, elements[static_cast<std::size_t>(c)]);
    }
    solution_[r] = rhs_[e];
  }
  detail::eliminate(elements.size(), static_cast<std::size_t>(size()), system_.data(), solution_.data());
  for (Index r = 0; r < m; ++r) {
    lambda_[elements[static_cast<std::size_t>(r)]] = solution_[r];
  }
}

// Takes the torques of all slipping elements but those of a list off f.
void StickSlip::brake(std::span<const double> qd, std::span<double> f, std::span<const double> N,
                      std::span<const Index> but) {
  for (Index e = 0; e < size(); ++e) {
    const Element& element = elements_[static_cast<std::size_t>(e)];
    if (element.mode == FrictionMode::stick || std::find(but.begin(), but.end(), e) != but.end()) {
      continue;
    }
    double driving = 0.0;
    if (element.law.load > 0.0) {
      const auto j = static_cast<std::size_t>(element.joint);
      driving = f[j] + (N.empty() ? 0.0 : N[j]);
    }
    lambda_[e] = slipping_lambda(element, element.mode == FrictionMode::slip_plus, speed(e, qd), driving);
    if (element.alone) {
      f[static_cast<std::size_t>(element.joint)] -= lambda_[e] * element.law.torque[element.joint];
    } else {
      as_vector(f) -= lambda_[e] * element.law.torque;
    }
  }
}

void StickSlip::accelerate(const Dynamics<double>& dynamics, std::span<const double> qd, std::span<double> f,
                           std::span<double> qdd) {
  load_limits(f, dynamics.N());
  brake(qd, f, dynamics.N(), {});
  auto out = as_vector(qdd);
  out = as_vector(f);
  dynamics.solve(qdd);
  if (stuck_.empty()) {
    return;
  }
  responses(dynamics, stuck_);
  for (const Index e : stuck_) {
    rhs_[e] = elements_[static_cast<std::size_t>(e)].law.direction.dot(out);
  }
  hold(stuck_);
  for (const Index e : stuck_) {
    out -= lambda_[e] * response_.col(e);
  }
  for (const Index e : stuck_) {
    const Index joint = elements_[static_cast<std::size_t>(e)].joint;
    if (joint >= 0) {
      out[joint] = 0.0;
    }
  }
}

double StickSlip::margin(Index e, std::span<const double> qd) const {
  const Element& element = elements_[static_cast<std::size_t>(e)];
  switch (element.mode) {
    case FrictionMode::slip_plus:
      return speed(e, qd);
    case FrictionMode::slip_minus:
      return -speed(e, qd);
    case FrictionMode::stick:
      break;
  }
  const double width = element.Fc_plus + element.Fc_minus;
  const double distance = std::min(element.Fc_plus - lambda_[e], lambda_[e] + element.Fc_minus);
  return width > 0.0 ? distance / width : distance;
}

Index StickSlip::settle(const Dynamics<double>& dynamics, Index ended, std::span<double> qd,
                        std::span<double> f) {
  resting_.clear();
  for (Index e = 0; e < size(); ++e) {
    Element& element = elements_[static_cast<std::size_t>(e)];
    before_[static_cast<std::size_t>(e)] = element.mode;
    if (e == ended && element.mode == FrictionMode::stick) {
      element.mode = lambda_[e] > 0 ? FrictionMode::slip_plus : FrictionMode::slip_minus;
      resting_.push_back(e);
    } else if (e == ended || element.mode == FrictionMode::stick) {
      element.mode = FrictionMode::stick;
      resting_.push_back(e);
    }
  }
  if (resting_.empty()) {
    return 0;
  }
  load_limits(f, dynamics.N());
  responses(dynamics, resting_);
  // The integrator leaves a rest of their speeds, which impulses of all of them together take away.
  for (const Index e : resting_) {
    rhs_[e] = speed(e, qd);
  }
  hold(resting_);
  for (const Index e : resting_) {
    as_vector(qd) -= lambda_[e] * response_.col(e);
  }
  for (const Index e : resting_) {
    const Index joint = elements_[static_cast<std::size_t>(e)].joint;
    if (joint >= 0) {
      qd[static_cast<std::size_t>(joint)] = 0.0;
    }
  }
  brake(qd, f, dynamics.N(), resting_);
  qdd_ = as_vector(f);
  dynamics.solve({qdd_.data(), static_cast<std::size_t>(n_)});

  const int most = 100 * (1 + static_cast<int>(resting_.size()));
  for (int pivots = 0; pivots < most && pivot(); ++pivots) {
  }

  Index changed = 0;
  for (const Index e : resting_) {
    Element& element = elements_[static_cast<std::size_t>(e)];
    if (element.mode != before_[static_cast<std::size_t>(e)]) {
      ++element.changes;
      ++changed;
    }
  }
  list_stuck();
  return changed;
}

// One step of the least-index principal pivoting: λ for the present guess of modes of the elements at rest,
// and the first element that it is wrong for gets another mode.
//
// @return  whether there was one
bool StickSlip::pivot() {
  stuck_.clear();
  for (const Index e : resting_) {
    const Element& element = elements_[static_cast<std::size_t>(e)];
    if (element.mode == FrictionMode::stick) {
      stuck_.push_back(e);
    } else {
      lambda_[e] = element.mode == FrictionMode::slip_plus ? element.Fc_plus : -element.Fc_minus;
    }
  }
  for (const Index e : stuck_) {
    rhs_[e] = elements_[static_cast<std::size_t>(e)].law.direction.dot(qdd_);
    for (const Index l : resting_) {
      if (elements_[static_cast<std::size_t>(l)].mode != FrictionMode::stick) {
        rhs_[e] -= G_(e, l) * lambda_[l];
      }
    }
  }
  hold(stuck_);
  for (const Index e : resting_) {
    Element& element = elements_[static_cast<std::size_t>(e)];
    const DryFriction& law = element.law;
    if (element.mode == FrictionMode::stick) {
      const double allowance = slack * (element.Fc_plus + element.Fc_minus);
      if (lambda_[e] > element.Fc_plus + allowance) {
        element.mode = FrictionMode::slip_plus;
        return true;
      }
      if (lambda_[e] < -element.Fc_minus - allowance) {
        element.mode = FrictionMode::slip_minus;
        return true;
      }
      continue;
    }
    const double driven = law.direction.dot(qdd_);
    double acceleration = driven;
    double scale = std::abs(driven);
    for (const Index l : resting_) {
      acceleration -= G_(e, l) * lambda_[l];
      scale += std::abs(G_(e, l) * lambda_[l]);
    }
    const double along = element.mode == FrictionMode::slip_plus ? acceleration : -acceleration;
    // A release is found where λ meets its limit, to the tolerance of the root: it is not taken back for
    // that.
    const double allowance =
        before_[static_cast<std::size_t>(e)] == FrictionMode::stick ? release_slack : slack;
    if (along < -allowance * scale) {
      element.mode = FrictionMode::stick;
      return true;
    }
  }
  return false;
}

}  // namespace rivid
