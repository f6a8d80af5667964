#include "rivid/identify/identification.hpp"

#include <array>
#include <utility>

#include "identify/fit.hpp"
#include "identify/iv.hpp"
#include "identify/least_squares_fit.hpp"
#include "rivid/error.hpp"

namespace rivid {

std::string_view name(Status status) {
  constexpr std::array<std::string_view, 6> names = {"identified", "rank_deficient",   "not_converged",
                                                     "cycling",    "weak_instruments", "not_simulable"};
  return names[static_cast<std::size_t>(status)];
}

std::string_view name(Verdict verdict) {
  constexpr std::array<std::string_view, 3> names = {"identified", "weak", "not_excited"};
  return names[static_cast<std::size_t>(verdict)];
}

Identification identify(const Robot& robot, std::span<const Log> logs, const Estimation& estimation) {
  Identification out;
  out.method = name(estimation.method);
  out.title = title(estimation.method);
  if (logs.empty()) {
    throw InputError("identify(" + out.title + "): no log is given");
  }
  if (const auto fault = estimation.complaint(robot)) {
    throw InputError("identify(" + out.title + "): " + *fault);
  }
  out.estimation = estimation;
  out.estimation.progress = {};
  out.base = base_parameters(robot);
  out.columns = out.base.size();
  if (auto doubt = out.base.doubt()) {
    out.warnings.push_back(Finding{"base_doubt", {}, std::move(*doubt)});
  }
  if (std::holds_alternative<Iv>(estimation.method)) {
    detail::instrumental_fit(robot, logs, estimation, out);
  } else {
    detail::least_squares_fit(robot, logs, estimation, out);
  }
  return out;
}

Identification identify(const Robot& robot, const Log& log, const Estimation& estimation) {
  return identify(robot, std::span<const Log>(&log, 1), estimation);
}

Validation validate(const Robot& robot, const Identification& identification, const Log& log, int threads) {
  const SignalOptions& signal = identification.estimation.signal;
  const RowFactors data =
      detail::all_factors(robot, identification.base, std::span(&log, 1), signal, threads, {});
  Validation out{log.source, detail::judged(robot, data, identification.chi, 0, signal.convention), {}, {}};
  if (identification.physical) {
    out.physical = detail::judged(robot, data, identification.physical->parameters.chi, 0, signal.convention);
  }
  if (identification.essential) {
    out.essential =
        detail::judged(robot, data, identification.essential->parameters.chi, 0, signal.convention);
  }
  return out;
}

}  // namespace rivid
