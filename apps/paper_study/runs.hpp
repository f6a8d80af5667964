#pragma once

#include <functional>
#include <string>
#include <vector>

#include "paper_study/scara.hpp"

namespace rivid::study {

/// Identifications of logs that differ in their noise.
using Runs = std::vector<Identification>;

/// Estimates in the units of the paper.
[[nodiscard]] double value(const Identification& found, std::size_t i);
[[nodiscard]] double sigma(const Identification& found, std::size_t i);
/// |χ̂_i / χ_i − 1|.
[[nodiscard]] double off(const Identification& found, std::size_t i);
/// Of a method that iterates.
[[nodiscard]] const IvHistory& history(const Identification& found);
[[nodiscard]] std::size_t iterations(const Identification& found);
[[nodiscard]] bool identified(const Identification& found);

[[nodiscard]] double mean(const Runs& runs, const std::function<double(const Identification&)>& of);
/// Root of the mean square of χ̂_i / χ_i − 1.
[[nodiscard]] double rms_off(const Runs& runs, std::size_t i);
[[nodiscard]] Runs only_identified(const Runs& runs);

/// Estimates beside a table of the paper, as means over the runs that were identified.
[[nodiscard]] std::string beside(const std::string& title, const PaperTable& paper, const Runs& all);
/// How the runs ended, and for each way the reasons of the first run that ended so.
[[nodiscard]] std::string outcomes(const std::string& title, const Runs& runs);
/// Errors of the simulated motion of the last iteration, as figs 8, 9, 12 and 13 end.
[[nodiscard]] std::string motion_errors(const std::string& title, const Runs& all);

}  // namespace rivid::study
