#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "identify/choose/load_passes.hpp"
#include "identify/choose/row_choice.hpp"
#include "identify/describe/describe.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/load.hpp"

namespace rivid {

namespace {

using detail::Answer;
using detail::EstimationProblem;

Answer answered(const Robot& robot, std::span<const Log> logs, const Estimation& estimation) {
  if (!has_load(robot)) {
    return Answer(std::make_unique<EstimationProblem>(robot, logs, estimation));
  }
  detail::LoadPasses passes = detail::load_passes(robot, logs, estimation);
  auto problem = std::make_unique<EstimationProblem>(robot, logs, estimation, std::move(passes.point));
  detail::Estimated found = detail::estimated(*problem);
  if (!passes.fault.empty() && found.status == Status::identified) {
    found.status = Status::not_converged;
    found.reasons.push_back(std::move(passes.fault));
  }
  return {std::move(problem), std::move(found)};
}

// Why instruments can not be made; empty where they can.
std::string obstacle(const Iv& iv, std::span<const Log> logs) {
  if (!iv.control) {
    return "no controller is given ([control]), so no instruments can be simulated";
  }
  const bool followed = iv.follows == Iv::Follows::measured ||
                        std::ranges::all_of(logs, [](const Log& log) { return log.q_r.size() > 0; });
  return followed ? "" : "no reference was logged, so no instruments can be simulated";
}

// estimation  whose method is Auto, and then the one that ran
Answer answered_by_suitable_method(const Robot& robot, std::span<const Log> logs, Estimation& estimation) {
  const Iv iv = std::get<Auto>(estimation.method).iv;
  std::string why = obstacle(iv, logs);
  if (why.empty()) {
    estimation.method = iv;
    Answer out = answered(robot, logs, estimation);
    const Identification seen = described(out, {}, detail::Widened::for_judge);
    if (seen.status == Status::identified) {
      out.method = {.reason = "instrumental variables: controller and reference are known",
                    .least_squares = seen.iv->least_squares};
      return out;
    }
    why = "instrumental variables gave no answer (" + seen.reasons.front() + ")";
  }
  estimation.method = Wls{};
  Answer out = answered(robot, logs, estimation);
  out.method = {.reason = "weighted least squares: " + why, .least_squares = {}};
  return out;
}

void add_notes(std::span<const Log> logs, std::vector<std::string>& out) {
  for (const Log& log : logs) {
    for (const std::string& note : log.notes) {
      out.push_back(log.source + ": " + note);
    }
  }
}

// The robot with the laws of friction that a hint asks for; nothing where it asks for anything else.
std::optional<Robot> with_laws(Robot robot, const Finding& hint) {
  for (const Change& change : hint.changes) {
    const auto joint = std::ranges::find(robot.joints, change.joint, &Joint::name);
    const std::optional<Friction> law = named<Friction>(change.word);
    if (change.key != "robot.friction" || joint == robot.joints.end() || !law) {
      return std::nullopt;
    }
    joint->friction = *law;
  }
  return hint.changes.empty() ? std::nullopt : std::optional(std::move(robot));
}

// A law of friction that the logs of the fit show, but with which others are explained worse, is no hint. It
// is tried as a user would take it: with rows of its own. Of one that can not be tried nothing is known.
void erase_misleading_laws(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                           Estimation estimation, const Identification& seen,
                           std::vector<Finding>& findings) {
  const double error = detail::error_on_validation(seen);
  estimation.judge = false;
  estimation.choice_covariance.resize(0, 0);
  std::erase_if(findings, [&](const Finding& finding) {
    const std::optional<Robot> other = with_laws(robot, finding);
    if (!other || severity(finding) != Severity::warning) {
      return false;
    }
    try {
      return detail::error_on_validation(identify(*other, logs, estimation, validation)) > error;
    } catch (const Error&) {
      return false;
    }
  });
}

}  // namespace

double detail::error_on_validation(const Identification& result) {
  double squares = 0.0;
  for (const Validation& one : result.validation) {
    squares += std::pow(result.answer_fit(one).relative_error, 2);
  }
  const bool answers = result.status == Status::identified || result.status == Status::doubtful;
  return answers ? std::sqrt(squares / static_cast<double>(result.validation.size()))
                 : std::numeric_limits<double>::quiet_NaN();
}

Identification identify(const Robot& robot, std::span<const Log> logs, const Estimation& asked,
                        std::span<const Log> validation) {
  Estimation estimation = asked;
  std::optional<RowChoice> rows;
  for (const std::span<const Log> some : {logs, validation}) {
    for (const Log& log : some) {
      if (const auto complaint = log.complaint()) {
        throw InputError(*complaint);
      }
      detail::require_joints("position", log.q, robot, log);
    }
  }
  if (!logs.empty() && asked.signal.automatic() && !asked.complaint(robot)) {
    rows = detail::choose_rows(without_load(robot), logs, estimation);
  }
  const auto answer_now = [&] {
    return std::holds_alternative<Auto>(estimation.method)
               ? answered_by_suitable_method(robot, logs, estimation)
               : answered(robot, logs, estimation);
  };
  Answer answer = answer_now();
  // The window suited residuals in which friction that follows the load was left; now it is known.
  if (Estimation again = asked; rows && has_load(robot)) {
    rows = detail::choose_rows(robot, logs, again, answer.problem->base.load);
    if (again.signal.decimation != estimation.signal.decimation ||
        again.signal.torque_held != estimation.signal.torque_held) {
      estimation = std::move(again);
      answer = answer_now();
    }
  }
  answer.rows = std::move(rows);
  if (answer.rows) {
    detail::compare_windows(robot, logs, estimation, answer.problem->base.load, *answer.rows);
  }
  if (asked.judge && !logs.empty()) {
    answer.inference.fit.reference_error = detail::reference_error(
        robot, answer.problem->base, logs, answer.inference.chi, *answer.problem->team);
  }
  answer.notes = robot.notes;
  add_notes(logs, answer.notes);
  add_notes(validation, answer.notes);
  if (!validation.empty()) {
    const Identification forecasting = described(answer, {}, detail::Widened::for_forecast);
    for (const Log& log : validation) {
      answer.validation.push_back(validate(robot, forecasting, log, asked.threads));
    }
  }
  if (!asked.judge) {
    return described(answer, {}, detail::Widened::whole);
  }
  const Identification seen = described(answer, {}, detail::Widened::for_judge);
  detail::Judgement judgement = detail::judged(robot, logs, validation, seen);
  if (!validation.empty()) {
    Estimation anew = asked;
    anew.method = estimation.method;
    erase_misleading_laws(robot, logs, validation, std::move(anew), seen, judgement.findings);
  }
  detail::Findings of_predictions;
  detail::find_predictions(seen, of_predictions);
  judgement.findings.insert(judgement.findings.end(), of_predictions.all().begin(),
                            of_predictions.all().end());
  return described(answer, judgement, detail::Widened::whole);
}

Identification identify(const Robot& robot, const Log& log, const Estimation& estimation) {
  return identify(robot, std::span<const Log>(&log, 1), estimation);
}

}  // namespace rivid
