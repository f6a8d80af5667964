#pragma once

#include <iosfwd>
#include <span>
#include <string>

#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/report/provenance.hpp"

namespace rivid {

/// Summaries as a table for people.
std::ostream& operator<<(std::ostream& out, std::span<const MonteCarloSummary> summaries);

/// Summaries as JSON, the content of summary.json. It holds no times, so that the same runs give the same file.
[[nodiscard]] std::string to_json(std::span<const MonteCarloSummary> summaries);

/// Summaries as one HTML page to look at, the content of report.html of rivid_montecarlo; docs/statistics.md tells what it
/// shows. Like html_report() of an identification it loads nothing and follows the browser's choice of light or dark. It
/// needs no script. The same runs give the same page.
///
/// @param rows  in any order
[[nodiscard]] std::string html_report(const MonteCarlo& plan, std::span<const MonteCarloSummary> summaries,
                                      std::span<const MonteCarloRow> rows, const Provenance& provenance);

}  // namespace rivid
