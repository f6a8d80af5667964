#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/dynamics.hpp"
#include "rivid/text.hpp"

// What control_laws.hpp declares, for users of rivid::headers; rivid::rivid has it in its archive.
namespace rivid {

namespace detail {

using Complaint = std::optional<std::string>;

// What is wanted of a gain, one entry a joint. Gains in units of the control signal act against the error
// only with the sign of the drive gain.
struct GainRule {
  const char* required;
  bool (*accepts)(double value, double g_tau);
  bool in_signals = false;  // whether it needs a control signal of its own
};
inline constexpr GainRule positive = {
    "positive and finite", [](double value, double) { return std::isfinite(value) && value > 0.0; }};
inline constexpr GainRule not_negative = {
    "finite and not negative", [](double value, double) { return std::isfinite(value) && value >= 0.0; }};
inline constexpr GainRule time_or_never = {"positive and finite",
                                           [](double value, double) { return value > 0.0; }};
inline constexpr GainRule feedback = {"finite and of the sign of the drive gain g_tau, not zero",
                                      [](double value, double g_tau) {
                                        return std::isfinite(value) && value != 0.0 &&
                                               std::signbit(value) == std::signbit(g_tau);
                                      },
                                      true};
inline constexpr GainRule feedback_or_zero = {
    "finite and zero or of the sign of the drive gain g_tau",
    [](double value, double g_tau) { return value == 0.0 || feedback.accepts(value, g_tau); }};

// An option of a law, by its name.
struct GainCheck {
  const char* name;
  const Vector& values;
  const GainRule& rule;
  bool optional = false;
};

inline Complaint complaint_of(const Robot& robot, const GainCheck& check) {
  const Vector& values = check.values;
  if (check.optional && values.size() == 0) {
    return std::nullopt;
  }
  if (values.size() != robot.size()) {
    return std::string(check.name) + " has " + std::to_string(values.size()) + " entries for " +
           counted(robot.size(), "joint");
  }
  for (Index j = 0; j < values.size(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    if (!check.rule.accepts(values[j], joint.g_tau())) {
      return std::string(check.name) + " of joint \"" + joint.name + "\" is " + number(values[j]) +
             ", must be " + check.rule.required;
    }
  }
  return std::nullopt;
}

inline Complaint complaint_of(const Robot& robot, std::initializer_list<GainCheck> checks) {
  for (const GainCheck& check : checks) {
    if (auto fault = complaint_of(robot, check)) {
      return fault;
    }
  }
  return std::nullopt;
}

// "k_p and k_v (with T_i, J_apriori)".
inline std::string names_of_form(std::initializer_list<GainCheck> form) {
  std::string needed;
  std::string further;
  for (const GainCheck& check : form) {
    std::string& list = check.optional ? further : needed;
    list += (list.empty() ? "" : check.optional ? ", " : " and ") + std::string(check.name);
  }
  return needed + (further.empty() ? "" : " (with " + further + ")");
}

inline bool is_given(std::initializer_list<GainCheck> form) {
  return std::any_of(form.begin(), form.end(),
                     [](const GainCheck& check) { return check.values.size() > 0; });
}

inline bool is_diagonal(const Matrix& G) { return G.isDiagonal(0.0); }

// A law is given either by its poles or by its gains. Gains in units of the control signal need one signal a
// joint.
inline Complaint complaint_of_forms(const Robot& robot, std::initializer_list<GainCheck> poles,
                                    std::initializer_list<GainCheck> gains) {
  if (is_given(poles) == is_given(gains)) {
    return "give either " + names_of_form(poles) + ", or " + names_of_form(gains) +
           (is_given(poles) ? ", not both" : "");
  }
  if (is_given(poles)) {
    return complaint_of(robot, poles);
  }
  const bool in_signals =
      std::any_of(gains.begin(), gains.end(), [](const GainCheck& gain) { return gain.rule.in_signals; });
  if (in_signals && !is_diagonal(robot.drive_matrix())) {
    return "the robot's gear_matrix couples its joints, so that no control signal belongs to one joint "
           "alone; "
           "give the poles, omega_n and zeta, instead of gains";
  }
  return complaint_of(robot, gains);
}

// Gauss-Jordan with partial pivoting, of a small regular matrix.
inline Matrix inverse_of(Matrix A) {
  const Index n = A.rows();
  Matrix out = Matrix::Identity(n, n);
  for (Index k = 0; k < n; ++k) {
    Index pivot = k;
    for (Index i = k + 1; i < n; ++i) {
      pivot = std::abs(A(i, k)) > std::abs(A(pivot, k)) ? i : pivot;
    }
    A.row(k).swap(A.row(pivot));
    out.row(k).swap(out.row(pivot));
    const double scale = 1.0 / A(k, k);
    A.row(k) *= scale;
    out.row(k) *= scale;
    for (Index i = 0; i < n; ++i) {
      const double factor = A(i, k);
      if (i != k && factor != 0.0) {
        A.row(i) -= factor * A.row(k);
        out.row(i) -= factor * out.row(k);
      }
    }
  }
  return out;
}

inline const Vector& checked_inertias(const char* who, const Plant& plant) {
  if (const auto fault = complaint_of(plant.robot, {"the design inertia J", plant.J, positive})) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  return plant.J;
}

// Factor of the velocity gains, and how the joints' signals become those of the drives.
struct GainScale {
  Vector factor;  // (n)
  Matrix mixing;  // (n × n), empty where each drive moves its own joint
};

// How the gains of a law follow the plant, once they are known to be good. By poles, they are those of a unit
// inertia with a unit drive: times J / g_τ as in (45), or G⁻¹ J where gears couple the joints. Gains known of
// a controller: times J / J_apriori as in (46), or 1.
template <typename Law>
GainScale scale_of(const char* who, const Law& law, const Plant& plant) {
  if (const auto fault = law.complaint(plant.robot)) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  if (law.omega_n.size() == 0) {
    const bool adapted = law.J_apriori.size() > 0;
    return {.factor = adapted ? Vector(checked_inertias(who, plant).cwiseQuotient(law.J_apriori))
                              : Vector(Vector::Ones(plant.robot.size())),
            .mixing = {}};
  }
  const Vector& J = checked_inertias(who, plant);
  const Matrix G = plant.robot.drive_matrix();
  if (is_diagonal(G)) {
    return {.factor = J.cwiseQuotient(G.diagonal()), .mixing = {}};
  }
  return {.factor = J, .mixing = inverse_of(G)};
}

// `values`, or so many times `otherwise` where they are empty.
inline Vector or_constant(const Vector& values, Index n, double otherwise) {
  return values.size() == 0 ? Vector(Vector::Constant(n, otherwise)) : values;
}

inline constexpr double never = std::numeric_limits<double>::infinity();

// Feedback of one joint that is linear in the position error, the reference velocity and the velocity, (n)
// each: position (q_r − q) + reference_velocity q̇_r − velocity q̇.
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
  LinearFeedback direct;         // u
  LinearFeedback integral = {};  // w; empty vectors: no states
  Vector tracking_time = {};     // T_t, (n); used where there is an integral
  Matrix mixing;                 // (n × n), empty: the identity
  Vector v_tau_max;              // (n), empty: no saturation
};

class LinearLaw final : public ControlLaw {
 public:
  LinearLaw(LinearGains gains, ControlDescription description)
      : gains_(std::move(gains)),
        tracking_rate_(Vector::Zero(gains_.integral.position.size())),
        description_(std::move(description)) {
    gains_.v_tau_max = or_constant(gains_.v_tau_max, gains_.direct.position.size(), never);
    for (Index i = 0; i < tracking_rate_.size(); ++i) {
      // Without an integral there is nothing that could wind up, and nothing that could unwind the
      // correction.
      if (integrates(i)) {
        tracking_rate_[i] = 1.0 / gains_.tracking_time[i];
      }
    }
  }

