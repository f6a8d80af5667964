#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "identify/infer/infer.hpp"

// Fits by which rows are chosen, and compared with others.
namespace rivid::detail {

// Samples between two positions whose difference is motion rather than noise.
[[nodiscard]] Index motion_span(const Log& log);

// Mean squared displacement of each joint over `span` samples, from a stretch of the log.
[[nodiscard]] Vector motion(const Log& log, Index span, Index first, Index count);

// A fit to some rows, as far as the choice of others needs it.
struct Pilot {
  Estimate estimate;
  Statistics statistics;
  Fit fit;

  [[nodiscard]] Vector sigma() const { return statistics.uncertainty.C.diagonal().cwiseSqrt(); }
};

// Weighted least squares with windows of any length; of long logs a part stands for all.
class PilotFits {
 public:
  // load  of friction that follows the load: the point that the rows are the tangent at
  PilotFits(const Robot& robot, std::span<const Log> logs, const Estimation& asked, LoadPoint load = {});

  [[nodiscard]] std::span<const Log> logs() const { return logs_; }
  [[nodiscard]] SignalOptions& signal() { return options_.signal; }
  [[nodiscard]] const Estimation& options() const { return options_; }
  [[nodiscard]] SignalOptions with(int n_d) const;

  // Nothing where a window leaves too few rows.
  //
  // whole  with statistics
  std::optional<Pilot> fitted(int n_d, bool whole);

  // Of the last fit.
  [[nodiscard]] const EstimationProblem& problem() const { return *problem_; }
  // Of the last fit, and of all logs, also where a part stands for them; 0 where its rows were refused.
  [[nodiscard]] double rows_a_parameter() const { return rows_a_parameter_; }
  [[nodiscard]] double rows_a_parameter(const Pilot& fit) const;

 private:
  const Robot& robot_;
  std::vector<Log> parts_;  // empty where the logs are taken whole
  std::span<const Log> logs_;
  double part_of_samples_;  // that these have of all
  LoadPoint load_;
  Estimation options_;  // of all fits, but for the window
  Estimation pilot_;    // of the last one
  std::unique_ptr<EstimationProblem> problem_;
  double rows_a_parameter_ = 0.0;
};

}  // namespace rivid::detail
