#pragma once

#include <span>
#include <vector>

#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/dynamics.hpp"

namespace rivid {

/// What a dry friction element does: it slips in one direction, or it sticks.
enum class FrictionMode : signed char { slip_minus = -1, stick = 0, slip_plus = 1 };

/// Coulomb friction as what it is: a force that opposes motion, and holds at rest while it is strong enough.
///
/// Each DryFriction element of a model has a mode. Between changes of mode the motion is smooth: slipping
/// elements brake with their λ of one direction, sticking ones keep their speed at zero by the λ that it
/// takes,
///
///   q̈ = M⁻¹ (f − Σ b_e λ_e),   c_eᵀ q̈ = 0 for all e that stick.
///
/// Where a speed reaches zero or torques jump, settle() finds the next modes: for all elements at rest
/// together, λ_e within its limits where the element stays at rest, at a limit where it is driven off. For b
/// = c these are the conditions of the largest dissipation, a convex problem in λ, solved by least-index
/// principal pivoting (Murty 1974).
///
/// Where elements are coupled so closely that their λ are not unique (two joints and the motor that both
/// turn, all at rest), the holding torque is shared among them; the motion does not depend on how.
///
/// Friction that follows the load, DryFriction::load, is part of λ_e and of its limits here, where the torque
/// f_j on its joint says how large it is: slipping forwards, f_j − λ_e is what remains of f_j − Fc − Fl |f_j
/// − λ_e|; it breaks away where the λ_e that holds exceeds Fc + Fl |f_j − λ_e|.
///
/// Members check neither sizes nor indices of elements: wrong ones are undefined behaviour.
class StickSlip {
 public:
  explicit StickSlip(const DynamicModel& model);

  [[nodiscard]] Index size() const { return static_cast<Index>(elements_.size()); }
  [[nodiscard]] FrictionMode mode(Index e) const { return elements_[static_cast<std::size_t>(e)].mode; }
  /// Number of times that the element's mode has changed since reset().
  [[nodiscard]] Index changes(Index e) const { return elements_[static_cast<std::size_t>(e)].changes; }
  [[nodiscard]] const std::string& name(Index e) const {
    return elements_[static_cast<std::size_t>(e)].law.name;
  }
  /// Elements that stick now.
  [[nodiscard]] Index sticking() const { return static_cast<Index>(stuck_.size()); }

  /// Speed of an element, c_eᵀ q̇.
  [[nodiscard]] double speed(Index e, std::span<const double> qd) const;

  /// Modes at the beginning of a motion: slipping where the element moves, at rest where its speed is exactly
  /// zero.
  void reset(std::span<const double> qd);

  /// Accelerations in the present modes. No allocation.
  ///
  /// @param dynamics  at the state, M positive definite
  /// @param qd        velocities, (n)
  /// @param f         torques that accelerate without dry friction, τ − N − viscous q̇ − offset, (n);
  ///                  overwritten
  /// @param qdd       accelerations, (n); exactly zero for joints that stick
  void accelerate(const Dynamics<double>& dynamics, std::span<const double> qd, std::span<double> f,
                  std::span<double> qdd);

  /// Takes the torques of all slipping elements off f, (n).
  ///
  /// @param f  τ − viscous q̇ − offset, N included
  void brake(std::span<const double> qd, std::span<double> f) { brake(qd, f, {}, {}); }

  /// λ of an element at the last accelerate() or settle() [N·m | N].
  [[nodiscard]] double lambda(Index e) const { return lambda_[e]; }

  /// What changes its sign from positive to negative where the mode of an element ends: while it slips, its
  /// speed in the direction of slipping; while it sticks, the distance of λ at the last accelerate() from its
  /// limits, as a fraction of them.
  [[nodiscard]] double margin(Index e, std::span<const double> qd) const;

  /// Next modes after an event or a jump of the torques: whatever is at rest is decided anew.
  ///
  /// @param ended  element whose mode has ended, margin() = 0, or −1: if it slipped it is at rest now; if it
  ///               stuck it is driven off in the direction of its λ
  /// @param qd     velocities; made exactly zero for joints at rest, (n)
  /// @param f      as for accelerate(); overwritten
  /// @return       number of modes that changed
  Index settle(const Dynamics<double>& dynamics, Index ended, std::span<double> qd, std::span<double> f);

 private:
  struct Element {
    DryFriction law;
    Index joint = -1;      // the one joint that it belongs to, −1 for a motor of several
    bool alone = false;    // whether it brakes that joint alone
    double Fc_plus = 0.0;  // limits of λ at rest, under the present load
    double Fc_minus = 0.0;
    FrictionMode mode = FrictionMode::stick;
    Index changes = 0;
  };

  // λ of an element that slips. driving: f_j of its joint, N included.
  [[nodiscard]] static double slipping_lambda(const Element& element, bool plus, double speed,
                                              double driving);
  // Limits of all elements under the torques f, without N.
  void load_limits(std::span<const double> f, std::span<const double> N);
  // N: what is missing in f; empty: nothing.
  void brake(std::span<const double> qd, std::span<double> f, std::span<const double> N,
             std::span<const Index> but);
  void responses(const Dynamics<double>& dynamics, std::span<const Index> elements);
  void hold(std::span<const Index> elements);
  bool pivot();
  void list_stuck();

  Index n_;
  std::vector<Element> elements_;
  std::vector<Index> stuck_;
  std::vector<Index> resting_;
  std::vector<FrictionMode> before_;
  Vector lambda_;
  Matrix response_;  // M⁻¹ b_e, (n × elements)
  Matrix G_;         // c_eᵀ M⁻¹ b_l among the elements at rest, in the order asked for
  Matrix system_;    // scratch of hold()
  Vector rhs_;
  Vector solution_;  // scratch of hold()
  Vector qdd_;
};

}  // namespace rivid
