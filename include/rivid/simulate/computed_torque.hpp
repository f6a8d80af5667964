#pragma once

#include <optional>
#include <string>

#include "rivid/simulate/control.hpp"

namespace rivid {

/// Computed torque: the inverse dynamics of a model of the robot make it n double integrators, which a PD law governs,
///
///   τ = M̂(q) (q̈_r + k_d (q̇_r − q̇) + k_p (q_r − q)) + N̂(q, q̇) + friction,   v_τ = sat(G⁻¹ τ).
///
/// By poles: k_p = ω_n² and k_d = 2ζ ω_n. Where the model is the plant's, the error obeys ë + k_d ė + k_p e = 0. The
/// design inertia is not used. Coupled gears need no more than G⁻¹.
struct ComputedTorqueControl {
  Vector omega_n = {};  ///< natural frequencies of the closed loop, (n) [rad/s]
  Vector zeta = {};     ///< damping, (n)

  Vector k_p = {};  ///< gains in place of the poles, (n) [1/s²]
  Vector k_d = {};  ///< (n) [1/s]

  /// The model that the controller has, as it was in the experiment. Empty: adapted, the model of each plant.
  std::shared_ptr<const DynamicModel> model = {};

  /// Whether friction is compensated as well: viscous friction and offset at the measured velocity, Coulomb friction at
  /// the reference's, whose sign does not chatter, smoothed by tanh(q̇_r / coulomb_velocity).
  bool friction = true;
  double coulomb_velocity = 1e-2;  ///< [rad/s | m/s]

  Vector v_tau_max = {};  ///< largest |v_τ|, (n); empty: no saturation [as v_τ]

  /// The first fault found, in words that name the joint.
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  /// @throws InputError  the complaint()
  [[nodiscard]] std::unique_ptr<ControlLaw> operator()(const Plant& plant) const;
};

}  // namespace rivid
