#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/check/checks.hpp"
#include "identify/infer/findings.hpp"
#include "identify/infer/infer.hpp"

// The last stage: rows → estimate → infer → judge → describe. An Identification is made here, and nowhere
// else.
namespace rivid::detail {

// A problem that leaves nothing open, what was chosen for it, and all that is known of it.
struct Answer {
  explicit Answer(std::unique_ptr<const EstimationProblem> its_problem)
      : problem(std::move(its_problem)), found(estimated(*problem)), inference(inferred(*problem, found)) {}
  Answer(std::unique_ptr<const EstimationProblem> its_problem, Estimated its_estimate)
      : problem(std::move(its_problem)),
        found(std::move(its_estimate)),
        inference(inferred(*problem, found)) {}

  std::unique_ptr<const EstimationProblem> problem;
  Estimated found;
  Inference inference;
  std::optional<RowChoice> rows;
  std::optional<MethodChoice> method;
  std::vector<Validation> validation;
  std::vector<std::string> notes;  // of robot and logs
};

// What deviations have beyond errors of the rows: forecasts of torques nothing, for a law of friction that
// was nearly chosen moves its parameters together and hardly the torques; the judge that choice; the result
// also what is open of the geometry, which is the same in all logs of an arm, so that no fault is judged
// beside it.
enum class Widened { for_forecast, for_judge, whole };

// The result, or what a judge is to see of it where there is no judgement yet.
//
[[nodiscard]] Identification described(const Answer& answer, const Judgement& judgement, Widened widened);

// Relative error of the answer on all validation logs together; no number where there are none, or no answer.
[[nodiscard]] double error_on_validation(const Identification& result);

// Verdict and advice of parameters with deviations and intervals, from their correlations in C, and what the
// regressor says about the motion that shows them.
//
// velocities  of the logs that the estimate is from: joints that hardly move there are named
void judge_parameters(const Robot& robot, const BaseParameters& base, const Matrix& C,
                      const SquaredVelocities& velocities, std::vector<ParameterEstimate>& parameters);

// What makes a result with parameters doubtful by its own figures.
void find_noise(const Identification& result, Findings& out);
void find_outliers(const Identification& result, Findings& out);
void find_torque_lag(const Identification& result, Findings& out);
// A validation that is far off what the fit and its forecast say.
void find_predictions(const Identification& result, Findings& out);
void find_prefilter(const Identification& result, Findings& out);
// with_V  relative error with the simulated motion; that with the measured one is result.fit's
void find_loop(double with_V, const Identification& result, Findings& out);

// Why instruments are too weak; empty where they are not.
[[nodiscard]] std::string weakness_of_instruments(const IvHistory& iv, const BaseParameters& base);

}  // namespace rivid::detail
