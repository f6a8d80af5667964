#include <cmath>
#include <utility>

#include "rivid/simulate/control_laws.hpp"
#include "simulate/gains.hpp"
#include "simulate/linear_law.hpp"

namespace rivid {

std::optional<std::string> PidControl::complaint(const Robot& robot) const {
  using namespace detail;
  const Index poles = omega_n.size() + zeta.size() + omega_i.size();
  const Index gains = K_p.size() + K_i.size() + K_d.size() + J_apriori.size();
  if (auto complaint =
          one_form(poles, gains, "omega_n and zeta (with omega_i)", "K_p and K_d (with K_i, J_apriori)")) {
    return complaint;
  }
  const Complaint values =
      poles > 0 ? first({positive(robot, "omega_n", omega_n), positive(robot, "zeta", zeta),
                         optional_not_negative(robot, "omega_i", omega_i)})
                : first({known_gains(robot, J_apriori), feedback(robot, "K_p", K_p, Zero::refused),
                         feedback(robot, "K_d", K_d, Zero::allowed),
                         K_i.size() == 0 ? std::nullopt : feedback(robot, "K_i", K_i, Zero::allowed)});
  return first({values, optional_positive(robot, "v_tau_max", v_tau_max),
                optional_positive(robot, "tracking_time", tracking_time)});
}

std::unique_ptr<ControlLaw> PidControl::operator()(const Plant& plant) const {
  constexpr auto who = "PidControl";
  detail::require(who, complaint(plant.robot));
  const Index n = plant.robot.size();
  const bool by_poles = omega_n.size() > 0;
  const detail::GainScale scale =
      by_poles ? detail::scale_of_poles(who, plant) : detail::scale_of_known_gains(who, plant, J_apriori);
  // Gains of a unit inertia with a unit drive, or those given.
  Vector proportional = K_p;
  Vector integral = detail::or_constant(K_i, n, 0.0);
  Vector derivative = K_d;
  if (by_poles) {
    const Eigen::ArrayXd third = detail::or_constant(omega_i, n, 0.0);
    const Eigen::ArrayXd omega = omega_n;
    const Eigen::ArrayXd damping = 2.0 * zeta.array() * omega;
    proportional = omega.square() + damping * third;
    integral = omega.square() * third;
    derivative = damping + third;
  }
  proportional.array() *= scale.factor.array();
  integral.array() *= scale.factor.array();
  derivative.array() *= scale.factor.array();

  detail::LinearGains gains{
      .direct = {.position = proportional, .reference_velocity = derivative, .velocity = derivative},
      .integral = {},
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

}  // namespace rivid
