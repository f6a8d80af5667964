#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"

namespace rivid {

/// Friction along one direction of the joint velocities that is no matter of the viscous matrix alone: of a joint, or of a
/// motor that several joints turn.
///
/// At the speed s = directionᵀ q̇ it brakes with λ(s) = Σ c φ(s, sign s) over its terms, which have a coefficient c for
/// each direction of motion, and at rest with whatever −Fc_minus ≤ λ ≤ Fc_plus holds it there; the torques on the joints
/// are −torque λ. The two vectors are the same but for Coupling::Coulomb::single.
struct DryFriction {
  /// Coefficients of one function while the speed is positive, and while it is negative; ≥ 0. Of Basis::speed, what a
  /// direction has beyond the other one, which is in DynamicModel::viscous().
  struct Term {
    Basis basis = Basis::sign;
    double plus = 0.0;
    double minus = 0.0;
  };

  std::string name;  ///< of the joint; of a motor that several joints turn, "motor of <joint>"
  Vector direction;  ///< c, (n)
  Vector torque;     ///< b, (n)
  std::vector<Term> terms;
  double Fc_plus = 0.0;   ///< λ where a positive speed begins, dry(true, 0, 1) [N·m | N], ≥ 0
  double Fc_minus = 0.0;  ///< −λ where a negative one begins [N·m | N], ≥ 0
  /// Joint::sign_speed: where it is not 0, tanh(s / sign_speed) takes the place of sign s, and nothing sticks.
  double sign_speed = 0.0;

  /// What follows the sign in λ, of one direction of motion. `sign`: ±1, or what smooths it.
  [[nodiscard]] double dry(bool plus, double speed, double sign) const {
    return sum(plus, speed, sign, true);
  }
  /// What follows the speed in λ, of one direction of motion.
  [[nodiscard]] double viscous(bool plus, double speed) const {
    return sum(plus, speed, plus ? 1.0 : -1.0, false);
  }
  /// λ of a speed, with `smallest` for a sign_speed of 0; 0 is the sign itself, and silent at rest.
  [[nodiscard]] double lambda(double speed, double smallest = 0.0) const {
    return dry(speed > 0.0, speed, sign(speed, sign_speed > 0.0 ? sign_speed : smallest)) +
           viscous(speed > 0.0, speed);
  }

 private:
  [[nodiscard]] double sum(bool plus, double speed, double sign, bool of_dry) const {
    double out = 0.0;
    for (const Term& term : terms) {
      if ((about(term.basis).role == Role::dry) == of_dry) {
        out += (plus ? term.plus : term.minus) * friction_function(term.basis, speed, sign);
      }
    }
    return out;
  }
};

/// A robot with numbers for its parameters, as the direct dynamics (21) of [RIV] reads it:
///
///   M(q) q̈ + N(q, q̇) + viscous q̇ + offset + Σ torque_e λ_e = τ,   M(q) = M_links(q) + rotor.
///
/// Friction that would drive instead of brake can not be simulated: negative coefficients count as zero, and the viscous
/// matrix loses its negative eigenvalues; clamped() names what was changed. An asymmetric law is negative
/// where the mean of its directions is: Fc+ = 3 and Fc− = −1 are a friction of 1 with an offset of 2. The coupled
/// friction of Coupling::Coulomb::single is taken with either sign; where joint k itself does not brake, what follows
/// the sign of its velocity is left out, since at rest it would have no value.
///
/// Inertias are taken as they are, even where they belong to no physical body: the regrouped base parameters are such
/// a set, and give the same M(q).
class DynamicModel {
 public:
  /// @param chi_st  values of robot.standard_parameters(), (N_s) [SI, joint side]
  /// @throws InputError  the robot's complaint(); where the size differs or a value is not finite; friction of
  ///                     another law than Fv, Fc, off of a joint whose velocity's sign is that of a coupled motor, too
  DynamicModel(const Robot& robot, const Eigen::Ref<const Vector>& chi_st);

  /// From base parameters alone, by BaseParameters::to_standard().
  ///
  /// @param chi  (b)
  /// @throws InputError  as above, and where `base` are the parameters of another robot
  DynamicModel(const Robot& robot, const BaseParameters& base, const Eigen::Ref<const Vector>& chi);

  [[nodiscard]] Index size() const { return chain_.joints(); }
  [[nodiscard]] const Chain& chain() const { return chain_; }
  [[nodiscard]] const std::vector<Joint>& joints() const { return joints_; }

  /// Inertial parameters of the links in the frames j of the chain, (n).
  [[nodiscard]] const std::vector<Inertial>& inertials() const { return inertials_; }
  /// What rotors add to M(q): Ia on the diagonal and Iam of coupled motors, (n × n), symmetric [kg·m² | kg].
  [[nodiscard]] const Matrix& rotor() const { return rotor_; }
  /// Viscous friction: Fv on the diagonal and Fvm of coupled motors, (n × n), symmetric, positive semidefinite.
  [[nodiscard]] const Matrix& viscous() const { return viscous_; }
  /// Friction offsets, (n) [N·m | N].
  [[nodiscard]] const Vector& offset() const { return offset_; }
  /// Friction that depends on the sign of a velocity, or not in proportion to it; only elements that brake at all.
  [[nodiscard]] const std::vector<DryFriction>& dry_friction() const { return dry_friction_; }
  /// Names of the friction parameters that were taken as zero for their sign.
  [[nodiscard]] const std::vector<std::string>& clamped() const { return clamped_; }

 private:
  Chain chain_;
  std::vector<Joint> joints_;
  std::vector<Inertial> inertials_;
  Matrix rotor_;
  Matrix viscous_;
  Vector offset_;
  std::vector<DryFriction> dry_friction_;
  std::vector<std::string> clamped_;
};

/// Largest inertia that each joint's drive sees along a motion, Eq. (38) of [RIV]:
///
///   J_j = ZZ_j + Ia_j + max_q (M_jj(q) − ZZ_j − Ia_j) = max_q M_jj(q)
///
/// [RIV] takes the maximum over all q; here it is over the samples of `q`, every one of them, which is what the loop
/// meets.
///
/// @param q  joint positions, (n_m × n), n_m ≥ 1 [rad | m]
/// @return   J, (n) [kg·m² | kg]; all entries positive
/// @throws InputError     where q does not fit the robot or is not finite
/// @throws NumericsError  where M_jj is not positive at a sample, with joint, sample and value
[[nodiscard]] Vector design_inertia(const DynamicModel& model, const Eigen::Ref<const Matrix>& q);

/// How the largest M_jj is searched among all positions.
struct InertiaSearch {
  Index samples = 1024;  ///< positions of the global search, a quasi-random sequence, the same in every run
  Index starts = 4;      ///< the best positions of each joint, from which it is refined

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// Largest inertia that each joint's drive sees at all, the J_j of Eq. (38) of [RIV] over all q.
///
/// M_jj depends on the joints behind j only. It is searched over a box of their positions: within the limits of each
/// joint, a revolute joint without limits through one turn. From the best of the positions sampled, M_jj climbs along
/// one coordinate at a time until none gives more.
/// That is a lower bound of the true maximum: it is a local one, in practice the global one, without a proof.
///
/// @return  J, (n) [kg·m² | kg]; all entries positive
/// @throws InputError     the search's complaint(); where a prismatic joint beyond the first has no limits
/// @throws NumericsError  where M_jj is not positive at a position that was sampled, with joint and value
[[nodiscard]] Vector design_inertia(const DynamicModel& model, const InertiaSearch& search = {});

}  // namespace rivid
