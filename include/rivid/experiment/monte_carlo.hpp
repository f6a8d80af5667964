#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "rivid/fields.hpp"

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
  std::vector<std::string> settings;  ///< of the command line, which were laid over the file

  template <typename M = MonteCarlo>
  static constexpr auto fields() {
    return std::tuple(
        Field{"runs", &M::runs, "how often the experiment is simulated", {.range = Range::from(1, 1e6)}},
        Field{"seed", &M::seed, "run k, counted from 0, is simulated with seed + k", {.range = seed_range}},
        Field{"trial",
              Key<std::vector<Trial>>(),
              "ways to identify, one `[[montecarlo.trial]]` each",
              {.otherwise = "–"}});
  }
};

/// Reads an experiment file with [robot], [control], [reference], [simulation] and [montecarlo].
///
/// @param settings  as for read_experiment()
/// @throws InputError  as read_experiment() does
[[nodiscard]] MonteCarlo read_monte_carlo(const std::filesystem::path& path,
                                          std::span<const std::string> settings = {});

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

/// Simulates run k and identifies it in all ways: the same rows, save their times, whatever ran before and on
/// whatever thread.
///
/// @throws InputError  where the experiment can not be simulated at all
[[nodiscard]] std::vector<MonteCarloRow> monte_carlo_run(const MonteCarlo& plan, int run);

/// Makes runs on several threads and hands over the rows of each as soon as they are there, one run at a time
/// and in any order.
///
/// @param runs     their numbers
/// @param threads  at least 1
/// @throws         what a run or `done` throws, after the runs that were begun
void monte_carlo_runs(const MonteCarlo& plan, std::span<const int> runs, int threads,
                      const std::function<void(const std::vector<MonteCarloRow>&)>& done);

/// What all runs say of one parameter.
struct MonteCarloParameter {
  std::string name;
  std::string unit;
  double truth = 0.0;
  double bias = 0.0;    ///< mean error
  double spread = 0.0;  ///< standard deviation of the estimates
  double rmse = 0.0;    ///< root mean square error
  double bias_in_spreads = 0.0;
  /// rmse over the deviation that weighted least squares would have from regressors without noise, (Σ_j W_jᵀ
  /// W_j / σ_j²)⁻¹ over all moving samples, σ_j being that of disturbance and torque noise; not a number
  /// without either.
  double rmse_over_bound = 0.0;
  double sigma_over_spread = 0.0;  ///< mean reported deviation over `spread`
  double coverage = 0.0;           ///< share of 95 % intervals that hold the truth
  /// What these figures may be with more runs, their 95 % intervals: that of the share by Wilson (1927),
  /// those of bias and error as of normal errors.
  std::array<double, 2> bias_in_spreads_95 = {};
  std::array<double, 2> rmse_over_bound_95 = {};
  std::array<double, 2> coverage_95 = {};

  template <typename R = MonteCarloParameter>
  static constexpr auto fields() {
    return std::tuple(
        Field{"name", &R::name, "of the parameter"}, Field{"unit", &R::unit, "SI, joint side"},
        Field{"truth", &R::truth, "that was simulated"}, Field{"bias", &R::bias, "mean error"},
        Field{"spread", &R::spread, "standard deviation of the estimates"},
        Field{"rmse", &R::rmse, "root mean square error"},
        Field{"bias_in_spreads", &R::bias_in_spreads, "bias over spread"},
        Field{"rmse_over_bound", &R::rmse_over_bound,
              "rmse over the deviation that nothing can beat by much"},
        Field{"sigma_over_spread", &R::sigma_over_spread, "mean reported deviation over spread"},
        Field{"coverage", &R::coverage, "share of 95 % intervals that hold the truth"},
        Field{"bias_in_spreads_95", &R::bias_in_spreads_95, "its 95 % interval"},
        Field{"rmse_over_bound_95", &R::rmse_over_bound_95, "its 95 % interval"},
        Field{"coverage_95", &R::coverage_95, "its 95 % interval"});
  }
};

/// What the figures of a trial amount to. A figure speaks against it where all of its 95 % interval is beyond
/// what is wanted, so that chance alone hardly does.
struct MonteCarloVerdict {
  static constexpr double largest_bias = 0.2;                           ///< in deviations of the estimate
  static constexpr std::array<double, 2> mean_coverage = {0.93, 0.97};  // about 0.95; a choice
  static constexpr double least_coverage = 0.9;                         // of each parameter; a choice
  static constexpr double largest_rmse = 1.35;                          ///< over the bound

  bool unbiased = false;  ///< no bias above largest_bias
  bool honest = false;    ///< coverage within mean_coverage on average, and least_coverage or more for each
  std::optional<bool> efficient;  ///< no error above largest_rmse; nothing where there is no bound

  template <typename R = MonteCarloVerdict>
  static constexpr auto fields() {
    return std::tuple(
        Field{"unbiased", &R::unbiased, "no bias above 0.2 spreads"},
        Field{"honest", &R::honest, "coverage as promised"},
        Field{"efficient", &R::efficient, "no error far above the bound; null where there is none"});
  }
};

struct MonteCarloSummary {
  std::string label;
  int runs = 0;
  int identified = 0;                   ///< the figures are of these
  std::map<std::string, int> outcomes;  ///< runs by their status
  double mean_iterations = 0.0;
  int most_iterations = 0;
  double mean_seconds = 0.0;  ///< of the identification; not the same each time
  double mean_coverage = 0.0;
  MonteCarloVerdict verdict;
  std::vector<MonteCarloParameter> parameters;

  template <typename R = MonteCarloSummary>
  static constexpr auto fields() {
    return std::tuple(Field{"label", &R::label, "of the trial"}, Field{"runs", &R::runs, "that were made"},
                      Field{"identified", &R::identified, "of these; the figures are of them"},
                      Field{"outcomes", &R::outcomes, "runs by their status"},
                      Field{"mean_iterations", &R::mean_iterations, "of IDIM-IV", {.unit = "1"}},
                      Field{"most_iterations", &R::most_iterations, "of IDIM-IV"},
                      Field{"mean_coverage", &R::mean_coverage, "over the parameters", {.unit = "1"}},
                      Field{"verdict", &R::verdict, "what the figures amount to"},
                      Field{"parameters", &R::parameters, "one a base parameter"});
  }
};

/// Summaries of all trials, in the order of the plan.
///
/// @param rows  in any order
[[nodiscard]] std::vector<MonteCarloSummary> summaries(const MonteCarlo& plan,
                                                       std::span<const MonteCarloRow> rows);

}  // namespace rivid
