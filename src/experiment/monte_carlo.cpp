#include "rivid/experiment/monte_carlo.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "rivid/error.hpp"
#include "rivid/experiment/parameter_file.hpp"
#include "rivid/identify/deviation_bound.hpp"

namespace rivid {

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

MonteCarloRow row_of(int run, const MonteCarlo::Trial& trial, const SimulationRecord& record) {
  MonteCarloRow out = {.run = run, .label = trial.label, .status = "not_simulated"};
  const Index b = record.base.size();
  out.value = out.sigma = Vector::Constant(b, not_a_number);
  if (record.simulation.outcome != Outcome::completed) {
    return out;
  }
  const auto begin = std::chrono::steady_clock::now();
  try {
    const Identification found = identify_logs(trial.experiment, std::span(&record.log, 1));
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
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
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

// The deviations that nothing can beat by much, (b), see MonteCarloParameter::rmse_over_bound.
Vector bound_of(const MonteCarlo& plan) {
  Experiment quiet = plan.experiment;
  const Vector sigma = deviations_of_torque(quiet.simulation->noise, quiet.robot.size());
  const BaseParameters base = base_parameters(quiet.robot);
  if (!(sigma.minCoeff() > 0.0)) {
    return Vector::Constant(base.size(), not_a_number);
  }
  quiet.simulation->noise = {};
  const SimulationRecord record = run_simulation(quiet);
  return deviation_bound(quiet.robot, record.log, sigma);
}

Vector truth_of(const MonteCarlo& plan, const BaseParameters& base) {
  const SimulationPlan& simulation = *plan.experiment.simulation;
  return base.from_standard(simulation.parameters.empty() ? plan.experiment.robot.chi_st()
                                                          : read_parameters(simulation.parameters, base));
}

// Sums over the identified runs of a trial.
MonteCarloParameter parameter_of(const BaseParameter& p, double truth, double bound, Index i,
                                 const std::vector<const MonteCarloRow*>& rows) {
  MonteCarloParameter out = {.name = p.name, .unit = p.unit, .truth = truth};
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
  return out;
}

}  // namespace

std::vector<MonteCarloRow> monte_carlo_run(const MonteCarlo& plan, int run) {
  Experiment experiment = plan.experiment;
  experiment.simulation->noise.seed = plan.seed + static_cast<std::uint64_t>(run);
  const SimulationRecord record = run_simulation(experiment);
  std::vector<MonteCarloRow> out;
  for (const MonteCarlo::Trial& trial : plan.trials) {
    out.push_back(row_of(run, trial, record));
  }
  return out;
}

std::vector<MonteCarloSummary> summaries(const MonteCarlo& plan, std::span<const MonteCarloRow> rows) {
  const BaseParameters base = base_parameters(plan.experiment.robot);
  const Vector truth = truth_of(plan, base);
  const Vector bound = bound_of(plan);
  std::vector<MonteCarloSummary> out;
  for (const MonteCarlo::Trial& trial : plan.trials) {
    MonteCarloSummary& summary = out.emplace_back();
    summary.label = trial.label;
    std::vector<const MonteCarloRow*> identified;
    for (const MonteCarloRow& row : rows) {
      if (row.label == trial.label) {
        ++summary.runs;
        if (row.status == name(Status::identified)) {
          identified.push_back(&row);
        }
      }
    }
    // Sums of floating-point numbers depend on their order.
    std::ranges::sort(identified, {}, &MonteCarloRow::run);
    summary.identified = static_cast<int>(identified.size());
    for (const MonteCarloRow* row : identified) {
      summary.mean_iterations +=
          static_cast<double>(row->iterations) / static_cast<double>(identified.size());
    }
    for (Index i = 0; i < base.size(); ++i) {
      summary.parameters.push_back(
          parameter_of(base.parameters[static_cast<std::size_t>(i)], truth[i], bound[i], i, identified));
    }
  }
  return out;
}

}  // namespace rivid