  [[nodiscard]] Index states() const override { return gains_.integral.position.size(); }

  void control(const ControlInput& input, const Eigen::Ref<const Vector>& x, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> xd) const override {
    mixed(gains_.direct, input, v_tau);
    const bool with_states = states() > 0;
    if (with_states) {
      v_tau += x;
      mixed(gains_.integral, input, xd);
    }
    for (Index i = 0; i < v_tau.size(); ++i) {
      const double saturated = std::clamp(v_tau[i], -gains_.v_tau_max[i], gains_.v_tau_max[i]);
      if (with_states) {
        xd[i] += tracking_rate_[i] * (saturated - v_tau[i]);
      }
      v_tau[i] = saturated;
    }
  }

  [[nodiscard]] ControlDescription description() const override { return description_; }

 private:
  [[nodiscard]] bool integrates(Index i) const {
    const Vector& integral = gains_.integral.position;
    for (Index j = 0; j < integral.size(); ++j) {
      const double share = gains_.mixing.size() > 0 ? gains_.mixing(i, j) : i == j ? 1.0 : 0.0;
      if (share * integral[j] != 0.0) {
        return true;
      }
    }
    return false;
  }

  void mixed(const LinearFeedback& feedback, const ControlInput& input, Eigen::Ref<Vector>& out) const {
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

  LinearGains gains_;
  Vector tracking_rate_;  // 1 / T_t, zero where there is no integral
  ControlDescription description_;
};

// Gains of one joint of unit inertia with a unit drive.
struct CascadeLoop {
  double k_p = 0.0;
  double k_v = 0.0;
  double T_i = 0.0;
};

// Half of the distance between k_p and 1/T_i, squared; negative where no cascade has these poles.
inline double cascade_discriminant(double omega_n, double zeta, double omega_i) {
  const double damping = 2.0 * zeta * omega_n;
  const double sum = (omega_n * omega_n + damping * omega_i) / (damping + omega_i);
  return 0.25 * sum * sum - omega_n * omega_n * omega_i / (damping + omega_i);
}

inline CascadeLoop cascade_with_poles(double omega_n, double zeta, double omega_i) {
  const double k_v = 2.0 * zeta * omega_n + omega_i;
  const double half_sum = 0.5 * (omega_n * omega_n + 2.0 * zeta * omega_n * omega_i) / k_v;
  const double k_p = half_sum + std::sqrt(std::max(0.0, cascade_discriminant(omega_n, zeta, omega_i)));
  return {.k_p = k_p, .k_v = k_v, .T_i = k_p * k_v / (omega_n * omega_n * omega_i)};
}

class ComputedTorqueLaw final : public ControlLaw {
 public:
  ComputedTorqueLaw(const ComputedTorqueControl& control, const Plant& plant, const ModelData& model)
      : dynamics_(model),
        k_p_(control.k_p),
        k_d_(control.k_d),
        signal_(inverse_of(plant.robot.drive_matrix())),
        viscous_(Matrix::Zero(signal_.rows(), signal_.cols())),
        offset_(Vector::Zero(signal_.rows())),
        coulomb_velocity_(control.coulomb_velocity),
        v_tau_max_(or_constant(control.v_tau_max, signal_.rows(), never)) {
    if (control.omega_n.size() > 0) {
      k_p_ = control.omega_n.cwiseAbs2();
      k_d_ = 2.0 * control.zeta.cwiseProduct(control.omega_n);
    }
    if (control.friction) {
      viscous_ = signal_ * model.viscous;
      offset_ = signal_ * model.offset;
      dry_friction_ = model.dry_friction;
      for (DryFriction& element : dry_friction_) {
        element.torque = signal_ * element.torque;
      }
    }
  }

