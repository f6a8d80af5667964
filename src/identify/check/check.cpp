#include "rivid/identify/check.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "identify/check/findings.hpp"
#include "identify/check/torque_probe.hpp"
#include "identify/infer/covariance.hpp"
#include "identify/infer/infer.hpp"
#include "identify/infer/parameter_set.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

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

}  // namespace

void Findings::add(std::string_view code, std::string subject, std::string text) {
  assert(diagnostic_code(code));
  all_.push_back(Finding{std::string(code), std::move(subject), std::move(text)});
}

bool Findings::has(std::string_view code, std::string_view subject) const {
  return std::ranges::any_of(
      all_, [&](const Finding& f) { return f.code == code && (subject.empty() || f.subject == subject); });
}

bool Findings::any(Severity of) const {
  return std::ranges::any_of(all_, [&](const Finding& f) { return severity(f) == of; });
}

void Findings::drop(std::string_view code) {
  std::erase_if(all_, [&](const Finding& f) { return f.code == code; });
}

std::vector<Finding> Findings::sorted() && {
  std::ranges::stable_sort(all_, std::ranges::greater(), severity);
  return std::move(all_);
}

std::string place(const Robot& robot, std::span<const Log> logs, const Log& log, Index joint) {
  const std::string& name = robot.joints[static_cast<std::size_t>(joint)].name;
  return logs.size() == 1 ? name : log.source + ": " + name;
}

void check_duplicates(std::span<const Log> logs, std::span<const Log> validation, Findings& out) {
  const auto same = [](const Log& a, const Log& b) {
    return a.q.rows() == b.q.rows() && a.q.cols() == b.q.cols() && a.q == b.q;
  };
  for (std::size_t k = 0; k < logs.size(); ++k) {
    for (std::size_t earlier = 0; earlier < k; ++earlier) {
      if (same(logs[k], logs[earlier])) {
        out.add("duplicate_log", logs[k].source, "has the positions of " + logs[earlier].source);
      }
    }
    for (const Log& other : validation) {
      if (same(logs[k], other)) {
        out.add("validation_log_used", other.source, "of the validation is a log of the identification");
      }
    }
  }
}

