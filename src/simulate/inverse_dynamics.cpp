#include "rivid/simulate/inverse_dynamics.hpp"

#include <cmath>
#include <limits>

#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::DynamicsLink;
using Motion3 = detail::FrameMotion<double>;
using Vec3d = detail::Vec3<double>;
using Wrench3 = detail::Wrench<double>;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// v_s of each element of dry friction.
Vector smoothing_of(const DynamicModel& model, const Vector& speeds) {
  if (speeds.size() == 0) {
    return {};
  }
  if (speeds.size() != model.size()) {
    throw InputError("InverseDynamics: smoothing_speed has " + std::to_string(speeds.size()) +
                     " values, the robot has " + std::to_string(model.size()) + " joints");
  }
  for (Index j = 0; j < speeds.size(); ++j) {
    if (!std::isfinite(speeds[j]) || speeds[j] <= 0.0) {
      throw InputError("InverseDynamics: smoothing_speed of joint \"" +
                       model.joints()[static_cast<std::size_t>(j)].name + "\" is " + number(speeds[j]) +
                       ", must be positive and finite; leave smoothing_speed empty for none");
    }
  }
  Vector out(static_cast<Index>(model.dry_friction().size()));
  for (Index e = 0; e < out.size(); ++e) {
    out[e] = model.dry_friction()[static_cast<std::size_t>(e)].direction.cwiseAbs().dot(speeds);
  }
  return out;
}

// Torque of one element along its direction.
double dry(const DryFriction& element, double speed, double smoothing) {
  if (element.sign_speed > 0.0) {  // it was identified smooth
    return element.lambda(speed);
  }
  const double forward = smoothing > 0.0 ? 0.5 + 0.5 * std::tanh(speed / smoothing) : speed > 0.0 ? 1.0 : 0.0;
  const double backward = smoothing > 0.0 ? 1.0 - forward : speed < 0.0 ? 1.0 : 0.0;
  return element.dry(true, speed, 1.0) * forward + element.dry(false, speed, -1.0) * backward +
         element.viscous(speed > 0.0, speed);
}

// A vector of frame j−1 in the axes of frame j.
Vec3d into_link(const DynamicsLink& link, const detail::CosSin<double>& turn, const Vec3d& v) {
  return detail::rotated(detail::turned<detail::Turn::any>(link.R, v), turn.c, turn.s);
}

// Motion of the link before, told where and as frame j stands at its joint's position.
Motion3 passed(const DynamicsLink& link, const Motion3& m, const detail::Mat3<double>& U,
               const detail::CosSin<double>& turn, const Vec3d& p) {
  return {into_link(link, turn, m.omega), into_link(link, turn, m.omega_dot),
          into_link(link, turn, m.accel + U.times(p))};
}

Vec3d origin(const DynamicsLink& link, double q) {
  const Vec3d p = {link.p[0], link.p[1], link.p[2]};
  return link.revolute ? p : p + Vec3d{link.R[2] * q, link.R[5] * q, link.R[8] * q};
}

// What the link's motion takes. Of a revolute joint's link the tables have taken YY, of a prismatic one's the tensor.
Wrench3 wrench(const DynamicsLink& link, const Motion3& m, const detail::Mat3<double>& U) {
  const double* const I = link.inertial;
  const Vec3d h = {I[6], I[7], I[8]};
  Wrench3 out = {U.times(h), detail::cross(h, m.accel)};
  if (link.revolute) {
    const auto moments = detail::TensorMoments<double>::of(m, U);
    for (const int k : {0, 1, 2, 4, 5}) {
      const Vec3d& unit = moments.k[k];
      out.n = out.n + Vec3d{I[k] * unit.x, I[k] * unit.y, I[k] * unit.z};
    }
  }
  out.f = out.f + Vec3d{I[9] * m.accel.x, I[9] * m.accel.y, I[9] * m.accel.z};
  return out;
}

}  // namespace

InverseDynamics::InverseDynamics(const DynamicModel& model, const InverseDynamicsOptions& options)
    : model_(model),
      smoothing_(smoothing_of(model, options.smoothing_speed)),
      tables_(model),
      dynamics_(model),
      wrenches_(static_cast<std::size_t>(model.size())),
      turns_(static_cast<std::size_t>(model.size())),
      at_rest_(Vector::Zero(model.size())),
      scratch_(Vector::Zero(model.size())) {}

InverseDynamics::InverseDynamics(const Robot& robot, const BaseParameters& base,
                                 const Eigen::Ref<const Vector>& chi, const InverseDynamicsOptions& options)
    : InverseDynamics(DynamicModel(robot, base, chi), options) {}

void InverseDynamics::turn(const double* q) noexcept {
  for (std::size_t j = 0; j < turns_.size(); ++j) {
    const DynamicsLink& link = tables_.links[j];
    const double angle = link.revolute ? q[j] : 0.0;
    const double s = std::sin(angle);
    const double c = std::cos(angle);
    turns_[j] = {c * link.cos_theta - s * link.sin_theta, s * link.cos_theta + c * link.sin_theta};
  }
}

