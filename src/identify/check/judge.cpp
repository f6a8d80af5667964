#include "identify/check/judge.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "identify/check/torque_probe.hpp"
#include "identify/infer/covariance.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/regressor/load.hpp"

namespace rivid::detail {

namespace {

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

}  // namespace rivid::detail
