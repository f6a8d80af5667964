#include "rivid/identify/check.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "identify/check/findings.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace detail {

namespace {

// Condition number of the weighted rows from which on a fit does not carry over to other motions.
constexpr double poor_condition = 5000.0;

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

// What an identification would come to.
struct Forecast {
  std::optional<Identification> result;
  std::string refusal;  // why there is none
};

Forecast forecast(const Robot& robot, std::span<const Log> logs, const CheckOptions& options) {
  try {
    return {.result = identify(robot, logs,
                               {.method = Wls{}, .signal = options.signal, .threads = options.threads}),
            .refusal = {}};
  } catch (const InputError& e) {
    return {.result = {}, .refusal = e.what()};
  }
}

void check_excitation(const Forecast& forecast, Findings& out) {
  if (!forecast.result) {
    out.add("rows_unusable", "signal", forecast.refusal);
    return;
  }
  const Identification& quick = *forecast.result;
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
  if (quick.status == Status::identified && quick.condition > poor_condition) {
    out.add("poor_condition", all,
            "condition number " + number(quick.condition, 4) + " of the weighted rows, should be below " +
                number(poor_condition));
  }
  if (const std::string weak = weak_ones(quick); !weak.empty()) {
    out.add("weak_parameters", all, weak);
  }
  for (const Finding& warning : quick.warnings) {
    if ((warning.code == "torque_lag" && !out.has("torque_delay")) || warning.code == "noise_bias") {
      out.add(warning.code, all, warning.text);
    }
  }
  const auto identified =
      std::ranges::count(quick.parameters, Verdict::identified, &ParameterEstimate::verdict);
  out.add("forecast", all,
          std::to_string(identified) + " of " + counted(quick.base.size(), "base parameter") +
              " well, from " + counted(quick.fit.rows, "row") + ", condition " + number(quick.condition, 3) +
              ", relative error " + number(100.0 * quick.fit.relative_error, 3) + " %" +
              (quick.row_choice ? "; " + quick.row_choice->reason : ""));
}

}  // namespace detail

std::vector<Finding> check(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                           const CheckOptions& asked) {
  if (logs.empty()) {
    throw InputError("check: no log is given");
  }
  if (const auto complaint = robot.complaint()) {
    throw InputError("check: " + *complaint);
  }
  if (const auto complaint = asked.signal.complaint(robot.size())) {
    throw InputError("check: " + *complaint);
  }
  detail::Findings out;
  for (const Finding& doubt : robot.warnings) {
    out.add(doubt.code, robot.name, doubt.text);
  }
  const BaseParameters base = base_parameters(robot);
  if (auto doubt = base.doubt()) {
    out.add("base_doubt", robot.name, std::move(*doubt));
  }
  for (const Log& log : logs) {
    if (const auto complaint = log.complaint()) {
      throw InputError("check: " + *complaint);
    }
    for (const std::string& note : log.notes) {
      out.add("log_note", log.source, note);
    }
    for (const Finding& warning : log.warnings) {
      out.add(warning.code, log.source, warning.text);
    }
  }
  const detail::Forecast forecast = detail::forecast(robot, logs, asked);
  CheckOptions options = asked;
  if (forecast.result) {
    options.signal = forecast.result->estimation.signal;
  }
  detail::check_duplicates(logs, validation, out);
  detail::check_series(robot, logs, options, out);
  detail::check_torques(robot, base, logs, options, out);
  detail::check_excitation(forecast, out);
  return std::move(out).sorted();
}

}  // namespace rivid
