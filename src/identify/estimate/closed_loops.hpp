#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/estimate/estimate.hpp"
#include "rivid/identify/loop_factors.hpp"
#include "simulate/loop_run.hpp"

namespace rivid::detail {

// The closed loop of one log, to be simulated with any parameters: the auxiliary model of Eq. (27) of [RIV],
// section 3.
class AuxiliaryLoop {
 public:
  // The log is referred to, not copied.
  //
  // throws InputError where the log lacks what the loop follows
  AuxiliaryLoop(const Robot& robot, const Log& log, const SignalOptions& signal, const Iv& method);

  // most_steps, most_seconds: beside the budgets of the options.
  [[nodiscard]] LoopTask task(const DynamicModel& model, const ControlLaw& law, std::optional<double> delay,
                              Index most_steps, double most_seconds) const;

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

// The loops of all logs, simulated with some parameters.
struct SimulatedLoops {
  std::string failure;                            // empty where all were simulated
  bool gave_up = false;                           // the failure is a budget of the options that was used up
  std::vector<Motion> motions;                    // one a log; none where the logs are elsewhere
  std::shared_ptr<const LoopFactors> found;       // what their loops came to there
  Vector chi_st;                                  // standard parameters of the model
  std::unique_ptr<DynamicModel> model;            // that the laws may look into
  std::vector<std::unique_ptr<ControlLaw>> laws;  // the same for each log: a law may keep scratch
  Vector J;                                       // design inertias that their gains follow
  std::optional<double> delay;                    // in place of Iv::sampling's [periods]
  SimulationEffort effort;
};

// A gain of the law, by its factor, or the delay, that is estimated beside χ.
struct LoopUnknown {
  Index gain = 0;  // of the law's description(); -1: the delay
  Index joint = 0;
  double prior = 0.0;       // of what is estimated
  double sigma = 0.0;       // its standard deviation beforehand
  bool in_signals = false;  // whether it is a gain in the unit of the control signal
};

// Those of Iv::gain_sigma and delay_sigma; gains that are zero stay it.
//
// throws InputError where the law has no gain of such a name
[[nodiscard]] std::vector<LoopUnknown> loop_unknowns(const Iv& method, const ControlLaw& law);

// The closed loops of all logs, to be simulated with any parameters. Where the problem has its logs
// elsewhere, these are asked.
class ClosedLoops {
 public:
  // throws InputError where a log lacks what its loop follows
  explicit ClosedLoops(const EstimationProblem& problem);

  // From now on parameters have these behind χ, in all that follows.
  void estimate_beside(std::vector<LoopUnknown> unknowns) { unknowns_ = std::move(unknowns); }

  // earlier   iterations: their effort bounds that of this one
  // gains_of  loops whose control law is that of these as well; nullptr: the law follows chi
  [[nodiscard]] SimulatedLoops simulated(const Vector& chi, std::span<const IvIteration> earlier,
                                         const SimulatedLoops* gains_of = nullptr) const;
  // The same with several parameters, beside each other; worthwhile() says how many gain from it.
  [[nodiscard]] std::vector<SimulatedLoops> simulated(std::span<const Vector> chis,
                                                      std::span<const IvIteration> earlier,
                                                      const SimulatedLoops* gains_of = nullptr) const;

  // The loops of a request for rows.
  [[nodiscard]] SimulatedLoops simulated(const LoopRequest& request) const;
  // The loops of logs that are elsewhere, and their rows.
  //
  // simulated_signs  whether W takes its columns of dry friction from the simulated motion
  [[nodiscard]] SimulatedLoops asked(const Vector& chi, std::span<const IvIteration> earlier,
                                     bool simulated_signs) const;
  // The rows of these once more, with other columns.
  [[nodiscard]] LoopFactors asked_again(const SimulatedLoops& loops, bool simulated_signs) const;

  [[nodiscard]] Index worthwhile() const;

  // Of simulated loops; the control signals cost a pass of their own.
  [[nodiscard]] LoopSums sums(const SimulatedLoops& loops) const;
  [[nodiscard]] LoopSums sums_with_control(const SimulatedLoops& loops) const;

  // The parameters that are simulated in place of `chi`: its own where the friction of all joints brakes and
  // no signal comes before its measurement.
  [[nodiscard]] Vector feasible(const Vector& chi) const;

 private:
  // Wall-clock time that all simulations of an estimation may take together, and what is left of it.
  [[nodiscard]] double most_seconds() const;
  [[nodiscard]] double seconds_left() const;
  [[nodiscard]] Vector braking(const Vector& chi) const;
  [[nodiscard]] SimulatedLoops prepared(const Vector& chi, const SimulatedLoops* gains_of) const;
  void simulate(std::span<SimulatedLoops> all, Index steps_before) const;
  void run_out_of_time(std::size_t log, SimulatedLoops& out) const;
  void take(std::span<Simulation> simulations, SimulatedLoops& out) const;

  const EstimationProblem& problem_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  std::vector<std::unique_ptr<AuxiliaryLoop>> loops_;
  std::vector<LoopUnknown> unknowns_;
  Vector mean_speed_;  // |q̇| of the measured motions
  Vector mean_square_;
};

// Parameters of which one is changed by its step, for differences: the parameters `first` … `first` + `count`
// − 1 one by one.
[[nodiscard]] std::vector<Vector> changed_one_by_one(const Vector& chi, const Vector& steps, Index first,
                                                     Index count);

void add(SimulationEffort& to, const SimulationEffort& effort);

// ‖a − b‖ / ‖b‖ of positions, velocities and accelerations; not a number where there was no motion.
//
// difference, whole  sums of squares of a − b and of b, (n × 3)
[[nodiscard]] MotionError motion_error(const Matrix& difference, const Matrix& whole);

// How well the assumed controller explains the logs.
//
// sums  of the loops with the estimate, with control signals
[[nodiscard]] LoopDiagnosis diagnosed_loop(const EstimationProblem& problem, const LoopSums& sums);

// Reasons: joints that their friction holds throughout the simulation, which gives no instruments.
//
// sums  of these loops
[[nodiscard]] std::vector<std::string> locked_joints(const EstimationProblem& problem,
                                                     const SimulatedLoops& loops, const LoopSums& sums);

}  // namespace rivid::detail
