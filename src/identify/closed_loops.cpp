#include "identify/closed_loops.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "identify/dissipative.hpp"
#include "rivid/error.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid::detail {

namespace {

// Steps that the integrator may take with one iterate: so many times the most that an earlier one took, and so many a
// sample. Near a mass matrix that is not positive definite there is no end to them.
constexpr Index most_times_the_steps = 20;
constexpr Index most_steps_a_sample = 10;

Index step_budget(Index samples, std::span<const IvIteration> earlier) {
  Index most = 0;
  for (const IvIteration& iteration : earlier) {
    most = std::max(most, iteration.effort.steps);
  }
  return most > 0 ? most_times_the_steps * most + most_steps_a_sample * samples
                  : std::numeric_limits<Index>::max();
}

void add(SimulationEffort& to, const SimulationEffort& effort) {
  to.steps += effort.steps;
  to.right_hand_sides += effort.right_hand_sides;
  to.restarts += effort.restarts;
  to.mode_changes += effort.mode_changes;
  to.seconds += effort.seconds;
}

}  // namespace

ClosedLoops::ClosedLoops(const IvProblem& problem)
    : problem_(problem),
      mean_speed_(Vector::Zero(problem.joints())),
      mean_square_(Vector::Zero(problem.joints())) {
  for (const Log& log : problem.logs) {
    loops_.push_back(
        std::make_unique<AuxiliaryLoop>(problem.robot, log, problem.estimation.signal, problem.method));
  }
  for (const auto& loop : loops_) {
    const auto share = 1.0 / static_cast<double>(loops_.size());
    mean_speed_ += share * loop->measured().qd.cwiseAbs().colwise().mean().transpose();
    mean_square_ += share * loop->measured().qd.cwiseAbs2().colwise().mean().transpose();
  }
}

SimulatedLoops ClosedLoops::simulated(const Vector& chi, std::span<const IvIteration> earlier) const {
  const Iv& method = problem_.method;
  SimulatedLoops out;
  try {
    Vector chi_st = problem_.base.to_standard(chi);
    make_dissipative(problem_.base, mean_speed_, mean_square_, chi_st);
    out.model = std::make_unique<DynamicModel>(problem_.robot, chi_st);
    for (const auto& loop : loops_) {
      const Vector J = design_inertia(*out.model, loop->measured().q);
      out.J = out.J.size() == 0 ? J : out.J.cwiseMax(J);
    }
    for (std::size_t k = 0; k < loops_.size(); ++k) {
      const Log& log = problem_.logs[k];
      // A law is made anew for each simulation: it may keep scratch.
      out.law = method.control({problem_.robot, *out.model, out.J});
      Simulation simulation = loops_[k]->simulate(*out.model, *out.law, step_budget(log.samples(), earlier));
      add(out.effort, simulation.effort);
      if (simulation.outcome != Outcome::completed) {
        out.failure = log.source + ": " + simulation.reason;
        return out;
      }
      out.motions.push_back(std::move(simulation.motion));
      if (problem_.estimation.progress) {
        problem_.estimation.progress("iteration " + std::to_string(earlier.size()),
                                     static_cast<double>(k + 1) / static_cast<double>(loops_.size()));
      }
    }
  } catch (const NumericsError& error) {
    out.failure = error.what();
  }
  return out;
}

}  // namespace rivid::detail
