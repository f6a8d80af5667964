#pragma once

#include <functional>

#include "odd/machine.hpp"

namespace rivid::odd {

/// A machine on its way through time, with exact stiction: each motor moves in positive direction, in
/// negative direction, or sticks, and the instants at which that changes are located.
class Simulation {
 public:
  /// Torques of the motors, (n), at a time and a state of the motors.
  using Torque = std::function<Numbers(double t, const Numbers& q, const Numbers& qd)>;

  /// @param step  longest step of the integrator, the classical Runge-Kutta method of fourth order [s]
  Simulation(const Plant& plant, double step);

  /// Puts motors and links at q, with the springs of elastic joints deflected as at rest.
  void start(double t, const Numbers& q, const Numbers& qd);
  /// Goes on to time `end`, with torques that are continuous until then.
  ///
  /// @param disturbance  torques on the motors besides, (n)
  void advance(double end, const Torque& torque, const Numbers& disturbance);

  [[nodiscard]] double time() const { return t_; }
  [[nodiscard]] Numbers positions() const { return motors(x_); }  ///< of the motors, (n)
  [[nodiscard]] Numbers links() const { return x_.head(plant_.joints()); }
  [[nodiscard]] Numbers velocities() const { return motors(v_); }  ///< of the motors, (n)
  [[nodiscard]] bool sticks(Index joint) const { return mode_[plant_.motor(joint)] == 0.0; }
  [[nodiscard]] long events() const { return events_; }

 private:
  struct State {
    Numbers x;
    Numbers v;
  };
  [[nodiscard]] Numbers motors(const Numbers& of_freedoms) const;
  void prepare(double t, const State& state);
  // Accelerations, with those at rest held, and what dry friction is.
  void solve();
  [[nodiscard]] double room(Index i) const;
  [[nodiscard]] State step_from(const State& state, double h);
  // How far the state at the end of a step of h is from a change of mode; negative behind it.
  [[nodiscard]] double margin(double h, State& end);
  double until_event(double h, State& end);
  // What happens to motors at rest: they stick where friction can hold them.
  void release();

  const Plant& plant_;
  double step_;
  double t_ = 0.0;
  Numbers x_, v_;
  Numbers mode_;  // ±1: direction of motion; 0: sticks
  const Torque* torque_ = nullptr;
  const Numbers* disturbance_ = nullptr;
  Equation equation_;
  Numbers a_, f_;
  Numbers by_load_;  // part of the level of dry friction
  long events_ = 0;
};

}  // namespace rivid::odd