// Acceleration of the first link's origin. The tables hold that of the base in the link's axes at θ = 0.
Vec3d InverseDynamics::first_acceleration() const noexcept {
  return detail::rotated(Vec3d{tables_.accel[0], tables_.accel[1], tables_.accel[2]}, turns_[0].c,
                         turns_[0].s);
}

void InverseDynamics::newton_euler(const double* q, const double* qd, const double* qdd,
                                   double* tau) noexcept {
  turn(q);
  Motion3 m = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, first_acceleration()};
  detail::Mat3<double> U = {m.omega, m.omega, m.omega};
  for (std::size_t j = 0; j < turns_.size(); ++j) {
    const DynamicsLink& link = tables_.links[j];
    if (j > 0) {
      m = passed(link, m, U, turns_[j], origin(link, q[j]));
    }
    const double acceleration = qdd != nullptr ? qdd[j] : 0.0;
    if (link.revolute) {
      m.omega_dot = m.omega_dot + Vec3d{m.omega.y * qd[j], -m.omega.x * qd[j], acceleration};
      m.omega.z += qd[j];
    } else {
      m.accel = m.accel + Vec3d{2.0 * m.omega.y * qd[j], -2.0 * m.omega.x * qd[j], acceleration};
    }
    U = detail::acceleration_field(m);
    wrenches_[j] = wrench(link, m, U);
  }
  sum_up(q, tau);
}

void InverseDynamics::sum_up(const double* q, double* tau) noexcept {
  for (std::size_t j = turns_.size(); j-- > 0;) {
    const DynamicsLink& link = tables_.links[j];
    const Wrench3& w = wrenches_[j];
    tau[j] = link.revolute ? w.n.z : w.f.z;
    if (j > 0) {
      const auto back = [&](const Vec3d& v) {
        return detail::turned_back<detail::Turn::any>(link.R,
                                                      detail::rotated_back(v, turns_[j].c, turns_[j].s));
      };
      const Vec3d f = back(w.f);
      wrenches_[j - 1].f = wrenches_[j - 1].f + f;
      wrenches_[j - 1].n = wrenches_[j - 1].n + back(w.n) + detail::cross(origin(link, q[j]), f);
    }
  }
}

void InverseDynamics::torque(const Values& q, const Values& qd, const Values& qdd, Result tau) noexcept {
  if (q.size() != size() || qd.size() != size() || qdd.size() != size() || tau.size() != size()) {
    tau.setConstant(not_a_number);
    return;
  }
  friction(qd, scratch_);
  newton_euler(q.data(), qd.data(), qdd.data(), tau.data());
  tau += scratch_;
  tau.noalias() += model_.rotor().lazyProduct(qdd);
}

void InverseDynamics::gravity(const Values& q, Result tau) noexcept {
  if (q.size() != size() || tau.size() != size()) {
    tau.setConstant(not_a_number);
    return;
  }
  turn(q.data());
  Vec3d accel = first_acceleration();
  for (std::size_t j = 0; j < turns_.size(); ++j) {
    const DynamicsLink& link = tables_.links[j];
    accel = j > 0 ? into_link(link, turns_[j], accel) : accel;
    const double* const I = link.inertial;
    wrenches_[j] = {{I[9] * accel.x, I[9] * accel.y, I[9] * accel.z},
                    detail::cross(Vec3d{I[6], I[7], I[8]}, accel)};
  }
  sum_up(q.data(), tau.data());
}

void InverseDynamics::bias(const Values& q, const Values& qd, Result tau) noexcept {
  if (q.size() != size() || qd.size() != size() || tau.size() != size()) {
    tau.setConstant(not_a_number);
    return;
  }
  newton_euler(q.data(), qd.data(), nullptr, tau.data());
}

void InverseDynamics::coriolis(const Values& q, const Values& qd, Result tau) noexcept {
  gravity(q, scratch_);
  bias(q, qd, tau);
  if (tau.size() == size()) {
    tau -= scratch_;
  }
}

void InverseDynamics::friction(const Values& qd, Result tau) const noexcept {
  if (qd.size() != size() || tau.size() != size()) {
    tau.setConstant(not_a_number);
    return;
  }
  tau = model_.offset();
  tau.noalias() += model_.viscous().lazyProduct(qd);
  for (std::size_t e = 0; e < model_.dry_friction().size(); ++e) {
    const DryFriction& element = model_.dry_friction()[e];
    const double smoothing = smoothing_.size() > 0 ? smoothing_[static_cast<Index>(e)] : 0.0;
    tau += element.torque * dry(element, element.direction.dot(qd), smoothing);
  }
}

void InverseDynamics::M(const Values& q, Eigen::Ref<Matrix> M) noexcept {
  if (q.size() != size() || M.rows() != size() || M.cols() != size()) {
    M.setConstant(not_a_number);
    return;
  }
  const auto n = static_cast<std::size_t>(size());
  // Whether M is positive definite is for the caller to judge: it is right in either case.
  static_cast<void>(dynamics_.set_state({q.data(), n}, {at_rest_.data(), n}));
  for (Index j = 0; j < size(); ++j) {
    for (Index i = 0; i < size(); ++i) {
      M(i, j) = dynamics_.M(i, j);
    }
  }
}

}  // namespace rivid
