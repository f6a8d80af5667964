#pragma once

#include <limits>
#include <optional>

#include "odd/arm.hpp"

namespace rivid::odd {

/// Friction of one joint. The level of dry friction is
///
///   F± = drift(t) (Fc± + Fs e^(−(q̇ / v_s)²) + load |τ| + Fl |M q̈ + N| + Fr |q̇| / (q̇² + v²)^¼)
///
/// where + and − are directions of motion, τ the torque of the motor, and M q̈ + N that of what it moves; v =
/// 1e-3.
struct JointFriction {
  double Fv_plus = 0.0;  ///< viscous
  double Fv_minus = 0.0;
  double Fc_plus = 0.0;
  double Fc_minus = 0.0;
  double offset = 0.0;
  double stribeck = 0.0;        ///< Fs
  double stribeck_speed = 1.0;  ///< v_s
  double load = 0.0;
  double Fl = 0.0;
  double Fr = 0.0;
};

/// An arm with what moves and brakes it: the truth of an experiment.
struct Machine {
  Arm arm;
  Numbers Ia;  ///< rotor inertias, joint side
  std::vector<JointFriction> friction;
  double drift = 0.0;       ///< share of the friction that warming up takes away
  double drift_time = 1.0;  ///< [s]
  Numbers stiffness;        ///< of elastic joints; empty: rigid
  Numbers damping;          ///< beside the springs
  double backlash = 0.0;    ///< half of the play between motor and link, in which the spring does nothing
  double spring = 0.0;      ///< stiffness of a spring at the second joint, a counterbalance
  Numbers ripple;           ///< amplitude of a torque that is periodic in the position; empty: none
  Numbers ripple_cycles;    ///< periods a radian or metre
  /// What the last link carries from some time on.
  struct Payload {
    Body body;
    double from = 0.0;                                       ///< [s]
    double until = std::numeric_limits<double>::infinity();  ///< [s]
  };
  std::optional<Payload> payload;

  [[nodiscard]] Index size() const { return arm.size(); }
  [[nodiscard]] bool elastic() const { return stiffness.size() > 0; }
};

/// M(x) a = b − f of a machine: x are joint positions, of elastic joints link positions and behind them motor
/// positions; f is dry friction, which the levels F bound. Friction acts on the motors.
struct Equation {
  SquareMatrix M;
  Numbers b;
  Numbers F_plus;   ///< level of a motion in positive direction; 0 where there is no dry friction
  Numbers F_minus;  ///< the same in negative direction
  Numbers N;        ///< with Fl: both levels grow by Fl |M x'' + N|
  Numbers Fl;
};

class Plant {
 public:
  explicit Plant(const Machine& machine);

  [[nodiscard]] Index joints() const { return machine_.size(); }
  [[nodiscard]] Index freedoms() const { return machine_.elastic() ? 2 * joints() : joints(); }
  /// Index of the motor of joint j among the degrees of freedom.
  [[nodiscard]] Index motor(Index j) const { return machine_.elastic() ? joints() + j : j; }
  [[nodiscard]] const Machine& machine() const { return machine_; }
  [[nodiscard]] const ArmDynamics& dynamics(double t) const;

  /// @param torque       of the motors, (n)
  /// @param disturbance  torques on the motors besides, (n)
  /// @param direction    ±1 for each degree of freedom, which friction is told by; 0 at rest
  void equation(double t, const Numbers& x, const Numbers& v, const Numbers& torque,
                const Numbers& disturbance, const Numbers& direction, Equation& out) const;

 private:
  Machine machine_;
  ArmDynamics dynamics_;
  ArmDynamics loaded_;
};

}  // namespace rivid::odd
