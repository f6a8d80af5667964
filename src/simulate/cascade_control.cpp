#include <cmath>
#include <limits>
#include <utility>

#include "rivid/simulate/control_laws.hpp"
#include "rivid/text.hpp"
#include "simulate/gains.hpp"
#include "simulate/linear_law.hpp"

namespace rivid {

namespace {

// Gains of one joint of unit inertia with a unit drive.
struct Loop {
  double k_p = 0.0;
  double k_v = 0.0;
  double T_i = 0.0;
};

// Half of the distance between k_p and 1/T_i, squared; negative where no cascade has these poles.
double discriminant(double omega_n, double zeta, double omega_i) {
  const double damping = 2.0 * zeta * omega_n;
  const double sum = (omega_n * omega_n + damping * omega_i) / (damping + omega_i);
  return 0.25 * sum * sum - omega_n * omega_n * omega_i / (damping + omega_i);
}

// At the limit ω_i = ω_n / (2 (1 + ζ)) itself the roots are equal, but for rounding.
constexpr double rounding = 1e-12;

Loop loop_with_poles(double omega_n, double zeta, double omega_i) {
  const double k_v = 2.0 * zeta * omega_n + omega_i;
  const double half_sum = 0.5 * (omega_n * omega_n + 2.0 * zeta * omega_n * omega_i) / k_v;
  const double k_p = half_sum + std::sqrt(std::max(0.0, discriminant(omega_n, zeta, omega_i)));
  return {.k_p = k_p, .k_v = k_v, .T_i = k_p * k_v / (omega_n * omega_n * omega_i)};
}

detail::Complaint poles_complaint(const Robot& robot, const Vector& omega_n, const Vector& zeta,
                                  const Vector& omega_i) {
  for (Index j = 0; j < omega_i.size(); ++j) {
    if (discriminant(omega_n[j], zeta[j], omega_i[j]) < -rounding * omega_n[j] * omega_n[j]) {
      return "omega_i of joint \"" + robot.joints[static_cast<std::size_t>(j)].name + "\" is " +
             number(omega_i[j]) + " rad/s, must be at most omega_n / (2 (1 + zeta)) = " +
             number(omega_n[j] / (2.0 * (1.0 + zeta[j])), 4) +
             " rad/s: a cascade has no faster integral pole; PidControl has";
    }
  }
  return std::nullopt;
}

// An infinite integral time is no integral action.
detail::Complaint integral_time(const Robot& robot, const Vector& T_i) {
  Vector finite = T_i;
  for (double& value : finite) {
    value = value == std::numeric_limits<double>::infinity() ? 1.0 : value;
  }
  return detail::optional_positive(robot, "T_i", finite);
}

}  // namespace

std::optional<std::string> CascadeControl::complaint(const Robot& robot) const {
  using namespace detail;
  const Index poles = omega_n.size() + zeta.size() + omega_i.size();
  const Index gains = k_p.size() + k_v.size() + T_i.size() + J_apriori.size();
  if (auto complaint =
          one_form(poles, gains, "omega_n and zeta (with omega_i)", "k_p and k_v (with T_i, J_apriori)")) {
    return complaint;
  }
  Complaint values = poles > 0
                         ? first({positive(robot, "omega_n", omega_n), positive(robot, "zeta", zeta),
                                  optional_not_negative(robot, "omega_i", omega_i)})
                         : first({known_gains(robot, J_apriori), positive(robot, "k_p", k_p),
                                  feedback(robot, "k_v", k_v, Zero::refused), integral_time(robot, T_i)});
  if (!values) {
    values = poles_complaint(robot, omega_n, zeta, omega_i);
  }
  return first({values, optional_not_negative(robot, "feed_forward", feed_forward),
                optional_positive(robot, "v_tau_max", v_tau_max),
                optional_positive(robot, "tracking_time", tracking_time)});
}

std::unique_ptr<ControlLaw> CascadeControl::operator()(const Plant& plant) const {
  constexpr auto who = "CascadeControl";
  constexpr double never = std::numeric_limits<double>::infinity();
  detail::require(who, complaint(plant.robot));
  const Index n = plant.robot.size();
  const bool by_poles = omega_n.size() > 0;
  const detail::GainScale scale =
      by_poles ? detail::scale_of_poles(who, plant) : detail::scale_of_known_gains(who, plant, J_apriori);
  Vector position = k_p;
  Vector velocity = k_v;
  Vector integral_times = detail::or_constant(T_i, n, never);
  if (by_poles) {
    position.resize(n);
    velocity.resize(n);
    for (Index j = 0; j < n; ++j) {
      const Loop loop = loop_with_poles(omega_n[j], zeta[j], omega_i.size() == 0 ? 0.0 : omega_i[j]);
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
                            .integral = {},
                            .tracking_time = tracking_time.size() == 0 ? integral_times : tracking_time,
                            .mixing = scale.mixing,
                            .v_tau_max = v_tau_max};
  if ((integral_times.array() < never).any()) {
    gains.integral = feedback_of(velocity.cwiseQuotient(integral_times));
  }
  return std::make_unique<detail::LinearLaw>(
      std::move(gains),
      ControlDescription{
          .law = "cascade",
          .gains = {{"k_p", position}, {"k_v", velocity}, {"T_i", integral_times}, {"k_f", ahead}}});
}

}  // namespace rivid
