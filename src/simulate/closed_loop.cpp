#include "rivid/simulate/closed_loop.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>

#include "rivid/error.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/text.hpp"
#include "simulate/loop_run.hpp"
#include "simulate/simulation_group.hpp"

namespace rivid {

namespace {

void check_sizes(const Robot& robot, const DynamicModel& model, const Reference& reference,
                 const SimulationOptions& options) {
  const Index n = robot.size();
  if (model.size() != n || reference.joints() != n) {
    throw InputError("simulate: the robot has " + counted(n, "joint") + ", its model " +
                     std::to_string(model.size()) + ", the reference " + std::to_string(reference.joints()));
  }
  const double duration = reference.duration();
  if (!std::isfinite(reference.begin()) || !std::isfinite(duration) || duration < 0.0) {
    throw InputError("simulate: the reference begins at " + number(reference.begin()) + " s and lasts " +
                     number(duration) + " s; both must be finite, and the second not negative");
  }
  if (const auto fault = options.complaint(n, duration)) {
    throw InputError("simulate: " + *fault);
  }
  Vector q_r(n);
  Vector qd_r(n);
  Vector qdd_r(n);
  reference.at(reference.begin(), q_r, qd_r, qdd_r);
  for (Index j = 0; j < n; ++j) {
    if (!std::isfinite(q_r[j]) || !std::isfinite(qd_r[j])) {
      throw InputError("simulate: the reference of joint \"" +
                       robot.joints[static_cast<std::size_t>(j)].name + "\" begins at " + number(q_r[j]) +
                       " with the velocity " + number(qd_r[j]) + ", must be finite");
    }
  }
}

}  // namespace

Simulation simulate(const Robot& robot, const DynamicModel& model, const ControlLaw& law,
                    const Reference& reference, const SimulationOptions& options) {
  check_sizes(robot, model, reference, options);
  detail::LoopRun run(robot, model, law, reference, options);
  detail::SimulationGroup::carry_out(std::array{&run});
  return std::move(run).result();
}

std::vector<Simulation> detail::simulated_motions(std::span<const LoopTask> tasks) {
  // No more than go together: each run has memory of its own.
  const auto together = static_cast<std::size_t>(SimulationGroup::worthwhile());
  std::vector<Simulation> out;
  while (out.size() < tasks.size()) {
    std::deque<LoopRun> runs;
    std::vector<LoopRun*> all;
    for (const LoopTask& task : tasks.subspan(out.size(), std::min(together, tasks.size() - out.size()))) {
      check_sizes(task.robot, task.model, task.reference, task.options);
      all.push_back(&runs.emplace_back(task.robot, task.model, task.law, task.reference, task.options));
    }
    SimulationGroup::carry_out(all);
    for (LoopRun& run : runs) {
      out.push_back(std::move(run).motion());
    }
  }
  return out;
}

Simulation simulate(const Robot& robot, const BaseParameters& base, const Eigen::Ref<const Vector>& chi,
                    const Control& control, const Eigen::Ref<const Vector>& J, const Reference& reference,
                    const SimulationOptions& options) {
  const DynamicModel model(robot, base, chi);
  const std::unique_ptr<ControlLaw> law = detail::law_of(control, {robot, model, J});
  return simulate(robot, model, *law, reference, options);
}

}  // namespace rivid
