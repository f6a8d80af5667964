#pragma once

#include <optional>
#include <string>

#include "rivid/simulate/control.hpp"

namespace rivid {

/// PD law, Eq. (40) of [RIV]:
///
///   v_τ = k_p k_v (q_r − q) − k_v q̇
///
/// By poles: with (omega_n, zeta), the gains are (45), k_p = ω_n / (2ζ) and k_v = 2ζ ω_n J / g_τ. By gains: with the
/// (k_p, k_v) that are known of an actual controller, and the J_apriori that it was tuned for, k_v is adapted by (46)
/// to k_v J / J_apriori; k_p stays. Without J_apriori both stay as they are.
///
/// Joints that are coupled by a full gear matrix are decoupled, v_τ = G⁻¹ τ, so that the poles are the asked ones here
/// as well; k_v is then a torque a velocity. Known gains are refused there: each signal moves several joints.
struct PdControl {
  Vector omega_n = {};  ///< natural frequencies of the closed loop, (n) [rad/s]
  Vector zeta = {};     ///< damping, (n)

  Vector k_p = {};  ///< known gains, (n) [1/s]
  Vector k_v = {};  ///< (n) [v_τ s/rad | v_τ s/m]
  Vector J_apriori =
      {};  ///< design inertias that they were tuned for, (n); empty: no adaptation [kg·m² | kg]

  /// Whether the velocity error is fed back, v_τ = k_p k_v (q_r − q) + k_v (q̇_r − q̇).
  bool reference_velocity = false;
  Vector v_tau_max = {};  ///< largest |v_τ|, (n); empty: no saturation [as v_τ]

  /// The first fault found, in words that name the joint.
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  /// @throws InputError  the complaint(); where J is needed and is not positive
  [[nodiscard]] std::unique_ptr<ControlLaw> operator()(const Plant& plant) const;
};

}  // namespace rivid
