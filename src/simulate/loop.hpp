#pragma once

#include <span>
#include <vector>

#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/stick_slip.hpp"

namespace rivid::detail {

// The closed loop as an ordinary differential equation, y = [q; q̇; x] with the states x of the control law.
// It is smooth between events: instants at which the mode of a dry friction element ends.
class LoopOde {
 public:
  LoopOde(const Robot& robot, const DynamicModel& model, const ControlLaw& law, const Reference& reference,
          const SimulationOptions& options);

  [[nodiscard]] Index size() const { return 2 * n_ + states_; }
  [[nodiscard]] Index joints() const { return n_; }
  [[nodiscard]] Index events() const { return exact_ ? stick_slip_.size() : 0; }

  // y' at (t, y) in the present modes; false where M is not positive definite.
  [[nodiscard]] bool rate(double t, const double* y, double* yd);
  // Whether y' is M⁻¹ (f − N) with the f of driving_torques(): nothing holds still.
  [[nodiscard]] bool slides() const { return !sticking(); }
  // f, (n), for who finds M and N of many instants at once.
  void driving_torques(double t, const double* y, double* f);
  // Whether the torques that accelerate are, between two control instants,
  //   held_torque() − viscous q̇ − N − Σ torque λ,
  // with viscous diagonal, and each λ linear in the speed of one joint while it slips.
  // A LoopPack steps such loops.
  [[nodiscard]] bool simple() const { return simple_; }
  // Torques that act until the next hold: those of the drives (see tau()), disturbance and offset.
  [[nodiscard]] const Vector& held_torque();

  // margin() of every element at the last rate().
  void margins(const double* y, double* g) const;
  // Whether margins() depend on more than y, so that rate() has to be called before.
  [[nodiscard]] bool sticking() const { return exact_ && stick_slip_.sticking() > 0; }

  // Decides the modes anew, see StickSlip::settle(); false where M is not positive definite.
  [[nodiscard]] bool settle(double t, double* y, Index ended);
  void reset_modes(const double* y);

  // Control held from now on (sampled laws), and what is added to control and torques.
  void hold_control(const Eigen::Ref<const Vector>& v_tau) { v_tau_ = v_tau; }
  void hold_added(const Eigen::Ref<const Vector>& v) { added_ = v; }
  void hold_disturbance(const Eigen::Ref<const Vector>& tau) { disturbance_ = tau; }
  // Friction torques held from now on (DryFrictionScheme::held), from the velocities of y.
  void hold_friction(const double* y);

  // Control signals and torques of the last rate(), (n).
  [[nodiscard]] const Vector& v_tau() const { return v_tau_; }
  [[nodiscard]] const Vector& tau() const { return tau_; }
  // Reference of the last rate() of a continuous law, (n).
  [[nodiscard]] const Vector& q_r() const { return q_r_; }

  [[nodiscard]] const StickSlip& stick_slip() const { return stick_slip_; }
  [[nodiscard]] const Dynamics<double>& dynamics() const { return dynamics_; }
  // States at which M and N were made.
  [[nodiscard]] Index evaluations() const { return evaluations_; }
  // Steps that a LoopPack took from here count as if they had been taken here.
  void count_evaluations(Index count) { evaluations_ += count; }
  // Whether M and N are those of y.
  [[nodiscard]] bool is_at(const double* y) const;
  // Makes M and N of y, uncounted: they were found elsewhere.
  void return_to(const double* y);

  [[nodiscard]] const DynamicModel& model() const { return model_; }

 private:
  [[nodiscard]] bool move_to(const double* y);
  [[nodiscard]] bool has_simple_torques() const;
  // Torques of the drives and of the disturbance, from the present control.
  void drive_torques();
  // Fills torque_ with what accelerates beside dry friction and N, and the rates of x, at q_ and qd_.
  void torques_beside_bias(double t, const double* y, double* xd);
  // The same beside dry friction alone.
  [[nodiscard]] bool torques(double t, const double* y, double* xd);
  // Takes friction that is smooth off torque_: all of DryFrictionScheme::smooth, else that of a
  // Joint::sign_speed.
  void brake_smoothly();
  void smooth_friction(std::span<const double> qd, Vector& torque) const;

  const DynamicModel& model_;
  const ControlLaw& law_;
  const Reference& reference_;
  Index n_;
  Index states_;
  bool sampled_;
  bool exact_;
  bool held_;
  double smooth_velocity_;
  bool smooth_elements_;
  Matrix drive_;
  bool diagonal_drive_;
  bool diagonal_viscous_;
  bool simple_;
  Dynamics<double> dynamics_;
  StickSlip stick_slip_;
  Index evaluations_ = 0;
  bool definite_ = false;

  Vector q_, qd_, x_, xd_;
  Vector q_r_, qd_r_, qdd_r_;
  Vector v_tau_, added_, disturbance_, tau_, torque_, friction_;
};

// A control law on a computer: what it measures, what it makes of it, and when that acts.
class SampledController {
 public:
  // in_control  whether the law was in control before the first tick, which then gave the same signals
  SampledController(const ControlLaw& law, const Reference& reference, const Sampling& sampling, Index n,
                    bool in_control = false);

  // One period: measures at t the true motion (q, q̇) and gives the control signals that act from t on, until
  // later() does from the part switches_at() of the period on.
  const Vector& tick(double t, const Eigen::Ref<const Vector>& q, const Eigen::Ref<const Vector>& qd);
  [[nodiscard]] double switches_at() const { return switches_at_; }  // 0: never
  [[nodiscard]] auto later() const { return computed_.col((ticks_ + 1) % computed_.cols()); }

  // Positions as measured at the last tick.
  [[nodiscard]] const Vector& q_measured() const { return q_; }
  // Reference of the last tick.
  [[nodiscard]] const Vector& q_r() const { return q_r_; }

 private:
  const ControlLaw& law_;
  const Reference& reference_;
  const Sampling& sampling_;
  bool in_control_;
  double switches_at_;
  Index ticks_ = 0;
  Vector q_, qd_, x_, xd_, q_r_, qd_r_, qdd_r_, v_;
  Matrix measured_;  // (n × taps) the last positions, a ring
  Matrix computed_;  // (n × ⌈delay⌉ + 1) control signals that wait, a ring
};

}  // namespace rivid::detail