namespace {

// throws InputError where a log can not be used or does not fit the robot
void require_logs(std::string_view who, const Robot& robot, std::span<const Log> logs,
                  std::span<const Log> validation) {
  if (logs.empty()) {
    throw InputError(std::string(who) + ": no log is given");
  }
  for (const std::span<const Log> some : {logs, validation}) {
    for (const Log& log : some) {
      if (const auto complaint = log.complaint()) {
        throw InputError(std::string(who) + ": " + *complaint);
      }
      require_joints("position", log.q, robot, log);
      if (log.tau.size() == 0 && log.v_tau.size() == 0) {
        throw InputError(std::string(who) + ": " + log.source +
                         ": neither torque nor control signal; name the columns of one of them");
      }
    }
  }
}

// Reference columns matter where the simulated loop follows them.
bool follows_reference(const Identification& result) {
  const Iv* const iv = std::get_if<Iv>(&result.estimation.method);
  return iv != nullptr && iv->follows == Iv::Follows::reference;
}

// Robot, logs and model, as far as a result can be wrong by them; the alternatives to the model that are believed.
Alternatives examine_logs(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                          const Identification& result, const CheckOptions& options, Findings& out) {
  for (const Finding& doubt : robot.warnings) {
    out.add(doubt.code, robot.name, doubt.text);
  }
  for (const std::span<const Log> some : {logs, validation}) {
    for (const Log& log : some) {
      for (const Finding& warning : log.warnings) {
        out.add(warning.code, log.source, warning.text);
      }
    }
  }
  check_duplicates(logs, validation, out);
  check_series(robot, logs, options, out);
  if (out.has("at_rest") || out.has("dead_torque") || out.has("duplicate_column")) {
    return {};
  }
  // Other readings of the log would change the load that friction follows: simpler friction shows them as well.
  const Robot plain = without_load(robot);
  const BaseParameters linear = has_load(robot) ? base_parameters(plain) : result.base;
  const TorqueProbe probe(plain, linear, logs, options.signal);
  check_torques(probe, plain, linear, out);
  const bool tells = !out.any(Severity::error) && result.status == Status::identified;
  if (!tells) {
    return {};
  }
  const auto by = [&](const TorqueProbe& own) {
    Alternatives believed = check_model(own, robot, result, out);
    // check() makes a quick fit by least squares, whatever the method.
    if (result.iv || !options.instrumental) {
      check_physics(own, robot, logs, result, out);
    }
    return believed;
  };
  return has_load(robot) ? by(TorqueProbe(robot, result.base, logs, options.signal)) : by(probe);
}

// Whether deviations are to know the errors of the model; those of published digits are not.
bool knows_model(const Estimation& estimation) {
  return resolved(estimation.covariance.kind, estimation.signal.convention) == CovarianceKind::blocks;
}

// The covariance with what the alternatives move the estimate by.
void widen(const Robot& robot, std::span<const Log> logs, const Vector& shift, Identification& result) {
  result.C_chi += shift * shift.transpose();
  const double t = result.covariance.quantile_975;
  for (Index i = 0; i < shift.size(); ++i) {
    ParameterEstimate& p = result.parameters[static_cast<std::size_t>(i)];
    const double before = p.sigma;
    p.model_shift = shift[i];
    p.sigma = std::sqrt(result.C_chi(i, i));
    p.noise_bias *= before / p.sigma;
    p.relative_sigma_percent = 100.0 * p.sigma / std::abs(p.value);
    p.interval_95 = {p.value - t * p.sigma, p.value + t * p.sigma};
    p.verdict = {};
    p.advice.clear();
  }
  judge_parameters(robot, squared_velocities(logs, robot.size()), result);
}

// What the result says of itself.
void examine_result(const Robot& robot, std::span<const Log> validation, const Identification& result,
                    Findings& out) {
  if (result.status == Status::identified) {
    check_rows(result, out);
    check_signs(robot, result, out);
    check_validation(robot, validation, result, out);
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

void examine(const Robot& robot, std::span<const Log> whole_logs, std::span<const Log> whole_validation,
             Identification& result) {
  if (const auto complaint = robot.complaint()) {
    throw InputError("examine: " + *complaint);
  }
  if (static_cast<Index>(result.fit.joints.size()) != robot.size()) {
    throw InputError("examine: the result is of " + counted(std::ssize(result.fit.joints), "joint") +
                     ", robot \"" + robot.name + "\" has " + std::to_string(robot.size()));
  }
  if (const auto complaint = result.base.complaint(robot)) {
    throw InputError("examine: " + *complaint);
  }
  detail::expect_values("examine", result);
  detail::require_logs("examine", robot, whole_logs, whole_validation);
  std::array<std::vector<Log>, 2> room;
  const auto logs = detail::within_window(whole_logs, result.estimation.signal, room[0]);
  const auto validation = detail::within_window(whole_validation, result.estimation.signal, room[1]);
  detail::Findings found;
  for (const Finding& own : result.warnings) {
    found.add(own.code, own.subject, own.text);
  }
  detail::Alternatives alternatives = detail::examine_logs(robot, logs, validation, result,
                                                           {.signal = result.estimation.signal,
                                                            .instrumental = detail::follows_reference(result),
                                                            .threads = result.estimation.threads},
                                                           found);
  detail::examine_result(robot, validation, result, found);
  result.alternatives = std::move(alternatives.believed);
  if (alternatives.shift.size() > 0 && detail::knows_model(result.estimation)) {
    detail::widen(robot, logs, alternatives.shift, result);
  }
  if (found.has("torque_delay")) {
    found.drop("torque_lag");
  }
  result.warnings = std::move(found).sorted();
  std::erase_if(result.warnings, [](const Finding& f) { return severity(f) == Severity::note; });
  if (result.status != Status::identified) {
    return;
  }
  for (const Finding& finding : result.warnings) {
    if (severity(finding) == Severity::error) {
      result.status = Status::doubtful;
      result.reasons.push_back(sentence(finding));
    }
  }
}

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
  examine(robot, logs, {}, out);
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
  if (const auto complaint = robot.complaint()) {
    throw InputError("check: " + *complaint);
  }
  if (const auto complaint = asked.signal.complaint(robot.size())) {
    throw InputError("check: " + *complaint);
  }
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
    quick = identify(robot, whole_logs, {.method = Wls{}, .signal = asked.signal, .threads = asked.threads});
    options.signal = quick.estimation.signal;
  } catch (const InputError& e) {
    out.add("rows_unusable", "signal", e.what());
    quick.status = Status::rank_deficient;
    quick.base = base_parameters(robot);
    if (auto doubt = quick.base.doubt()) {
      out.add("base_doubt", robot.name, std::move(*doubt));
    }
  }
  static_cast<void>(detail::examine_logs(robot, logs, validation, quick, options, out));
  detail::examine_result(robot, validation, quick, out);
  if (!out.has("rows_unusable")) {
    detail::add_forecast(quick, options.instrumental, out);
  }
  return std::move(out).sorted();
}

}  // namespace rivid
