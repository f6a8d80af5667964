#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/model/parameters.hpp"

namespace rivid {

/// A motor that several joints turn, as in the wrists of many arms: the motor of joint m runs at
///
///   q̇_m + Σ_k ratio_k q̇_k = cᵀ q̇        (joint side: c_m = 1)
///
/// and loads all of these joints with its rotor inertia and its friction,
///
///   τ += c (Iam cᵀ q̈ + Fvm cᵀ q̇ + Fcm sign(cᵀ q̇)).
///
/// Beside joints that have an inertia Ia_i and a friction Fv_i of their own, the diagonal of c cᵀ is no news:
/// Ia_i + c_i² Iam is all that the torque of joint i shows. With Terms::cross, the default, Iam and Fvm therefore
/// stand for the entries off the diagonal alone, and Ia_i, Fv_i hold c_i² Iam, c_i² Fvm. With Terms::all they stand
/// for the whole of c cᵀ. Either way the model reaches the same torques; the values of Iam and Fvm are the same, those
/// of Ia_i and Fv_i differ by that diagonal. Coulomb friction has no such choice: sign(cᵀ q̇) is no sum over joints,
/// and its column is always whole.
///
/// The other reading in use (BIRDy's TX40) ties the coupled inertia to Ia_m and takes the signs of the single
/// velocities: Inertia::tied, Coulomb::single.
struct Coupling {
  /// Whose parameter the coupled inertia is.
  enum class Inertia {
    none,  ///< the motor's inertia is not modelled
    free,  ///< Iam, a parameter of its own
    tied   ///< Ia of joint m: its column gets the coupling terms as well
  };
  /// Velocity whose sign the coupled Coulomb friction has.
  enum class Coulomb {
    none,
    sum,    ///< of the motor: τ_i += Fcm c_i sign(cᵀ q̇)
    single  ///< of each joint alone: τ_i += Fcm Σ_k c_i sign(c_k q̇_k), with Terms::cross over k ≠ i
  };
  /// Entries of c cᵀ that the coupled parameters stand for.
  enum class Terms {
    cross,  ///< those off the diagonal; the joints' own Ia, Fv, Fc hold the others
    all
  };

  int motor = 0;               ///< joint m, counted from 0, that this motor is named after
  std::vector<int> joints;     ///< the other joints that turn it, counted from 0
  std::vector<double> ratios;  ///< c_k of `joints`: unit of joint m per unit of joint k; not zero
  Inertia inertia = Inertia::free;
  bool viscous = true;  ///< whether Fvm is a parameter
  Coulomb coulomb = Coulomb::sum;
  Terms terms = Terms::cross;

  double Iam = 0.0;  ///< a-priori values, unused where they are no parameters [kg·m² | kg]
  double Fvm = 0.0;  ///< [N·m·s/rad | N·s/m]
  double Fcm = 0.0;  ///< [N·m | N]

  /// c, (n) [unit of joint m per unit of the joint].
  [[nodiscard]] Vector row(Index n) const;

  /// The coupled parameters that this coupling adds to the standard ones of joint m: Iam, Fvm, Fcm.
  [[nodiscard]] std::vector<ParameterKind> parameters() const;
};

/// What one coupled parameter is multiplied with in the torque of one joint.
struct CoupledEntry {
  enum class Quantity {
    acceleration,   ///< Σ_k weight_k q̈_k
    velocity,       ///< Σ_k weight_k q̇_k
    single_signs,   ///< Σ_k weight_k sign(q̇_k)
    sign_of_motion  ///< scale sign(Σ_k weight_k q̇_k)
  };
  struct Term {
    std::size_t joint = 0;
    double weight = 0.0;
    double sign_speed = 0.0;  ///< of single_signs: Joint::sign_speed
  };

  std::size_t joint = 0;  ///< whose torque it is in
  Quantity quantity = Quantity::acceleration;
  double scale = 1.0;
  std::vector<Term> terms;
  double sign_speed = 0.0;  ///< of sign_of_motion: Joint::sign_speed of the motor's joint
};

/// Regressor entries of a coupled parameter, one for each joint that feels it, in the order of the joints.
///
/// @param kind  Iam, Fvm, Fcm; or Ia of a coupling with Inertia::tied
/// @param n     joints of the robot
[[nodiscard]] std::vector<CoupledEntry> coupled_entries(const Coupling& coupling, ParameterKind kind,
                                                        Index n);

/// C of q̇_motor = C q̇: the rows c of the couplings, and those of the identity for all other motors, (n × n).
[[nodiscard]] Matrix coupling_matrix(std::span<const Coupling> couplings, Index n);

/// "none", "free", "tied".
[[nodiscard]] std::string_view name(Coupling::Inertia inertia);
/// "none", "sum", "single".
[[nodiscard]] std::string_view name(Coupling::Coulomb coulomb);
/// "cross", "all".
[[nodiscard]] std::string_view name(Coupling::Terms terms);

}  // namespace rivid
