#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/report/json.hpp"

namespace rivid::detail {

// Sections of the HTML report, as markup; empty where a result has nothing for them.

[[nodiscard]] std::string parameters_section(const Identification& result);
[[nodiscard]] std::string prefilter_section(const Identification& result);
[[nodiscard]] std::string essential_section(const Identification& result);
[[nodiscard]] std::string physical_section(const Identification& result);
[[nodiscard]] std::string torques_section(const Identification& result,
                                          std::span<const Prediction> predictions);
[[nodiscard]] std::string residuals_section(const Identification& result,
                                            std::span<const Prediction> predictions);
[[nodiscard]] std::string iterations_section(const Identification& result);
// The path of each parameter over the iterations of IDIM-IV.
[[nodiscard]] std::string parameter_paths(const std::vector<ParameterEstimate>& parameters,
                                          const std::vector<IvIteration>& iterations);
[[nodiscard]] std::string conditioning_section(const Identification& result);
[[nodiscard]] std::string provenance_section(const Robot& robot, const Identification& result,
                                             const Provenance& provenance);

// What another set of parameters than the estimate costs in fit, and on the logs of the validation.
[[nodiscard]] std::string prices(const Identification& result, const Fit& fit,
                                 std::optional<Fit> Validation::* of_validation, const std::string& title);

// Samples of which one is kept, so that the page stays one that a browser opens.
[[nodiscard]] Index thinning(std::span<const Prediction> predictions);

// What report.js draws, as JSON that may stand in a <script>.
[[nodiscard]] std::string plot_data(const Identification& result, std::span<const Prediction> predictions);

// Whether there is anything to draw beside what was measured.
[[nodiscard]] inline bool predicted(const Identification& result) { return result.chi.allFinite(); }

// The residual of one joint's rows over the logs of the identification.
struct ResidualShape {
  Index rows = 0;
  double mean = 0.0;
  double sigma = 0.0;
  double first_edge = 0.0;  // of the histogram …
  double bin = 0.0;         // … and the width of its bins
  std::vector<double> counts;
  Index outside = 0;                    // rows beyond the histogram
  std::vector<double> autocorrelation;  // at lags of 1, 2 … rows; empty where rows are few
};

[[nodiscard]] ResidualShape residual_shape(std::span<const Prediction> predictions, std::size_t joint);

}  // namespace rivid::detail
