#pragma once

#include <memory>

#include "rivid/identify/identification.hpp"

namespace rivid::detail {

// The closed loop of one log, to be simulated with any parameters: the auxiliary model of Eq. (27) of [RIV], section 3.
class AuxiliaryLoop {
 public:
  // The log is referred to, not copied.
  //
  // throws InputError where the log lacks what the loop follows
  AuxiliaryLoop(const Robot& robot, const Log& log, const SignalOptions& signal, const Iv& method);

  // most_steps: of the integrator, beside the budgets of the options.
  [[nodiscard]] Simulation simulate(const DynamicModel& model, const ControlLaw& law, Index most_steps) const;

  // Filtered measured motion and reference at the samples of the log.
  [[nodiscard]] const Motion& measured() const { return measured_; }
  [[nodiscard]] const Motion& reference() const { return reference_motion_; }

  // Control signals that the law gives along the measured motion, (n_m × n).
  [[nodiscard]] Matrix rebuilt_control(const ControlLaw& law) const;

 private:
  const Robot& robot_;
  const Log& log_;
  std::unique_ptr<Reference> reference_;
  SimulationOptions options_;
  Motion measured_;
  Motion reference_motion_;
};

}  // namespace rivid::detail
