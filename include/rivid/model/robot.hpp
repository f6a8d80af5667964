#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "rivid/model/chain.hpp"
#include "rivid/model/friction.hpp"

namespace rivid {

/// What a joint is beside its geometry: names, drive, friction law, limits and a-priori values.
struct Joint {
  std::string name;  ///< of the joint
  std::string link;  ///< that it moves
  JointType type = JointType::revolute;

  Friction friction = Friction::symmetric;
  bool rotor_inertia = true;  ///< whether Ia of this joint is a parameter
  /// Force or torque per unit of the control signal on the motor's side of the gear: K_c K_τ of Eq. (9) of [RIV].
  double drive_gain = 1.0;
  double gear_ratio = 1.0;  ///< K_r of Eq. (9): q̇_m = K_r q̇

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
  std::vector<Joint> joints;          ///< one for each link of the chain
  std::vector<Inertial> inertials;    ///< a-priori values, in the link frames; zero where none are known
  std::vector<std::string> warnings;  ///< what the reader noticed and the user should know

  [[nodiscard]] Index size() const { return chain.joints(); }

  /// The standard parameters that this robot has, link by link: XX … M, then Ia where the joint has a rotor
  /// inertia, then those of its friction law (N_s ≤ 14 n of them).
  [[nodiscard]] std::vector<StandardParameter> standard_parameters() const;

  /// A-priori values of standard_parameters(), (N_s) [SI, joint side]: chi_st of Eq. (2) of [RIV].
  [[nodiscard]] Vector chi_st() const;

  /// The first fault found, in words that name the joint; nothing if the robot can be used.
  [[nodiscard]] std::optional<std::string> complaint() const;
};

}  // namespace rivid
