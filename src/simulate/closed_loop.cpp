#include "rivid/simulate/closed_loop.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>

#include "accept.hpp"
#include "rivid/error.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/text.hpp"
#include "simulate/loop_run.hpp"
#include "simulate/simulation_group.hpp"

namespace rivid {

namespace {

std::optional<std::string> wrong_size(std::string_view what, Index got, Index n) {
  if (got == 0 || got == n) {
    return std::nullopt;
  }
  return std::string(what) + " has " + counted(got, "value") + ", must have one for each of " +
         counted(n, "joint");
}

std::optional<std::string> not_finite(std::string_view what, const Eigen::Ref<const Matrix>& values,
                                      Index n) {
  if (values.size() == 0) {
    return std::nullopt;
  }
  if (values.cols() != n) {
    return std::string(what) + " has " + counted(values.cols(), "column") + ", must have one for each of " +
           counted(n, "joint");
  }
  for (Index j = 0; j < values.cols(); ++j) {
    for (Index k = 0; k < values.rows(); ++k) {
      if (!std::isfinite(values(k, j))) {
        return std::string(what) + "(" + std::to_string(k) + ", " + std::to_string(j) + ") is " +
               number(values(k, j)) + ", must be finite";
      }
    }
  }
  return std::nullopt;
}

std::optional<std::string> outside(std::string_view what, double value, bool good,
                                   std::string_view required) {
  if (good) {
    return std::nullopt;
  }
  return std::string(what) + " is " + number(value) + ", must be " + std::string(required);
}

// More are a mistake of units, and would not fit into the memory.
constexpr double most_samples = 1e8;
constexpr int most_delay = 1'000'000;  // [periods]

bool positive(double value) { return std::isfinite(value) && value > 0; }
bool not_negative(double value) { return std::isfinite(value) && value >= 0; }

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
  detail::accept("simulate", options.complaint(n, duration));
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

std::vector<double> detail::backward_difference() noexcept { return {1.0, -1.0}; }

std::optional<std::string> Sampling::complaint(Index n) const {
  if (auto fault = outside("sampling.period", period, not_negative(period), "0 or positive [s]")) {
    return fault;
  }
  if (auto fault = outside("sampling.delay", delay, delay >= 0 && delay <= most_delay,
                           "between 0 and 1000000 periods")) {
    return fault;
  }
  for (const double weight : velocity_filter) {
    if (auto fault =
            outside("an entry of sampling.velocity_filter", weight, std::isfinite(weight), "finite")) {
      return fault;
    }
  }
  if (auto fault = wrong_size("sampling.quantum", quantum.size(), n)) {
    return fault;
  }
  for (const double q : quantum) {
    if (auto fault = outside("an entry of sampling.quantum", q, not_negative(q), "0 or positive")) {
      return fault;
    }
  }
  for (const auto& [what, given] :
       {std::pair("position_noise", position_noise.size() > 0), std::pair("quantum", quantum.size() > 0),
        std::pair("delay", delay > 0), std::pair("reference_lead", reference_lead != 0)}) {
    if (period == 0.0 && given) {
      return "sampling." + std::string(what) +
             " needs a sampling.period: a continuous law sees the true motion at once";
    }
  }
  return not_finite("sampling.position_noise", position_noise, n);
}

std::optional<std::string> SimulationOptions::complaint(Index n, double duration) const {
  for (const auto& fault :
       {outside("f_m", f_m, positive(f_m), "positive [Hz]"),
        outside("samples", static_cast<double>(samples), samples >= 0, "0 or more"),
        wrong_size("q_0", q_0.size(), n), wrong_size("qd_0", qd_0.size(), n), sampling.complaint(n),
        not_finite("added_control", added_control, n), not_finite("disturbance", disturbance, n),
        outside("smooth_velocity", smooth_velocity, positive(smooth_velocity), "positive"),
        outside("rtol", rtol, positive(rtol) && rtol < 1, "between 0 and 1"),
        outside("atol", atol, positive(atol), "positive"),
        outside("max_step", max_step, not_negative(max_step), "0 or positive [s]"),
        outside("max_steps", static_cast<double>(max_steps), max_steps > 0, "positive"),
        outside("max_seconds", max_seconds, positive(max_seconds), "positive [s]"),
        outside("max_velocity", max_velocity, positive(max_velocity), "positive")}) {
    if (fault) {
      return fault;
    }
  }
  if ((q_0.size() > 0 && !q_0.allFinite()) || (qd_0.size() > 0 && !qd_0.allFinite())) {
    return "q_0 and qd_0 must be finite";
  }
  if (!is_value(integrator) || !is_value(friction)) {
    return "integrator or friction is none of the values of its enum";
  }
  // Each tick costs a call of the law; more of them are a mistake of units.
  constexpr double most_ticks = 5e6;
  const double length = samples > 0 ? static_cast<double>(samples - 1) / f_m : duration;
  if (length * f_m > most_samples) {
    return "the motion has " + number(length * f_m, 3) + " samples, " + number(length, 4) +
           " s at f_m = " + number(f_m) + " Hz; at most " + number(most_samples) + " are simulated";
  }
  if (sampling.period > 0.0 && length / sampling.period > most_ticks) {
    return "sampling.period is " + number(sampling.period) + " s, " + number(length / sampling.period, 3) +
           " ticks of the controller in " + number(length, 4) + " s; at most " + number(most_ticks) +
           " are simulated: lower the rate of the control [Hz] or shorten the motion";
  }
  if (friction == DryFrictionScheme::held && integrator != Integrator::rk4) {
    return "friction is held, which is a scheme of integrator rk4 alone";
  }
  if (friction == DryFrictionScheme::exact && integrator == Integrator::rk4) {
    return "integrator rk4 knows no events; friction must be smooth or held";
  }
  return std::nullopt;
}

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
