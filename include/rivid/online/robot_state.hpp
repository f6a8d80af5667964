#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/online/contact_observer.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/saved_state.hpp"
#include "rivid/online/tick_gate.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"

namespace rivid {

struct RobotStateOptions {
  /// f_m of its rows is that of all parts.
  PayloadEstimatorOptions payload = {.friction_change = 0.2, .longest_touch = 1.0};
  ContactObserverOptions contact = {};
  TickGateOptions gate = {};
  double learn =
      120.0;  ///< time from the begin in which thresholds are learned, and nothing may touch the robot [s]
  /// Most that feedforward() changes by what is learned, (n) [N·m/s | N/s]. Empty: 50 sigma_rho a second.
  Vector feedforward_rate = {};

  [[nodiscard]] std::optional<std::string> complaint(Index joints) const {
    if (!(learn >= 0.0)) {
      return "learn is " + number(learn) + " s, must not be negative";
    }
    if (feedforward_rate.size() != 0 &&
        (feedforward_rate.size() != joints || !(feedforward_rate.array() > 0.0).all())) {
      return "feedforward_rate must have " + std::to_string(joints) + " positive values, one a joint";
    }
    return std::nullopt;
  }
};

namespace detail {

// Torques of a body on the last link.
template <typename Scalar>
class BodyTorque {
 public:
  using Vec = Eigen::VectorX<Scalar>;
  using Values = Eigen::Ref<const Vec>;
  using Body = Eigen::Matrix<Scalar, inertial_count, 1>;

  explicit BodyTorque(const Robot& robot) : regressor_(robot, parameters(robot)) {}

  // tau += L(q, q̇, q̈) body
  void add(const Values& q, const Values& qd, const Values& qdd, const Body& body, Vec& tau) noexcept {
    regressor_.rows(q.data(), qd.data(), qdd.data(),
                    [&](std::size_t joint, Index column, const Scalar& value) {
                      tau[static_cast<Index>(joint)] +=
                          value * body[regressor_.columns.of_joint(joint)[static_cast<std::size_t>(column)]];
                    });
  }

 private:
  [[nodiscard]] static std::vector<StandardParameter> parameters(const Robot& robot) {
    std::vector<StandardParameter> out;
    for (int k = 0; k < inertial_count; ++k) {
      out.push_back({static_cast<ParameterKind>(k), static_cast<int>(robot.size()) - 1});
    }
    return out;
  }

  Regressor<Scalar> regressor_;
};

}  // namespace detail

/// The state of a robot in its control loop, for a whole shift: payload, friction and contacts, each of which
/// uses what the others have learned.
///
/// TickGate makes even ticks of those that come. PayloadEstimator learns payload and friction. The observer
/// of contacts is told the payload, and its thresholds follow what friction drifts by. While something
/// touches the robot nothing is learned of it. What a controller knows — the gripper has closed, this part
/// has 2 kg — it says by payload_changed(), payload_known() and gripper().
///
/// Everything is one tick old. After the constructor no member allocates, throws or locks.
///
/// @tparam Scalar  double or float
template <typename Scalar>
class RobotState {
 public:
  using Values = Eigen::Ref<const Eigen::VectorX<Scalar>>;
  using Result = Eigen::VectorX<Scalar>;
  using Body = Eigen::Matrix<Scalar, inertial_count, 1>;

  /// @param dynamics  the same robot, with the numbers that feedforward() and the observer of contacts take
  /// @throws InputError  where model, dynamics or options can not be used
  RobotState(const OnlineModel& model, const ModelData& dynamics, const RobotStateOptions& options = {});

  [[nodiscard]] Index size() const noexcept { return payload_.joints(); }

  /// Takes a tick.
  ///
  /// @param t    when it was measured [s]
  /// @param q    positions, (n) [rad | m]
  /// @param tau  torques, joint side, or currents times drive gains, (n) [N·m | N]
  /// @return     what was wrong with it
  TickQuality update(double t, const Values& q, const Values& tau) noexcept {
    return gate_.update(t, q, tau,
                        [this](const Result& at, const Result& qd, const Result& torque, bool anew) {
                          take(at, qd, torque, anew);
                        });
  }

