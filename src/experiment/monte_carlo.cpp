#include "rivid/experiment/monte_carlo.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <ctime>
#include <deque>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>

#include "experiment/from_program.hpp"
#include "normal_quantile.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/identify/covariance.hpp"
#include "simulate/simulation_group.hpp"
#include "threads.hpp"

namespace rivid {

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// Of the processor, in this thread: by the clock on the wall a run waits for those that it is simulated with.
double thread_seconds() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// The method alone is studied: what judging would say of each of many runs costs more than they do.
Identification identified(Experiment experiment, std::span<const Log> logs) {
  Reading reading;
  detail::take_gains(experiment, logs, reading);
  experiment.estimation.judge = false;
  return identify_logs(experiment, logs);
}

MonteCarloRow row_of(int run, const MonteCarlo::Trial& trial, const SimulationRecord& record) {
  MonteCarloRow out = {.run = run, .label = trial.label, .status = "not_simulated"};
  const Index b = record.base.size();
  out.value = out.sigma = Vector::Constant(b, not_a_number);
  if (record.simulation.outcome != Outcome::completed) {
    return out;
  }
  const double begin = thread_seconds();
  try {
    const Identification found = identified(trial.experiment, std::span(&record.log, 1));
    out.status = name(found.status);
    out.iterations = found.iv ? static_cast<int>(found.iv->iterations.size()) - 1 : 0;
    out.quantile = found.covariance.quantile_975;
    for (Index i = 0; i < b; ++i) {
      const ParameterEstimate& p = found.parameters[static_cast<std::size_t>(i)];
      out.value[i] = p.value;
      out.sigma[i] = p.sigma;
    }
  } catch (const InputError&) {
    out.status = "refused";
  }
  out.seconds = thread_seconds() - begin;
  return out;
}

Vector deviations_of_torque(const NoiseOptions& noise, Index n) {
  Vector out = Vector::Zero(n);
  for (const Vector* part : {&noise.disturbance, &noise.torque}) {
    if (part->size() > 0) {
      out += part->cwiseAbs2();
    }
  }
  return out.cwiseSqrt();
}

const SimulationPlan& simulation_of(const MonteCarlo& plan) {
  if (!plan.experiment.simulation) {
    throw InputError("Monte Carlo: the experiment must have [simulation]");
  }
  return *plan.experiment.simulation;
}

// The experiment that is simulated, with other noise.
Experiment experiment_with(const MonteCarlo& plan, const NoiseOptions& noise) {
  SimulationPlan simulation = simulation_of(plan);
  simulation.noise = noise;
  Experiment out = plan.experiment;
  out.simulation = std::move(simulation);
  return out;
}

// The deviations that nothing can beat by much, (b), see MonteCarloParameter::rmse_over_bound.
Vector bound_of(const MonteCarlo& plan) {
  const Robot& robot = plan.experiment.robot;
  const Vector sigma = deviations_of_torque(simulation_of(plan).noise, robot.size());
  if (!(sigma.minCoeff() > 0.0)) {
    return Vector::Constant(base_parameters(robot).size(), not_a_number);
  }
  Experiment without_noise = experiment_with(plan, {});
  if (without_noise.control) {
    without_noise.control->sampling.quantum = {};  // what rounding adds to accelerations is no excitation
  }
  const SimulationRecord record = run_simulation(without_noise);
  return deviation_bound(robot, record.log, sigma);
}

Vector truth_of(const MonteCarlo& plan, const BaseParameters& base) {
  const SimulationPlan& simulation = simulation_of(plan);
  return base.from_standard(simulation.parameters.empty() ? plan.experiment.robot.chi_st()
                                                          : read_parameters(simulation.parameters, base));
}

// Interval for a share of `runs` that was found, Wilson (1927): it stays within 0 and 1, where the usual one
// does not.
std::array<double, 2> interval_of_share(double share, double runs) {
  constexpr double z = detail::normal_quantile_975;  // of a 95 % interval
  const double scale = 1.0 + z * z / runs;
  const double middle = (share + 0.5 * z * z / runs) / scale;
  const double half = z / scale * std::sqrt(share * (1.0 - share) / runs + 0.25 * z * z / (runs * runs));
  return {std::max(middle - half, 0.0), std::min(middle + half, 1.0)};
}

// Sums over the identified runs of a trial.
MonteCarloParameter parameter_of(const BaseParameter& p, double truth, double bound, Index i,
                                 const std::vector<const MonteCarloRow*>& rows) {
  MonteCarloParameter out = {.name = p.name, .unit = p.unit, .truth = truth};
  if (rows.empty()) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    out.bias = out.rmse = out.spread = out.bias_in_spreads = out.rmse_over_bound = out.sigma_over_spread =
        unknown;
    out.coverage = unknown;
    out.bias_in_spreads_95 = out.rmse_over_bound_95 = out.coverage_95 = {unknown, unknown};
    return out;
  }
  const auto runs = static_cast<double>(rows.size());
  double squares = 0.0;
  double sigmas = 0.0;
  for (const MonteCarloRow* row : rows) {
    const double error = row->value[i] - truth;
    out.bias += error / runs;
    squares += error * error / runs;
    sigmas += row->sigma[i] / runs;
    out.coverage += std::abs(error) <= row->quantile * row->sigma[i] ? 1.0 / runs : 0.0;
  }
  out.rmse = std::sqrt(squares);
  out.spread = std::sqrt(std::max(squares - out.bias * out.bias, 0.0) * runs / std::max(runs - 1.0, 1.0));
  out.bias_in_spreads = out.bias / out.spread;
  out.rmse_over_bound = out.rmse / bound;
  out.sigma_over_spread = sigmas / out.spread;
  const double bias_half = detail::normal_quantile_975 / std::sqrt(runs);
  out.bias_in_spreads_95 = {out.bias_in_spreads - bias_half, out.bias_in_spreads + bias_half};
  const double rmse_half = detail::normal_quantile_975 / std::sqrt(2.0 * runs) * out.rmse_over_bound;
  out.rmse_over_bound_95 = {out.rmse_over_bound - rmse_half, out.rmse_over_bound + rmse_half};
  out.coverage_95 = interval_of_share(out.coverage, runs);
  return out;
}

