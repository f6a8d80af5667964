#pragma once

#include <optional>
#include <string>

#include "rivid/simulate/control.hpp"

namespace rivid {

/// Cascade of drives: a proportional position loop whose output, with the reference velocity fed forward, is what a
/// proportional-integral velocity loop follows; anti-windup by back-calculation.
///
///   e_v = k_p (q_r − q) + k_f q̇_r − q̇,   v = k_v e_v + x,   v_τ = sat(v),   ẋ = k_v e_v / T_i + (v_τ − v) / T_t
///
/// By poles: with (omega_n, zeta, omega_i) those of the closed loop are (s² + 2ζ ω_n s + ω_n²)(s + ω_i) = 0, where
/// k_v = (2ζ ω_n + ω_i) J / g_τ, and k_p and 1/T_i are the larger and the smaller root of
/// z² − (ω_n² + 2ζ ω_n ω_i)/(2ζ ω_n + ω_i) z + ω_n² ω_i/(2ζ ω_n + ω_i) = 0. They are real for
/// ω_i ≤ ω_n / (2 (1 + ζ)): a cascade cannot have a faster integral pole. As ω_i → 0 it becomes the PD law with (45) of
/// [RIV].
///
/// By gains: k_p, k_v, T_i of an actual drive; k_v is adapted by J / J_apriori as in (46), the others stay.
///
/// Coupled gears: see PdControl.
struct CascadeControl {
  Vector omega_n = {};  ///< natural frequencies of the closed loop, (n) [rad/s]
  Vector zeta = {};     ///< damping, (n)
  Vector omega_i = {};  ///< pole of the integral action, (n); empty or zero: none [rad/s]

  Vector k_p = {};  ///< known gains: position loop, (n) [1/s]
  Vector k_v = {};  ///< velocity loop, (n) [v_τ s/rad | v_τ s/m]
  Vector T_i = {};  ///< integral time of the velocity loop, (n); empty or infinite: no integral action [s]
  Vector J_apriori =
      {};  ///< design inertias that they were tuned for, (n); empty: no adaptation [kg·m² | kg]

  Vector feed_forward = {};   ///< k_f, (n); empty: 1, the whole of it
  Vector v_tau_max = {};      ///< largest |v_τ|, (n); empty: no saturation [as v_τ]
  Vector tracking_time = {};  ///< T_t, (n); empty: T_i [s]

  /// The first fault found, in words that name the joint.
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  /// @throws InputError  the complaint(); where J is needed and is not positive
  [[nodiscard]] std::unique_ptr<ControlLaw> operator()(const Plant& plant) const;
};

}  // namespace rivid
