#include <algorithm>
#include <utility>

#include "identify/choose/load_passes.hpp"
#include "identify/choose/row_choice.hpp"
#include "identify/infer/infer.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/load.hpp"

namespace rivid {

namespace {

using detail::EstimationProblem;

Identification identified(const Robot& robot, std::span<const Log> logs, const Estimation& estimation) {
  if (has_load(robot)) {
    return detail::identified_under_load(robot, logs, estimation);
  }
  const EstimationProblem problem(robot, logs, estimation);
  return detail::identified(problem);
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

Identification by_suitable_method(const Robot& robot, std::span<const Log> logs, Estimation estimation) {
  const Iv iv = std::get<Auto>(estimation.method).iv;
  std::string why = obstacle(iv, logs);
  if (why.empty()) {
    estimation.method = iv;
    Identification out = identified(robot, logs, estimation);
    if (out.status == Status::identified && out.iv) {
      out.method_choice = {.reason = "instrumental variables: controller and reference are known",
                           .least_squares = out.iv->least_squares};
      return out;
    }
    why = "instrumental variables gave no answer (" + out.reasons.front() + ")";
  }
  estimation.method = Wls{};
  Identification out = identified(robot, logs, estimation);
  out.method_choice = {.reason = "weighted least squares: " + why, .least_squares = {}};
  return out;
}

}  // namespace

Identification identify(const Robot& robot, std::span<const Log> logs, const Estimation& asked) {
  Estimation estimation = asked;
  std::optional<RowChoice> rows;
  for (const Log& log : logs) {
    detail::require_joints("position", log.q, robot, log);
  }
  if (!logs.empty() && asked.signal.automatic() && !asked.complaint(robot)) {
    rows = detail::choose_rows(without_load(robot), logs, estimation);
  }
  Identification out = std::holds_alternative<Auto>(asked.method)
                           ? by_suitable_method(robot, logs, estimation)
                           : identified(robot, logs, estimation);
  // Uncertain by more than a row, or ten samples, it says nothing; the rows were chosen with what little it does.
  constexpr Index few = 10;
  const Index known = std::max(few, detail::stride_of(out.estimation.signal));
  if (out.diagnostics && out.diagnostics->torque_lag &&
      !(out.diagnostics->torque_lag->sigma <= static_cast<double>(known))) {
    out.diagnostics->torque_lag.reset();
  }
  if (rows) {
    detail::report_noise(out, *rows);
  }
  out.row_choice = std::move(rows);
  return out;
}

Identification identify(const Robot& robot, const Log& log, const Estimation& estimation) {
  return identify(robot, std::span<const Log>(&log, 1), estimation);
}

}  // namespace rivid
