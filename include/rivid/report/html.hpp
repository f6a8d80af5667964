#pragma once

#include <span>
#include <string>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/report/json.hpp"

namespace rivid {

/// A result as one HTML page to look at, the content of report.html; docs/report.md says what it shows. It
/// holds all that it needs, loads nothing, and follows the browser's choice of light or dark. Plots are drawn
/// by the page's own script.
///
/// Torques are kept as single precision. Of more than 2 000 000 samples, counted over joints and logs, every
/// second, third … is kept, and the page says so.
///
/// @param predictions  of predict(), for each log that is to be shown; those of the identification first
/// @throws InputError  where robot, result and predictions are of different joints or parameters
[[nodiscard]] std::string html_report(const Robot& robot, const Identification& result,
                                      std::span<const Prediction> predictions, const Provenance& provenance);

}  // namespace rivid
