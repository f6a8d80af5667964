#pragma once

#include <algorithm>
#include <memory>

#include "simulate/loop.hpp"

namespace rivid::detail {

// Carries a LoopOde forward, step by step, each of which ends at an event at the latest.
class LoopIntegrator {
 public:
  enum class Halt { none, event, not_positive_definite, failed };
  struct Step {
    double t = 0.0;  // reached
    Halt halt = Halt::none;
    Index event = -1;  // element whose mode ended at t
  };

  LoopIntegrator() = default;
  LoopIntegrator(const LoopIntegrator&) = delete;
  LoopIntegrator& operator=(const LoopIntegrator&) = delete;
  virtual ~LoopIntegrator() = default;

  // Begins anew at (t, y): y' may have jumped there.
  virtual void restart(double t, const double* y) = 0;
  // One step, not beyond t_stop.
  virtual Step step(double t_stop) = 0;
  // State at an instant within the last step.
  virtual void state(double t, double* y) = 0;

  // Length of the Bogacki-Shampine step that it would take next, with so much time to go, and that a LoopPack
  // can take for it; 0 where it can not.
  [[nodiscard]] virtual double proposal(double /*left*/) const { return 0.0; }
  // What it makes of the error of that step relative to its tolerance: whether the step stands. Else the next
  // proposal() is shorter.
  [[nodiscard]] virtual bool judge(double /*left*/, double /*error*/) { return false; }
};

struct IntegratorOptions {
  double rtol = 1e-6;
  double atol = 1e-8;
  double max_step = 0.0;  // 0: none
  // The same while an element sticks: nothing moves then, so the error of a step says nothing about how soon
  // the torques will drive it off.
  double max_step_sticking = 0.0;

  [[nodiscard]] double longest_step(bool sticking) const {
    if (!sticking || max_step_sticking == 0.0) {
      return max_step;
    }
    return max_step > 0 ? std::min(max_step, max_step_sticking) : max_step_sticking;
  }
};

// CVODE; bdf: for stiff loops, else Adams.
[[nodiscard]] std::unique_ptr<LoopIntegrator> cvode_integrator(LoopOde& ode, const IntegratorOptions& options,
                                                               bool bdf);
// Explicit pairs with error control, of third and of fifth order.
[[nodiscard]] std::unique_ptr<LoopIntegrator> bogacki_shampine_integrator(LoopOde& ode,
                                                                          const IntegratorOptions& options);
[[nodiscard]] std::unique_ptr<LoopIntegrator> dormand_prince_integrator(LoopOde& ode,
                                                                        const IntegratorOptions& options);
// One step from restart() to t_stop; knows no events.
[[nodiscard]] std::unique_ptr<LoopIntegrator> rk4_integrator(LoopOde& ode);

}  // namespace rivid::detail
