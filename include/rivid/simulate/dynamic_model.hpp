#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/simulate/dynamics.hpp"

namespace rivid {

/// A robot with numbers for its parameters, checked, as the direct dynamics (21) of [RIV] reads it: see
/// ModelData.
///
/// Friction that would drive instead of brake can not be simulated: negative coefficients count as zero, and
/// the viscous matrix loses its negative eigenvalues; clamped() names what was changed. Friction that follows
/// the load takes at most 0.95 of it. An asymmetric law is negative where the mean of its directions is: Fc+
/// = 3 and Fc− = −1 are a friction of 1 with an offset of 2. The coupled friction of
/// Coupling::Coulomb::single is taken with either sign; where joint k itself does not brake, what follows the
/// sign of its velocity is left out, since at rest it would have no value.
///
/// Inertias are taken as they are, even where they belong to no physical body: the regrouped base parameters
/// are such a set, and give the same M(q).
class DynamicModel {
 public:
  /// @param chi_st  values of robot.standard_parameters(), (N_s) [SI, joint side]
  /// @throws InputError  the robot's complaint(); where the size differs or a value is not finite; friction
  ///                     of another law than Fv, Fc, off of a joint whose velocity's sign is that of a
  ///                     coupled motor, too
  DynamicModel(const Robot& robot, const Eigen::Ref<const Vector>& chi_st);

  /// From base parameters alone, by BaseParameters::to_standard().
  ///
  /// @param chi  (b)
  /// @throws InputError  as above, and where `base` are the parameters of another robot
  DynamicModel(const Robot& robot, const BaseParameters& base, const Eigen::Ref<const Vector>& chi);

  /// What dynamics and controllers read.
  [[nodiscard]] const ModelData& data() const { return data_; }
  operator const ModelData&() const { return data_; }  // NOLINT(google-explicit-constructor)

  [[nodiscard]] Index size() const { return data_.size(); }
  [[nodiscard]] const Chain& chain() const { return data_.chain; }
  [[nodiscard]] const std::vector<Joint>& joints() const { return joints_; }
  [[nodiscard]] const std::vector<Inertial>& inertials() const { return data_.inertials; }
  [[nodiscard]] const Matrix& rotor() const { return data_.rotor; }
  [[nodiscard]] const Matrix& viscous() const { return data_.viscous; }
  [[nodiscard]] const Vector& offset() const { return data_.offset; }
  [[nodiscard]] const std::vector<DryFriction>& dry_friction() const { return data_.dry_friction; }
  /// Names of the friction parameters that were taken as zero for their sign.
  [[nodiscard]] const std::vector<std::string>& clamped() const { return clamped_; }

 private:
  ModelData data_;
  std::vector<Joint> joints_;
  std::vector<std::string> clamped_;
};

/// M(q) of Eq. (21) of [RIV], links and rotors, (n × n) [kg·m² | kg·m | kg].
///
/// @param q  (n) [rad | m]
/// @throws InputError  where a size differs
[[nodiscard]] Matrix mass_matrix(const DynamicModel& model, const Eigen::Ref<const Vector>& q);

/// N(q, q̇) of Eq. (21) of [RIV]: Coriolis, centrifugal and gravity torques without any friction, (n) [N·m |
/// N].
///
/// @param q   (n) [rad | m]
/// @param qd  (n) [rad/s | m/s]
/// @throws InputError  where a size differs
[[nodiscard]] Vector bias(const DynamicModel& model, const Eigen::Ref<const Vector>& q,
                          const Eigen::Ref<const Vector>& qd);

/// Friction torques of a motion, viscous q̇ + offset + Σ torque_e λ_e, (n) [N·m | N], without what follows
/// the load.
///
/// Elements at rest are silent, as sign(0) = 0 in the regressor. What they hold depends on the other torques.
///
/// @param qd  (n) [rad/s | m/s]
/// @throws InputError  where a size differs
[[nodiscard]] Vector friction_torque(const DynamicModel& model, const Eigen::Ref<const Vector>& qd);

/// τ = M q̈ + N + friction_torque() + Fl |M q̈ + N| sign q̇, (n) [N·m | N]: Eq. (1) of [RIV] with numbers,
/// the torques of the regressor.
///
/// @param q    (n) [rad | m]
/// @param qd   (n) [rad/s | m/s]
/// @param qdd  (n) [rad/s² | m/s²]
/// @throws InputError  where a size differs
[[nodiscard]] Vector inverse_dynamics(const DynamicModel& model, const Eigen::Ref<const Vector>& q,
                                      const Eigen::Ref<const Vector>& qd,
                                      const Eigen::Ref<const Vector>& qdd);

/// q̈ = M⁻¹ (τ − N − friction), Eq. (21) of [RIV], (n) [rad/s² | m/s²], the inverse of inverse_dynamics().
///
/// Away from rest this is the motion; a joint at rest moves as if it had no Coulomb friction, so whoever
/// integrates through reversals must say which joints stick.
///
/// @param q    (n) [rad | m]
/// @param qd   (n) [rad/s | m/s]
/// @param tau  (n) [N·m | N]
/// @throws InputError  where a size differs
/// @throws NumericsError  where M is not positive definite, with joint and eigenvalue
[[nodiscard]] Vector direct_dynamics(const DynamicModel& model, const Eigen::Ref<const Vector>& q,
                                     const Eigen::Ref<const Vector>& qd, const Eigen::Ref<const Vector>& tau);

/// Smallest eigenvalue of M(q), for messages about an M that is not positive definite. (Where revolute and
/// prismatic joints meet, its size depends on the units, its sign does not.)
///
/// @param q  (n) [rad | m]
/// @throws InputError  where a size differs
[[nodiscard]] double smallest_eigenvalue(const DynamicModel& model, const Eigen::Ref<const Vector>& q);

}  // namespace rivid

#ifdef RIVID_DEFINITIONS
#include "rivid/simulate/dynamic_model_inline.hpp"
#endif
