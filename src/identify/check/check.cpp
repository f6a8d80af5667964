#include "rivid/identify/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include "accept.hpp"
#include "identify/check/alternatives.hpp"
#include "identify/check/checks.hpp"
#include "identify/check/torque_probe.hpp"
#include "identify/infer/covariance.hpp"
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
  constexpr int most = 6;  // significant digits; numbers that are alike to these do not differ for a reader
  while (digits < most && number(value, digits) == number(other, digits)) {
    ++digits;
  }
  return number(value, digits);
}

namespace {

// A residual of a joint on another log that is so many times the expected one contradicts the fit.
constexpr double much_worse = 2.0;

// Rows for each parameter from which deviations can be estimated.
constexpr Index least_rows = 2;

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

// Reference columns matter where the simulated loop follows them.
bool follows_reference(const Identification& result) {
  const Iv* const iv = std::get_if<Iv>(&result.estimation.method);
  return iv != nullptr && iv->follows == Iv::Follows::reference;
}

// Whether deviations are to know the errors of the model; those of published digits are not.
bool knows_model(const Estimation& estimation) {
  return resolved(estimation.covariance.kind, estimation.signal.convention) == CovarianceKind::blocks;
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

}  // namespace

void check_rows(const Identification& result, Findings& out) {
  const Index rows = result.fit.rows;
  const Index b = result.base.size();
  if (rows < least_rows * b) {
    out.add("few_rows", "all joints",
            std::to_string(rows) + " rows for " + counted(b, "base parameter") + ", should be " +
                std::to_string(least_rows * b) + " at least: deviations mean nothing");
  }
}

void check_validation(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                      const Identification& result, Findings& out) {
  for (std::size_t l = 0; l < std::min(validation.size(), result.validation.size()); ++l) {
    const Validation& found = result.validation[l];
    const Fit& there = result.answer_fit(found);
    const auto suspicious = [&](std::size_t j) {
      return there.joints[j].sigma_rho > much_worse * result.answer_fit().joints[j].sigma_rho;
    };
    bool any = false;
    for (std::size_t j = 0; j < there.joints.size(); ++j) {
      any = any || suspicious(j);
    }
    const bool poor = looks_poor(there);
    if (!any && !poor) {
      continue;
    }
    // Of an arm that nothing else is wrong with.
    if (!out.any(Severity::error)) {
      check_together(robot, logs, validation[l], result, out);
    }
    const TorqueProbe probe(robot, result.base, validation.subspan(l, 1), result.estimation.signal);
    if (poor) {
      check_poor_validation(probe, robot, found, result, out);
    }
    const std::optional<ProbedRows> rows = any ? ProbedRows::fitted(probe, robot, result) : std::nullopt;
    if (!rows) {
      continue;
    }
    const Vector residual = rows->Y - rows->W * result.answer();
    for (const ProbedRows::Piece& piece : rows->pieces) {
      const auto j = static_cast<std::size_t>(piece.joint);
      if (piece.size() == 0 || !suspicious(j) || !rows->tested(piece.joint)) {
        continue;
      }
      // What errors of the parameters make of this motion.
      const auto of_joint = rows->W.middleRows(piece.first, piece.size());
      const double by_parameters =
          (of_joint * result.answer_covariance()).cwiseProduct(of_joint).rowwise().sum().mean();
      const auto mean_square = [&](const Vector& x) {
        return x.segment(piece.first, piece.size()).squaredNorm() / static_cast<double>(piece.size());
      };
      const double seen = std::sqrt(mean_square(residual)) / rows->weights[piece.joint];
      const double expected =
          std::sqrt(mean_square(rows->residual) + by_parameters) / rows->weights[piece.joint];
      if (seen > much_worse * expected) {
        const std::string& unit = result.fit.joints[j].unit;
        std::string text = found.file + ": the model leaves " + number(seen, 3) + " " + unit;
        text += " there; by a fit to that log and the uncertainty of the parameters " + number(expected, 3);
        text += " " + unit + " were to be expected";
        out.add("validation_worse", result.fit.joints[j].name, std::move(text));
      }
    }
  }
}

Alternatives check_logs(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                        const Identification& result, const CheckOptions& options, Findings& out) {
  for (const Finding& doubt : robot.warnings) {
    out.add(doubt.code, doubt.subject.empty() ? robot.name : doubt.subject, doubt.text);
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
  if (out.has("dead_torque") || robot.base_joints > 0) {
    out.add("not_tested", "all joints",
            std::string("gains, zeros, gravity, clock and friction laws are not tested, because ") +
                (robot.base_joints > 0 ? "the base floats" : "a torque is missing"));
  }
  if (robot.base_joints > 0 || out.has("at_rest") || out.has("dead_torque") || out.has("duplicate_column")) {
    return {};
  }
  // Other readings of the log would change the load that friction follows: simpler friction shows them as
  // well.
  const Robot plain = without_load(robot);
  const BaseParameters linear = has_load(robot) ? base_parameters(plain) : result.base;
  const TorqueProbe probe(plain, linear, logs, options.signal);
  check_torques(probe, plain, linear, out);
  const bool tells = !out.any(Severity::error) && result.status == Status::identified;
  if (!tells) {
    return {};
  }
  const auto by = [&](const TorqueProbe& own) {
    Alternatives believed = check_model(own, robot, logs, validation, result, out);
    // check() makes a quick fit by least squares, whatever the method.
    if (result.iv || !options.instrumental) {
      check_physics(own, robot, logs, result, out);
    }
    return believed;
  };
  return has_load(robot) ? by(TorqueProbe(robot, result.base, logs, options.signal)) : by(probe);
}

void check_result(const Robot& robot, std::span<const Log> logs, std::span<const Log> validation,
                  const Identification& result, Findings& out) {
  if (result.status == Status::identified) {
    check_rows(result, out);
    check_validation(robot, logs, validation, result, out);
  }
}

Judgement judged(const Robot& robot, std::span<const Log> whole_logs, std::span<const Log> whole_validation,
                 const Identification& result) {
  std::array<std::vector<Log>, 2> room;
  const auto logs = within_window(whole_logs, result.estimation.signal, room[0]);
  const auto validation = within_window(whole_validation, result.estimation.signal, room[1]);
  Findings found;
  found.add(result.warnings);
  Judgement out;
  out.alternatives = check_logs(robot, logs, validation, result,
                                {.signal = result.estimation.signal,
                                 .instrumental = follows_reference(result),
                                 .threads = result.estimation.threads},
                                found);
  check_result(robot, logs, validation, result, found);
  if (!knows_model(result.estimation)) {
    out.alternatives.shift.resize(0);
  }
  out.findings.assign(found.all().begin() + std::ssize(result.warnings), found.all().end());
  return out;
}

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
