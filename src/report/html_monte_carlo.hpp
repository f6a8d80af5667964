#pragma once

#include <span>
#include <string>
#include <vector>

#include "rivid/experiment/monte_carlo.hpp"

// Plots of the Monte Carlo page, as markup.
namespace rivid::detail {

// Errors of the identified runs of one trial in their standard deviations, (estimate − truth) / σ: one list a parameter.
[[nodiscard]] std::vector<std::vector<double>> standardised_errors(const MonteCarloSummary& summary,
                                                                   std::span<const MonteCarloRow> rows);

// One row a parameter: a dot with its 95 % interval, and what it should be.
[[nodiscard]] std::string bias_plot(const MonteCarloSummary& summary);
[[nodiscard]] std::string coverage_plot(const MonteCarloSummary& summary);
[[nodiscard]] std::string rmse_plot(const MonteCarloSummary& summary);

// All errors together beside the standard normal distribution.
[[nodiscard]] std::string error_histogram(const std::vector<std::vector<double>>& errors);
// Their quantiles over those of the normal distribution, a line for each parameter and one for all.
[[nodiscard]] std::string quantile_plot(const std::vector<std::vector<double>>& errors);

}  // namespace rivid::detail
