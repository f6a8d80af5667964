#pragma once

#include <optional>
#include <string>

#include "rivid/simulate/control.hpp"

namespace rivid {

/// PID law with reference velocity, gains in units of the control signal, and anti-windup by back-calculation:
///
///   v = K_p (q_r − q) + K_d (q̇_r − q̇) + x,   v_τ = sat(v),   ẋ = K_i (q_r − q) + (v_τ − v) / T_t
///
/// By poles: with (omega_n, zeta, omega_i) those of the closed loop are (s² + 2ζ ω_n s + ω_n²)(s + ω_i) = 0, hence
///
///   K_p = (ω_n² + 2ζ ω_n ω_i) J / g_τ,   K_i = ω_n² ω_i J / g_τ,   K_d = (2ζ ω_n + ω_i) J / g_τ.
///
/// By gains: K_p, K_i, K_d of an actual controller, all adapted by J / J_apriori as in (46) of [RIV]. Without K_i it is
/// the PD law of manufacturers, v_τ = K_p e + K_d ė.
///
/// Coupled gears: see PdControl.
struct PidControl {
  Vector omega_n = {};  ///< natural frequencies of the closed loop, (n) [rad/s]
  Vector zeta = {};     ///< damping, (n)
  Vector omega_i = {};  ///< pole of the integral action, (n); empty or zero: none [rad/s]

  Vector K_p = {};  ///< known gains, (n) [v_τ/rad | v_τ/m]
  Vector K_i = {};  ///< (n); empty or zero: no integral action [v_τ/(rad s) | v_τ/(m s)]
  Vector K_d = {};  ///< (n) [v_τ s/rad | v_τ s/m]
  Vector J_apriori =
      {};  ///< design inertias that they were tuned for, (n); empty: no adaptation [kg·m² | kg]

  Vector v_tau_max = {};  ///< largest |v_τ|, (n); empty: no saturation [as v_τ]
  /// T_t: how fast the integral follows a saturated signal, (n); empty: √(K_d / K_i), or K_p / K_i without K_d [s]
  Vector tracking_time = {};

  /// The first fault found, in words that name the joint.
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  /// @throws InputError  the complaint(); where J is needed and is not positive
  [[nodiscard]] std::unique_ptr<ControlLaw> operator()(const Plant& plant) const;
};

}  // namespace rivid
