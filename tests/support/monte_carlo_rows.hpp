#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "rivid/experiment/monte_carlo.hpp"

namespace rivid::test {

/// The SCARA of data/scara in so many runs, of which rows are made up.
inline MonteCarlo scara_plan(int runs) {
  MonteCarlo out = read_monte_carlo(std::filesystem::path(RIVID_DATA) / "scara" / "montecarlo_s1.toml");
  out.runs = runs;
  return out;
}

/// Takes the torque disturbance away, without which there is no bound for errors.
inline void calm(MonteCarlo& plan) {
  if (plan.experiment.simulation) {
    plan.experiment.simulation->noise.disturbance = {};
  }
}

/// The true base parameters of its [simulation].
inline Vector truth_of(const MonteCarlo& plan) {
  return base_parameters(plan.experiment.robot).from_standard(plan.experiment.robot.chi_st());
}

/// Rows of one trial whose estimates are off by `error` deviations, each of which is 0.01.
///
/// @param error  of a run and a parameter
inline std::vector<MonteCarloRow> rows_with(const MonteCarlo& plan, const std::string& label,
                                            const std::function<double(int run, Index parameter)>& error) {
  constexpr double sigma = 0.01;
  const Vector truth = truth_of(plan);
  std::vector<MonteCarloRow> out;
  for (int run = 0; run < plan.runs; ++run) {
    MonteCarloRow& row = out.emplace_back();
    row.run = run;
    row.label = label;
    row.status = "identified";
    row.iterations = 3 + run % 2;
    row.seconds = 0.25;
    row.quantile = 2.0;
    row.sigma = Vector::Constant(truth.size(), sigma);
    row.value = truth;
    for (Index i = 0; i < truth.size(); ++i) {
      row.value[i] += sigma * error(run, i);
    }
  }
  return out;
}

/// Errors like those of a normal variable of deviation 1 and mean 0: quantiles at equal steps of probability,
/// in an order that differs from parameter to parameter.
inline double normal_error(int run, Index parameter, int runs) {
  const int rank = static_cast<int>((static_cast<long>(run) * 7 + 13 * parameter) % runs);
  const double p = (rank + 0.5) / runs;
  double low = -8.0;
  double high = 8.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace rivid::test