  [[nodiscard]] const OnlinePayload<Scalar>& payload() const noexcept { return payload_.payload(); }
  [[nodiscard]] const PayloadEstimator<Scalar>& estimator() const noexcept { return payload_; }
  [[nodiscard]] const ContactObserver<Scalar>& observer() const noexcept { return contact_; }
  [[nodiscard]] const typename TickGate<Scalar>::Counts& counts() const noexcept { return gate_.counts(); }
  /// Changes of the payload that were found or said.
  [[nodiscard]] Index payload_changes() const noexcept { return status_.changes; }
  /// Torque that friction has gained since the identification, at a tick of late, (n) [N·m | N].
  [[nodiscard]] const Result& friction_gained() const noexcept { return gained_; }
  /// Whether something touches the robot. Both are silent until a payload that has changed is known, some 0.6
  /// s of motion: its weight would be a contact.
  [[nodiscard]] bool contact() const noexcept { return status_.touched; }
  [[nodiscard]] bool collision() const noexcept { return status_.collision; }
  /// Time for which thresholds are still learned [s]; contacts are not seen before.
  [[nodiscard]] double left_to_learn() const noexcept {
    return std::max(options_.learn - static_cast<double>(status_.ticks) / f_m_, 0.0);
  }

  /// See PayloadEstimator.
  void payload_changed() noexcept {
    payload_.payload_changed();
    forget_weight();
  }
  bool payload_known(const Scalar& mass, const Eigen::Vector3<Scalar>& com, const Scalar& mass_sigma,
                     const Scalar& com_sigma) noexcept {
    const bool out = payload_.payload_known(mass, com, mass_sigma, com_sigma);
    follow_payload();
    return out;
  }
  void gripper(bool open) noexcept {
    payload_.gripper(open);
    forget_weight();
    follow_payload();
  }

  /// All work that waits, and the solution: what the next ticks would do.
  void finish() noexcept { payload_.finish(); }

  /// Torques for a motion: those of the model, with the friction and the payload of the state, (n) [N·m | N].
  /// What is learned comes in at feedforward_rate, so there is no jump when a payload becomes known. To be
  /// called once a tick.
  ///
  /// @param q, qd, qdd  of the reference, (n)
  const Result& feedforward(const Values& q, const Values& qd, const Values& qdd) noexcept;

  [[nodiscard]] auto state() noexcept {
    return std::tie(gate_, payload_, contact_, gained_, drift_, applied_drift_, applied_body_, told_,
                    status_);
  }
  [[nodiscard]] const detail::StateOwner& state_owner() const noexcept { return owner_; }

 private:
  struct Status {
    Index ticks = 0;
    Index changes = 0;
    Index since_follow = 0;
    bool touched = false;
    bool collision = false;
    bool weight_known = true;  // the observer has the payload
  };
  // Ticks from one look at friction to the next.
  static constexpr Index look = 16;
  [[nodiscard]] static const RobotStateOptions& usable(const RobotStateOptions& options, Index joints) {
    if (const auto fault = options.complaint(joints)) {
      throw InputError("RobotState: " + *fault);
    }
    return options;
  }
  void take(const Result& q, const Result& qd, const Result& tau, bool anew) noexcept;
  void follow_friction() noexcept;
  void follow_payload() noexcept;
  void forget_weight() noexcept {
    ++status_.changes;
    status_.weight_known = status_.touched = status_.collision = false;
    told_.setZero();
  }
  // to += Σ φ(q̇) drift of each coefficient of friction.
  void add_friction(const Values& qd, const Values& tau, const std::vector<Scalar>& drift,
                    Result& to) const noexcept;

