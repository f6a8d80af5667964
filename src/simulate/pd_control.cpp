#include <utility>

#include "rivid/simulate/control_laws.hpp"
#include "simulate/gains.hpp"
#include "simulate/linear_law.hpp"

namespace rivid {

std::optional<std::string> PdControl::complaint(const Robot& robot) const {
  using namespace detail;
  const Index poles = omega_n.size() + zeta.size();
  const Index gains = k_p.size() + k_v.size() + J_apriori.size();
  if (auto complaint = one_form(poles, gains, "omega_n and zeta", "k_p and k_v (with J_apriori)")) {
    return complaint;
  }
  const Complaint values = poles > 0
                               ? first({positive(robot, "omega_n", omega_n), positive(robot, "zeta", zeta)})
                               : first({known_gains(robot, J_apriori), positive(robot, "k_p", k_p),
                                        feedback(robot, "k_v", k_v, Zero::refused)});
  return first({values, optional_positive(robot, "v_tau_max", v_tau_max)});
}

std::unique_ptr<ControlLaw> PdControl::operator()(const Plant& plant) const {
  constexpr auto who = "PdControl";
  detail::require(who, complaint(plant.robot));
  const bool by_poles = omega_n.size() > 0;
  const detail::GainScale scale =
      by_poles ? detail::scale_of_poles(who, plant) : detail::scale_of_known_gains(who, plant, J_apriori);
  const Vector position = by_poles ? Vector(0.5 * omega_n.cwiseQuotient(zeta)) : k_p;
  const Vector velocity =
      scale.factor.cwiseProduct(by_poles ? Vector(2.0 * zeta.cwiseProduct(omega_n)) : k_v);
  detail::LinearGains gains{.direct = {.position = position.cwiseProduct(velocity),
                                       .reference_velocity = (reference_velocity ? 1.0 : 0.0) * velocity,
                                       .velocity = velocity},
                            .integral = {},
                            .tracking_time = {},
                            .mixing = scale.mixing,
                            .v_tau_max = v_tau_max};
  return std::make_unique<detail::LinearLaw>(
      std::move(gains), ControlDescription{.law = "PD", .gains = {{"k_p", position}, {"k_v", velocity}}});
}

}  // namespace rivid
