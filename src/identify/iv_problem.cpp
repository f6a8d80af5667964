#include "identify/iv_problem.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "identify/fit.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

SignalOptions without_transient(const Log& log, SignalOptions signal, double transient) {
  if (transient > 0.0) {
    auto window = signal.window.value_or(std::array{log.t[0], log.t[log.samples() - 1]});
    window[0] = std::max(window[0], log.t[0] + transient);
    signal.window = window;
  }
  return signal;
}

}  // namespace

IvProblem::IvProblem(const Robot& its_robot, std::span<const Log> its_logs, const Estimation& its_estimation)
    : robot(its_robot),
      logs(its_logs),
      estimation(its_estimation),
      method(std::get<Iv>(its_estimation.method)) {
  base = base_parameters(robot);
  if (method.chi_0.size() > 0 && (method.chi_0.size() != base.size() || !method.chi_0.allFinite())) {
    throw InputError("identify(IDIM-IV): chi_0 has " + counted(method.chi_0.size(), "value") +
                     ", must have one, finite, for each of " + counted(base.size(), "base parameter"));
  }
  signals.reserve(logs.size());
  for (const Log& log : logs) {
    if (const auto fault = log.complaint()) {
      throw InputError(*fault);
    }
    signals.push_back(without_transient(log, estimation.signal, method.transient));
    add_factors(data, factors(robot, base, log, signals.back(), estimation.threads));
  }
  Index rows = 0;
  for (const RowGroup& group : data.groups) {
    rows += group.qr.rows();
  }
  if (rows <= base.size()) {
    throw InputError("identify(IDIM-IV): " + std::to_string(rows) + " rows for " +
                     std::to_string(base.size()) + " base parameters; more rows than parameters are needed");
  }
}

}  // namespace rivid::detail
