#pragma once

#include <span>
#include <string>
#include <vector>

#include "rivid/finding.hpp"
#include "rivid/identify/comparison.hpp"
#include "rivid/report/json.hpp"

namespace rivid {

/// What changed from one result to another one of the same robot.
struct ResultChanges {
  std::string a;  ///< names of the two, as in Comparison::models
  std::string b;
  std::vector<ParameterChange> parameters;  ///< of parameter_changes()
};

/// A comparison for the screen: errors by model and joint, which model predicts better with p, what changed
/// between results.
///
/// @param warnings  why the figures may be no judgement: errors of the logs, models that are worse than none
/// @param level   as ComparisonOptions::level; changes with p below it are shown
/// @param screen  columns of the terminal, see in_words() of an identification
[[nodiscard]] std::string in_words(const Comparison& comparison, std::span<const ResultChanges> changes,
                                   std::span<const Finding> warnings, double level, std::size_t screen = 0);

/// The same as JSON: docs/compare.md lists the members.
[[nodiscard]] std::string to_json(const Comparison& comparison, std::span<const ResultChanges> changes,
                                  std::span<const Finding> warnings, const Provenance& provenance);

/// The same as one HTML page.
[[nodiscard]] std::string html_report(const Comparison& comparison, std::span<const ResultChanges> changes,
                                      std::span<const Finding> warnings, double level,
                                      const Provenance& provenance);

}  // namespace rivid
