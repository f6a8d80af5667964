#include "rivid/identify/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "accept.hpp"
#include "identify/check/judge.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

std::string place(const Robot& robot, std::span<const Log> logs, const Log& log, Index joint) {
  const std::string& name = robot.joints[static_cast<std::size_t>(joint)].name;
  return logs.size() == 1 ? name : log.source + ": " + name;
}

void add_not_tested(const std::string& subject, const std::string& what, Index rows, Index wanted,
                    Findings& out) {
  out.add("not_tested", subject,
          what + " are not tested, because it moves one way at " + counted(rows, "instant") +
              " of those that are compared; " + std::to_string(wanted) + " are needed");
}

std::string number_beside(double value, double other, int digits) {
  constexpr int most = 6;
  while (digits < most && number(value, digits) == number(other, digits)) {
    ++digits;
  }
  return number(value, digits);
}

namespace {

// "Fv1 (32 %), XY2 (214 %)": weak parameters with the deviations to expect.
std::string weak_ones(const Identification& result) {
  std::string out;
  for (const ParameterEstimate& p : result.parameters) {
    if (p.verdict == Verdict::weak) {
      out += (out.empty() ? "" : ", ") + p.name + " (" + number(std::round(p.relative_sigma_percent)) + " %)";
    }
  }
  return out;
}

// throws InputError where a log can not be used or does not fit the robot
void require_logs(std::string_view who, const Robot& robot, std::span<const Log> logs,
                  std::span<const Log> validation) {
  if (logs.empty()) {
    throw InputError(std::string(who) + ": no log is given");
  }
  for (const std::span<const Log> some : {logs, validation}) {
    for (const Log& log : some) {
      accept(who, log.complaint());
      require_joints("position", log.q, robot, log);
      if (log.tau.size() == 0 && log.v_tau.size() == 0) {
        throw InputError(std::string(who) + ": " + log.source +
                         ": neither torque nor control signal; name the columns of one of them");
      }
    }
  }
}

void add_forecast(const Identification& quick, bool instrumental, Findings& out) {
  const std::string all = "all joints";
  if (quick.status != Status::identified) {
    for (const std::string& reason : quick.reasons) {
      out.add("not_excited", all, reason);
    }
  }
  for (const ParameterEstimate& p : quick.parameters) {
    if (p.verdict == Verdict::not_excited) {
      out.add(std::isfinite(p.sigma) ? "hardly_excited" : "not_excited", p.name, p.advice);
    }
  }
  if (const std::string weak = weak_ones(quick); !weak.empty()) {
    out.add("weak_parameters", all, weak);
  }
  for (const Finding& warning : quick.warnings) {
    const bool told = warning.code == "torque_lag" && out.has("torque_delay");
    const bool harmless = warning.code == "noise_bias" && instrumental;
    if (!told && !harmless) {
      out.add(warning.code, warning.subject.empty() ? all : warning.subject, warning.text);
    }
  }
  const auto identified =
      std::ranges::count(quick.parameters, Verdict::identified, &ParameterEstimate::verdict);
  out.add("forecast", all,
          std::to_string(identified) + " of " + counted(quick.base.size(), "base parameter") +
              " well, from " + counted(quick.fit.rows, "row") +
              (std::isfinite(quick.condition) ? ", condition " + number(quick.condition, 3) : "") +
              (std::isfinite(quick.fit.relative_error)
                   ? ", relative error " + number_that_says(100.0 * quick.fit.relative_error, 3) + " %"
                   : "") +
              (quick.row_choice ? "; " + quick.row_choice->reason : ""));
}

}  // namespace

}  // namespace detail

Identification examined(const Robot& its_robot, std::span<const Log> logs, const Estimation& estimation) {
  Robot robot = its_robot;
  for (Joint& joint : robot.joints) {
    // Where the law is left open the first one counts, as in all columns.
    joint.friction = joint.friction == Friction::automatic ? Friction::symmetric : joint.friction;
  }
  Identification out = identify(robot, logs,
                                {.method = Wls{},
                                 .signal = estimation.signal,
                                 .covariance = estimation.covariance,
                                 .threads = estimation.threads});
  const auto is_few = [](const Finding& f) { return f.code == "few_rows"; };
  const auto is_still = [](const Finding& f) { return f.code == "joint_still"; };
  std::erase_if(out.warnings, is_few);
  if ((out.status != Status::identified && out.status != Status::doubtful) ||
      std::ranges::any_of(out.warnings, is_still)) {
    out.warnings.clear();
  }
  return out;
}

std::vector<Finding> check(const Robot& its_robot, std::span<const Log> whole_logs,
                           std::span<const Log> whole_validation, const CheckOptions& asked) {
  // Findings about signals and sizes do not need another friction law.
  const Robot robot = without_load(its_robot);
  detail::accept("check", robot.complaint());
  detail::accept("check", asked.signal.complaint(robot.size()));
  if (asked.threads < 1) {
    throw InputError("check: threads is " + std::to_string(asked.threads) + ", must be at least 1");
  }
  detail::require_logs("check", robot, whole_logs, whole_validation);
  std::array<std::vector<Log>, 2> room;
  const auto logs = detail::within_window(whole_logs, asked.signal, room[0]);
  const auto validation = detail::within_window(whole_validation, asked.signal, room[1]);
  detail::Findings out;
  for (const Log& log : logs) {
    for (const std::string& note : log.notes) {
      out.add("log_note", log.source, note);
    }
    detail::check_encoders(robot, logs, log, out);
  }
  // What an identification would come to; where it is refused, robot and logs are checked nevertheless.
  Identification quick;
  CheckOptions options = asked;
  try {
    quick = identify(robot, whole_logs,
                     {.method = Wls{}, .signal = asked.signal, .threads = asked.threads, .judge = false});
    options.signal = quick.estimation.signal;
  } catch (const InputError& e) {
    out.add("rows_unusable", "signal", e.what());
    quick.status = Status::rank_deficient;
    quick.base = base_parameters(robot);
    if (auto doubt = quick.base.doubt()) {
      out.add("base_doubt", robot.name, std::move(*doubt));
    }
  }
  static_cast<void>(detail::check_logs(robot, logs, validation, quick, options, out));
  detail::check_result(robot, logs, validation, quick, out);
  if (!out.has("rows_unusable")) {
    detail::add_forecast(quick, options.instrumental, out);
  }
  return std::move(out).sorted();
}

}  // namespace rivid