  RobotStateOptions options_;
  double f_m_;
  TickGate<Scalar> gate_;
  PayloadEstimator<Scalar> payload_;
  ContactObserver<Scalar> contact_;
  BasicInverseDynamics<Scalar> dynamics_;
  detail::BodyTorque<Scalar> body_;
  Vector smoothing_;
  Vector rate_;
  std::vector<Scalar> drift_, applied_drift_, step_;  // of friction since the identification
  Body applied_body_ = Body::Zero();
  Body told_ = Body::Zero();
  Result gained_, feedforward_, change_;
  Status status_;
  detail::StateOwner owner_;
};

template <typename Scalar>
RobotState<Scalar>::RobotState(const OnlineModel& model, const ModelData& dynamics,
                               const RobotStateOptions& options)
    : options_(usable(options, model.robot.size())),
      f_m_(options.payload.rows.f_m),
      gate_(model.robot.size(),
            {f_m_, options.gate.largest_acceleration, options.gate.filled, options.gate.smoothing}),
      payload_(model, options.payload),
      contact_(dynamics,
               [&] {
                 ContactObserverOptions contact = options.contact;
                 contact.f_m = options.payload.rows.f_m;
                 return contact;
               }()),
      dynamics_(dynamics),
      body_(model.robot),
      smoothing_(options.contact.smoothing_speed.size() > 0
                     ? options.contact.smoothing_speed
                     : Vector(Vector::Constant(model.robot.size(), 0.02))),
      rate_(options.feedforward_rate.size() > 0 ? options.feedforward_rate : Vector(50.0 * model.sigma_rho)),
      drift_(payload_.friction().size(), Scalar(0)),
      applied_drift_(drift_),
      step_(drift_),
      gained_(Result::Zero(model.robot.size())),
      feedforward_(gained_),
      change_(gained_) {
  for (std::size_t j = 0; j < model.robot.joints.size(); ++j) {
    const double own = model.robot.joints[j].sign_speed;
    smoothing_[static_cast<Index>(j)] = own > 0.0 ? own : smoothing_[static_cast<Index>(j)];
  }
  const detail::StateOwner& of_payload = payload_.state_owner();
  const detail::StateOwner& of_contact = contact_.state_owner();
  owner_ = {.kind = detail::kind_of<Scalar>("RobotState"),
            .arm = detail::Fingerprint::of(of_payload.arm, of_contact.arm),
            .rate = of_payload.rate,
            .flange = of_payload.flange,
            .options = detail::Fingerprint::of(of_payload.options, of_contact.options, options.learn,
                                               options.gate.largest_acceleration, options.gate.filled,
                                               options.gate.smoothing, rate_)};
}

template <typename Scalar>
void RobotState<Scalar>::take(const Result& q, const Result& qd, const Result& tau, bool anew) noexcept {
  if (anew) {
    payload_.pause();
    contact_.reset();
  }
  ++status_.ticks;
  using Mode = typename ContactObserver<Scalar>::Mode;
  // A weight that is not known, or a touch, is no drift of friction.
  const bool settled = status_.weight_known && !payload_.touched();
  contact_.update(q, qd, tau, left_to_learn() > 0.0 ? Mode::learn : settled ? Mode::follow : Mode::observe);
  const bool felt = contact_.contact() || contact_.collision();
  payload_.touched(status_.weight_known && felt);
  if (payload_.update(q, tau)) {
    forget_weight();
  }
  status_.touched = status_.weight_known && (felt || payload_.touch_found());
  status_.collision = status_.weight_known && contact_.collision();
  if (++status_.since_follow >= look) {
    status_.since_follow = 0;
    follow_friction();
    gained_.setZero();
    add_friction(qd, tau, drift_, gained_);
    follow_payload();
  }
}

template <typename Scalar>
void RobotState<Scalar>::follow_friction() noexcept {
  const auto& friction = payload_.friction();
  for (std::size_t i = 0; i < friction.size() && !status_.touched; ++i) {
    drift_[i] = friction[i].value - friction[i].identified;
  }
}

template <typename Scalar>
void RobotState<Scalar>::follow_payload() noexcept {
  if (!payload_.payload().good) {
    return;
  }
  told_ = payload_.inertial();
  contact_.set_payload(told_);
  if (!status_.weight_known) {  // r has the weight until now
    contact_.reset();
  }
  status_.weight_known = true;
}

template <typename Scalar>
void RobotState<Scalar>::add_friction(const Values& qd, const Values& tau, const std::vector<Scalar>& drift,
                                      Result& to) const noexcept {
  const auto& friction = payload_.friction();
  for (std::size_t i = 0; i < drift.size(); ++i) {
    const auto [kind, joint] = friction[i].parameter;
    const KindRow& row = about(kind);
    if (row.coupled) {
      continue;
    }
    const Scalar by = friction_entry(row.basis, row.direction, qd[joint], smoothing_[joint]);
    to[joint] += drift[i] * by * (row.basis == Basis::load ? std::abs(tau[joint]) : Scalar(1));
  }
}

template <typename Scalar>
auto RobotState<Scalar>::feedforward(const Values& q, const Values& qd, const Values& qdd) noexcept
    -> const Result& {
  dynamics_.torque(q, qd, qdd, feedforward_);
  if (q.size() != size() || qd.size() != size() || qdd.size() != size()) {
    return feedforward_;
  }
  // All that is learned moves the same part of its way, so that no torque changes faster than it may.
  const Body way = told_ - applied_body_;
  for (std::size_t i = 0; i < step_.size(); ++i) {
    step_[i] = drift_[i] - applied_drift_[i];
  }
  change_.setZero();
  body_.add(q, qd, qdd, way, change_);
  add_friction(qd, feedforward_, step_, change_);
  Scalar part(1);
  for (Index j = 0; j < size(); ++j) {
    const auto most = static_cast<Scalar>(rate_[j] / f_m_);
    part = std::abs(change_[j]) > most ? std::min(part, Scalar(most / std::abs(change_[j]))) : part;
  }
  applied_body_ += part * way;
  for (std::size_t i = 0; i < step_.size(); ++i) {
    applied_drift_[i] += part * step_[i];
  }
  change_.setZero();
  body_.add(q, qd, qdd, applied_body_, change_);
  add_friction(qd, feedforward_, applied_drift_, change_);
  feedforward_ += change_;
  return feedforward_;
}

#ifdef RIVID_LIBRARY
extern template class RobotState<double>;
#endif

}  // namespace rivid