MonteCarloVerdict verdict_of(const MonteCarloSummary& summary) {
  using V = MonteCarloVerdict;
  V out;
  if (summary.identified < 2) {
    return out;
  }
  // The mean over the parameters is at least as well known as the share of one.
  const auto [low, high] = interval_of_share(summary.mean_coverage, static_cast<double>(summary.identified));
  out.unbiased = true;
  out.honest = high >= V::mean_coverage[0] && low <= V::mean_coverage[1];
  for (const MonteCarloParameter& p : summary.parameters) {
    out.unbiased = out.unbiased && p.bias_in_spreads_95[0] <= V::largest_bias &&
                   p.bias_in_spreads_95[1] >= -V::largest_bias;
    out.honest = out.honest && p.coverage_95[1] >= V::least_coverage;
    if (std::isfinite(p.rmse_over_bound)) {
      out.efficient = out.efficient.value_or(true) && p.rmse_over_bound_95[0] <= V::largest_rmse;
    }
  }
  return out;
}

// The summary of one trial.
MonteCarloSummary summary_of(const std::string& label, const BaseParameters& base, const Vector& truth,
                             const Vector& bound, std::span<const MonteCarloRow> rows) {
  MonteCarloSummary out;
  out.label = label;
  std::vector<const MonteCarloRow*> identified;
  for (const MonteCarloRow& row : rows) {
    if (row.label == label) {
      ++out.runs;
      ++out.outcomes[row.status];
      if (row.status == name(Status::identified)) {
        identified.push_back(&row);
      }
    }
  }
  // Sums of floating-point numbers depend on their order.
  std::ranges::sort(identified, {}, &MonteCarloRow::run);
  out.identified = static_cast<int>(identified.size());
  const auto runs = static_cast<double>(identified.size());
  int iterations = 0;
  for (const MonteCarloRow* row : identified) {
    iterations += row->iterations;
    out.most_iterations = std::max(out.most_iterations, row->iterations);
    out.mean_seconds += row->seconds / runs;
  }
  out.mean_iterations = identified.empty() ? 0.0 : static_cast<double>(iterations) / runs;
  for (Index i = 0; i < base.size(); ++i) {
    const MonteCarloParameter& p = out.parameters.emplace_back(
        parameter_of(base.parameters[static_cast<std::size_t>(i)], truth[i], bound[i], i, identified));
    out.mean_coverage += p.coverage / static_cast<double>(base.size());
  }
  out.verdict = verdict_of(out);
  return out;
}

}  // namespace

std::vector<MonteCarloRow> monte_carlo_run(const MonteCarlo& plan, int run) {
  NoiseOptions noise = simulation_of(plan).noise;
  noise.seed = plan.seed + static_cast<std::uint64_t>(run);
  const SimulationRecord record = run_simulation(experiment_with(plan, noise));
  std::vector<MonteCarloRow> out;
  out.reserve(plan.trials.size());
  for (const MonteCarlo::Trial& trial : plan.trials) {
    out.push_back(row_of(run, trial, record));
  }
  return out;
}

void monte_carlo_runs(const MonteCarlo& plan, std::span<const int> runs, int threads,
                      const std::function<void(const std::vector<MonteCarloRow>&)>& done) {
  std::mutex handing_over;
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;
  const auto work = [&](detail::SimulationGroup* group) {
    const detail::SimulationGroup::Member member(*group);
    try {
      for (std::size_t k = next++; k < runs.size(); k = next++) {
        const std::vector<MonteCarloRow> rows = monte_carlo_run(plan, runs[k]);
        const std::scoped_lock lock(handing_over);
        if (failure) {
          return;
        }
        done(rows);
      }
    } catch (...) {
      const std::scoped_lock lock(handing_over);
      failure = std::current_exception();
      next = runs.size();
    }
  };
  // Of each group one thread works at a time.
  const int at_work = detail::useful_threads(threads);
  const int share = (static_cast<int>(runs.size()) + at_work - 1) / at_work;
  const int members = std::clamp(share, 1, detail::SimulationGroup::worthwhile());
  std::deque<detail::SimulationGroup> groups;
  std::vector<std::thread> others;
  for (int k = 0; k < at_work; ++k) {
    detail::SimulationGroup& group = groups.emplace_back(members);
    for (int member = k == 0 ? 1 : 0; member < members; ++member) {
      if (!detail::started(others, work, &group)) {
        group.give_up();
      }
    }
  }
  work(&groups.front());
  for (std::thread& other : others) {
    other.join();
  }
  if (failure) {
    std::rethrow_exception(failure);
  }
}

std::vector<MonteCarloSummary> summaries(const MonteCarlo& plan, std::span<const MonteCarloRow> rows) {
  const BaseParameters base = base_parameters(plan.experiment.robot);
  const Vector truth = truth_of(plan, base);
  const Vector bound = bound_of(plan);
  std::vector<MonteCarloSummary> out;
  out.reserve(plan.trials.size());
  for (const MonteCarlo::Trial& trial : plan.trials) {
    out.push_back(summary_of(trial.label, base, truth, bound, rows));
  }
  return out;
}

}  // namespace rivid