  void control(const ControlInput& input, const Eigen::Ref<const Vector>& /*x*/, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> /*xd*/) const override {
    const Index n = v_tau.size();
    const auto size = static_cast<std::size_t>(n);
    static_cast<void>(dynamics_.set_state({input.q.data(), size}, {input.qd.data(), size}));
    v_tau = offset_;
    for (Index i = 0; i < n; ++i) {
      v_tau += rigid_torque(input, i) * signal_.col(i) + input.qd[i] * viscous_.col(i);
    }
    for (const DryFriction& element : dry_friction_) {
      const double speed = element.direction.dot(input.qd);
      const double part = std::tanh(element.direction.dot(input.qd_r) / coulomb_velocity_);
      double tau = element.dry(part > 0.0, speed, part) + element.viscous(speed > 0.0, speed);
      if (element.load > 0.0) {
        tau += element.load * std::abs(rigid_torque(input, element.joint())) * part;
      }
      v_tau += tau * element.torque;
    }
    v_tau = v_tau.cwiseMin(v_tau_max_).cwiseMax(-v_tau_max_);
  }

  [[nodiscard]] ControlDescription description() const override {
    return {.law = "computed torque", .gains = {{"k_p", k_p_}, {"k_d", k_d_}}};
  }

 private:
  // M q̈ + N of joint i for the acceleration that is asked for.
  [[nodiscard]] double rigid_torque(const ControlInput& input, Index i) const {
    double tau = dynamics_.N()[static_cast<std::size_t>(i)];
    for (Index j = 0; j < input.q.size(); ++j) {
      tau += dynamics_.M(i, j) * acceleration(input, j);
    }
    return tau;
  }
  [[nodiscard]] double acceleration(const ControlInput& input, Index j) const {
    return input.qdd_r[j] + k_d_[j] * (input.qd_r[j] - input.qd[j]) + k_p_[j] * (input.q_r[j] - input.q[j]);
  }

