#pragma once

#include <filesystem>
#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "rivid/experiment/experiment.hpp"

namespace rivid {

/// Many simulated experiments, each identified in several ways, [montecarlo].
struct MonteCarlo {
  /// A way to identify.
  struct Trial {
    std::string label;
    Experiment
        experiment;  ///< [robot] and [simulation] as in the file; [method], [signal], [control] of the trial
  };

  Experiment experiment;  ///< that is simulated
  int runs = 100;
  std::uint64_t seed = 1;  ///< run k, counted from 0, is simulated with seed + k
  std::vector<Trial> trials;
};

/// Reads an experiment file with [robot], [control], [reference], [simulation] and [montecarlo].
///
/// @throws InputError  as read_experiment() does
[[nodiscard]] MonteCarlo read_monte_carlo(const std::filesystem::path& path);

/// What one trial made of one run.
struct MonteCarloRow {
  int run = 0;
  std::string label;   ///< of the trial
  std::string status;  ///< name of Status; "not_simulated" or "refused" where it did not come to an estimate
  int iterations = 0;  ///< of IDIM-IV
  double seconds = 0.0;   ///< of the identification
  double quantile = 0.0;  ///< half width of the 95 % intervals in deviations
  Vector value = {};      ///< (b)
  Vector sigma = {};      ///< (b)
};

/// Simulates run k and identifies it in all ways: the same rows, save their times, whatever ran before and on whatever
/// thread.
///
/// @throws InputError  where the experiment can not be simulated at all
[[nodiscard]] std::vector<MonteCarloRow> monte_carlo_run(const MonteCarlo& plan, int run);

/// What all runs say of one parameter.
struct MonteCarloParameter {
  std::string name;
  std::string unit;
  double truth = 0.0;
  double bias = 0.0;    ///< mean error
  double spread = 0.0;  ///< standard deviation of the estimates
  double rmse = 0.0;    ///< root mean square error
  double bias_in_spreads = 0.0;
  /// rmse over the deviation that weighted least squares would have from regressors without noise, (Σ_j W_jᵀ W_j / σ_j²)⁻¹
  /// over all moving samples, σ_j being that of disturbance and torque noise; not a number without either.
  double rmse_over_bound = 0.0;
  double sigma_over_spread = 0.0;  ///< mean reported deviation over `spread`
  double coverage = 0.0;           ///< share of 95 % intervals that hold the truth
};

struct MonteCarloSummary {
  std::string label;
  int runs = 0;
  int identified = 0;  ///< the figures are of these
  double mean_iterations = 0.0;
  std::vector<MonteCarloParameter> parameters;
};

/// Summaries of all trials, in the order of the plan.
///
/// @param rows  in any order
[[nodiscard]] std::vector<MonteCarloSummary> summaries(const MonteCarlo& plan,
                                                       std::span<const MonteCarloRow> rows);

/// Rows as lines of a CSV file; numbers are written so that they read back bit by bit.
[[nodiscard]] std::string csv_header(const MonteCarlo& plan);
[[nodiscard]] std::string to_csv(const MonteCarloRow& row);

/// Rows of such a file. A last line without an end, where a program was stopped, is passed over.
///
/// @throws InputError  for any other fault: the message names file and line
[[nodiscard]] std::vector<MonteCarloRow> read_monte_carlo_rows(const std::filesystem::path& path,
                                                               const MonteCarlo& plan);

/// Summaries as a table for people, and as JSON.
std::ostream& operator<<(std::ostream& out, std::span<const MonteCarloSummary> summaries);
[[nodiscard]] std::string to_json(std::span<const MonteCarloSummary> summaries);

}  // namespace rivid
