#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "rivid/model/chain.hpp"
#include "rivid/model/coupling.hpp"
#include "rivid/model/friction.hpp"

namespace rivid {

/// What a joint is beside its geometry: names, drive, friction law, limits and a-priori values.
struct Joint {
  std::string name;  ///< of the joint
  std::string link;  ///< that it moves
  JointType type = JointType::revolute;

  Friction friction = Friction::symmetric;
  /// Where it is not 0, Coulomb friction is smooth at reversals: tanh(q̇ / sign_speed) takes the place of sign q̇, in the
  /// regressor and in the dynamics, and nothing sticks [rad/s | m/s].
  double sign_speed = 0.0;
  bool rotor_inertia = true;  ///< whether Ia of this joint is a parameter
  /// Force or torque per unit of the control signal on the motor's side of the gear: K_c K_τ of Eq. (9) of [RIV].
  double drive_gain = 1.0;
  double gear_ratio = 1.0;  ///< K_r of Eq. (9): q̇_m = K_r q̇; see Robot::gear_matrix for coupled gears

  double lower = -std::numeric_limits<double>::infinity();  ///< position limits [rad | m]
  double upper = std::numeric_limits<double>::infinity();
  double max_velocity = std::numeric_limits<double>::infinity();  ///< [rad/s | m/s]
  double max_effort = std::numeric_limits<double>::infinity();    ///< [N·m | N]

  double Ia = 0.0;  ///< a-priori rotor and gear inertia, joint side [kg·m² | kg]
  double Fv = 0.0;  ///< a-priori viscous friction [N·m·s/rad | N·s/m]
  double Fc = 0.0;  ///< a-priori Coulomb friction [N·m | N]

  /// g_τ of Eqs. (8, 9): joint-side torque per unit of the control signal.
  [[nodiscard]] double g_tau() const { return gear_ratio * drive_gain; }
};

/// A serial robot: its chain, its joints and the a-priori inertial parameters of its links.
///
/// Made by read_urdf(), from a KDL::Chain or from a modified Denavit-Hartenberg table; options of the joints
/// may then be changed. A robot is only read by the functions that take it, so threads may share one.
struct Robot {
  std::string name;
  std::string base;  ///< link that the chain starts at
  Chain chain;
  std::vector<Joint> joints;        ///< one for each link of the chain
  std::vector<Inertial> inertials;  ///< a-priori values, in the link frames; zero where none are known
  std::vector<Coupling> couplings;  ///< motors that several joints turn, and their parameters
  /// R of q_motor = R q, (n × n), where gears couple the joints; empty: the diagonal of the gear ratios. By the
  /// balance of power the motors' torques act on the joints through its transpose, τ = Rᵀ τ_motor. It converts
  /// logs and control signals; which parameters the coupling adds to the model is said by `couplings`.
  Matrix gear_matrix;
  /// Parameters count as one where their columns of the regressor differ by less than this fraction of the largest
  /// column of the same unit, between 0 and 1. Angles that are written with few digits tell parameters apart that the
  /// robot does not: 1.5708 for π/2 by some 1e-6, 1.57 by some 2e-4. What geometry tells apart is a few hundredths.
  double base_tolerance = 1e-5;
  std::vector<std::string> warnings;  ///< what the reader noticed and the user should know

  [[nodiscard]] Index size() const { return chain.joints(); }

  /// The standard parameters that this robot has, link by link: XX … M, then Ia where the joint has a rotor
  /// inertia, then those of its friction law (at most 14 a link), then those of its motor's coupling.
  [[nodiscard]] std::vector<StandardParameter> standard_parameters() const;

  /// A-priori values of standard_parameters(), (N_s) [SI, joint side]: chi_st of Eq. (2) of [RIV].
  [[nodiscard]] Vector chi_st() const;

  /// R of q_motor = R q: gear_matrix, or the diagonal of the gear ratios, (n × n).
  [[nodiscard]] Matrix gears() const;

  /// G of τ = G v_τ, Eqs. (8, 9) of [RIV] for coupled gears: Rᵀ diag(drive_gain), (n × n). Without a gear_matrix it
  /// is the diagonal of Joint::g_tau().
  [[nodiscard]] Matrix drive_matrix() const;

  /// The first fault found, in words that name the joint; nothing if the robot can be used.
  [[nodiscard]] std::optional<std::string> complaint() const;
};

}  // namespace rivid
