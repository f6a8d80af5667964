#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/dynamics_batch.hpp"
#include "simulate/integrator.hpp"
#include "simulate/loop.hpp"
#include "simulate/loop_pack.hpp"

namespace rivid::detail {

// One simulation from its beginning to its end, by itself or beside others in a LoopPack.
class LoopRun {
 public:
  LoopRun(const Robot& robot, const DynamicModel& model, const ControlLaw& law, const Reference& reference,
          const SimulationOptions& options);

  void carry_out();
  // What came of it, once it is over(). motion(): without the reference and what is compared with it.
  [[nodiscard]] Simulation result() &&;
  [[nodiscard]] Simulation motion() &&;

  // The same in parts: start_clock(), and until it is over(), where a period_ended(), begin_period(), then
  // finish_period().
  void start_clock();
  [[nodiscard]] bool over() const { return over_ || next_ >= samples_; }
  void begin_period();
  void finish_period();
  [[nodiscard]] bool period_ended() const { return period_ended_; }
  // In place of finish_period(): the next step, for a LoopPack, which take() has it from where it is valid
  // there. Without a length: not for a pack.
  [[nodiscard]] LoopPackStep step_for_pack();
  void take(const LoopPack& pack, std::size_t lane);

  [[nodiscard]] const LoopOde& ode() const { return ode_; }
  [[nodiscard]] LoopOde& ode() { return ode_; }

 private:
  void reserve();
  void note_clamped(const DynamicModel& model);
  void make_integrator();
  void start();

  template <typename Set>
  void hold(const Matrix& input, Set&& set);
  void restart();
  void advance();
  void begin_motion();
  void end_period();
  void check_budgets();
  bool settle(Index ended);

  [[nodiscard]] double instant(Index sample) const;
  [[nodiscard]] bool due(Index sample) const;
  bool record(double t, const Vector& y);
  bool record_sliding(double t, const Vector& y);
  bool accelerate_waiting();
  void note(double t, const Vector& y);

  void end_early(Outcome outcome, const std::string& why);
  void end_indefinite();
  // Whether it ends since the reference or the control signal is no number, which shows in M and in the
  // velocities only later.
  [[nodiscard]] bool end_at_no_number();
  void end_diverged();
  void finish();
  void add_reference();

  const Robot& robot_;
  const Reference& reference_;
  const SimulationOptions& options_;
  Index n_;
  LoopOde ode_;
  DynamicsBatch batch_;
  SampledController controller_;
  std::unique_ptr<LoopIntegrator> integrator_;
  bool sampled_;
  bool held_inputs_;
  bool in_periods_;
  double period_;
  double begin_;
  Vector y_, at_, yd_, row_;
  double t_ = 0.0;
  double stop_ = 0.0;  // end of the period
  Index periods_ = 0;  // that have ended
  Index samples_ = 0;
  Index next_ = 0;       // sample to be recorded
  Index waiting_ = 0;    // first sample without its acceleration
  Index recording_ = 0;  // evaluations for samples
  bool period_ended_ = true;
  bool late_ = false;     // whether the part of the period behind the delay has begun
  bool moves_ = false;    // whether the motion of the period has begun
  Index attempts_ = 0;    // steps of a LoopPack from here that did not stand
  bool in_pack_ = false;  // whether y_ is the end of a step of a LoopPack
  bool over_ = false;
  std::chrono::steady_clock::time_point began_;
  Simulation out_;
};

// The arguments of simulate().
struct LoopTask {
  const Robot& robot;
  const DynamicModel& model;
  const ControlLaw& law;
  const Reference& reference;
  SimulationOptions options;
};

// simulate() without the reference and what is compared with it, for instruments; several beside each other,
// which no result shows.
[[nodiscard]] std::vector<Simulation> simulated_motions(std::span<const LoopTask> tasks);

}  // namespace rivid::detail