  mutable Dynamics<double> dynamics_;  // scratch
  Vector k_p_;
  Vector k_d_;
  Matrix signal_;  // G⁻¹, which all that follows is multiplied with
  Matrix viscous_;
  Vector offset_;
  std::vector<DryFriction> dry_friction_;
  double coulomb_velocity_;
  Vector v_tau_max_;
};

}  // namespace detail

RIVID_INLINE std::optional<std::string> PdControl::complaint(const Robot& robot) const {
  using namespace detail;
  if (auto fault = detail::complaint_of_forms(
          robot, {{"omega_n", omega_n, positive}, {"zeta", zeta, positive}},
          {{"k_p", k_p, positive}, {"k_v", k_v, feedback}, {"J_apriori", J_apriori, positive, true}})) {
    return fault;
  }
  return detail::complaint_of(robot, {{"v_tau_max", v_tau_max, positive, true}});
}

RIVID_INLINE std::unique_ptr<ControlLaw> PdControl::operator()(const Plant& plant) const {
  const detail::GainScale scale = detail::scale_of("PdControl", *this, plant);
  const bool by_poles = omega_n.size() > 0;
  const Vector position = by_poles ? Vector(0.5 * omega_n.cwiseQuotient(zeta)) : k_p;
  const Vector velocity =
      scale.factor.cwiseProduct(by_poles ? Vector(2.0 * zeta.cwiseProduct(omega_n)) : k_v);
  detail::LinearGains gains{.direct = {.position = position.cwiseProduct(velocity),
                                       .reference_velocity = (reference_velocity ? 1.0 : 0.0) * velocity,
                                       .velocity = velocity},
                            .mixing = scale.mixing,
                            .v_tau_max = v_tau_max};
  return std::make_unique<detail::LinearLaw>(
      std::move(gains), ControlDescription{.law = "PD", .gains = {{"k_p", position}, {"k_v", velocity}}});
}

RIVID_INLINE std::optional<std::string> PidControl::complaint(const Robot& robot) const {
  using namespace detail;
  if (auto fault = detail::complaint_of_forms(robot,
                                              {{"omega_n", omega_n, positive},
                                               {"zeta", zeta, positive},
                                               {"omega_i", omega_i, not_negative, true}},
                                              {{"K_p", K_p, feedback},
                                               {"K_d", K_d, feedback_or_zero},
                                               {"K_i", K_i, feedback_or_zero, true},
                                               {"J_apriori", J_apriori, positive, true}})) {
    return fault;
  }
  return detail::complaint_of(
      robot, {{"v_tau_max", v_tau_max, positive, true}, {"tracking_time", tracking_time, positive, true}});
}

RIVID_INLINE std::unique_ptr<ControlLaw> PidControl::operator()(const Plant& plant) const {
  const detail::GainScale scale = detail::scale_of("PidControl", *this, plant);
  const Index n = plant.robot.size();
  // Gains of a unit inertia with a unit drive, or those given.
  Vector proportional = K_p;
  Vector integral = detail::or_constant(K_i, n, 0.0);
  Vector derivative = K_d;
  if (omega_n.size() > 0) {
    const Eigen::ArrayXd third = detail::or_constant(omega_i, n, 0.0);
    const Eigen::ArrayXd omega = omega_n;
    const Eigen::ArrayXd damping = 2.0 * zeta.array() * omega;
    proportional = omega.square() + damping * third;
    integral = omega.square() * third;
    derivative = damping + third;
  }
  for (Vector* const gain : {&proportional, &integral, &derivative}) {
    gain->array() *= scale.factor.array();
  }
  detail::LinearGains gains{
      .direct = {.position = proportional, .reference_velocity = derivative, .velocity = derivative},
      .tracking_time = tracking_time,
      .mixing = scale.mixing,
      .v_tau_max = v_tau_max};
  if (!integral.isZero(0.0)) {
    gains.integral = {
        .position = integral, .reference_velocity = Vector::Zero(n), .velocity = Vector::Zero(n)};
    if (tracking_time.size() == 0) {
      gains.tracking_time = Vector::NullaryExpr(n, [&](Index j) {
        return derivative[j] != 0.0 ? std::sqrt(derivative[j] / integral[j]) : proportional[j] / integral[j];
      });
    }
  }
  return std::make_unique<detail::LinearLaw>(
      std::move(gains),
      ControlDescription{.law = "PID",
                         .gains = {{"K_p", proportional}, {"K_i", integral}, {"K_d", derivative}}});
}

RIVID_INLINE std::optional<std::string> CascadeControl::complaint(const Robot& robot) const {
  using namespace detail;
  if (auto fault = detail::complaint_of_forms(robot,
                                              {{"omega_n", omega_n, positive},
                                               {"zeta", zeta, positive},
                                               {"omega_i", omega_i, not_negative, true}},
                                              {{"k_p", k_p, positive},
                                               {"k_v", k_v, feedback},
                                               {"T_i", T_i, time_or_never, true},
                                               {"J_apriori", J_apriori, positive, true}})) {
    return fault;
  }
  // At the limit ω_i = ω_n / (2 (1 + ζ)) itself the roots are equal, but for rounding.
  constexpr double rounding = 1e-12;
  for (Index j = 0; j < omega_i.size(); ++j) {
    if (detail::cascade_discriminant(omega_n[j], zeta[j], omega_i[j]) < -rounding * omega_n[j] * omega_n[j]) {
      return "omega_i of joint \"" + robot.joints[static_cast<std::size_t>(j)].name + "\" is " +
             number(omega_i[j]) + " rad/s, must be at most omega_n / (2 (1 + zeta)) = " +
             number(omega_n[j] / (2.0 * (1.0 + zeta[j])), 4) +
             " rad/s: a cascade has no faster integral pole; PidControl has";
    }
  }
  return detail::complaint_of(robot, {{"feed_forward", feed_forward, not_negative, true},
                                      {"v_tau_max", v_tau_max, positive, true},
                                      {"tracking_time", tracking_time, positive, true}});
}

RIVID_INLINE std::unique_ptr<ControlLaw> CascadeControl::operator()(const Plant& plant) const {
  const detail::GainScale scale = detail::scale_of("CascadeControl", *this, plant);
  const Index n = plant.robot.size();
  Vector position = k_p;
  Vector velocity = k_v;
  Vector integral_times = detail::or_constant(T_i, n, detail::never);
  if (omega_n.size() > 0) {
    position.resize(n);
    velocity.resize(n);
    for (Index j = 0; j < n; ++j) {
      const auto loop =
          detail::cascade_with_poles(omega_n[j], zeta[j], omega_i.size() == 0 ? 0.0 : omega_i[j]);
      position[j] = loop.k_p;
      velocity[j] = loop.k_v;
      integral_times[j] = loop.T_i;
    }
  }
  velocity.array() *= scale.factor.array();

  const Vector ahead = detail::or_constant(feed_forward, n, 1.0);
  const auto feedback_of = [&](const Vector& gain) {
    return detail::LinearFeedback{.position = position.cwiseProduct(gain),
                                  .reference_velocity = ahead.cwiseProduct(gain),
                                  .velocity = gain};
  };
  detail::LinearGains gains{.direct = feedback_of(velocity),
                            .tracking_time = tracking_time.size() == 0 ? integral_times : tracking_time,
                            .mixing = scale.mixing,
                            .v_tau_max = v_tau_max};
  if ((integral_times.array() < detail::never).any()) {
    gains.integral = feedback_of(velocity.cwiseQuotient(integral_times));
  }
  return std::make_unique<detail::LinearLaw>(
      std::move(gains),
      ControlDescription{
          .law = "cascade",
          .gains = {{"k_p", position}, {"k_v", velocity}, {"T_i", integral_times}, {"k_f", ahead}}});
}

RIVID_INLINE std::optional<std::string> ComputedTorqueControl::complaint(const Robot& robot) const {
  using namespace detail;
  if (auto fault =
          detail::complaint_of_forms(robot, {{"omega_n", omega_n, positive}, {"zeta", zeta, positive}},
                                     {{"k_p", k_p, positive}, {"k_d", k_d, positive}})) {
    return fault;
  }
  if (model && model->size() != robot.size()) {
    return "the model has " + counted(model->size(), "joint") + ", the robot has " +
           std::to_string(robot.size());
  }
  if (!(coulomb_velocity > 0.0) || !std::isfinite(coulomb_velocity)) {
    return "coulomb_velocity is " + number(coulomb_velocity) + ", must be positive and finite";
  }
  return detail::complaint_of(robot, {{"v_tau_max", v_tau_max, positive, true}});
}

RIVID_INLINE std::unique_ptr<ControlLaw> ComputedTorqueControl::operator()(const Plant& plant) const {
  if (const auto fault = complaint(plant.robot)) {
    throw InputError("ComputedTorqueControl: " + *fault);
  }
  return std::make_unique<detail::ComputedTorqueLaw>(*this, plant, model ? *model : plant.model);
}

}  // namespace rivid
