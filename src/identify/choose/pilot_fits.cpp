#include "identify/choose/pilot_fits.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "identify/rows/factors.hpp"
#include "ranges.hpp"
#include "rivid/error.hpp"

namespace rivid::detail {

namespace {

// Samples that a window is chosen by: of longer logs a part stands for all, if each joint moves there at
// least so much of what it would if it moved evenly all the time.
constexpr Index most_samples = 30000;
constexpr double even_motion = 0.5;

Index samples_of(std::span<const Log> logs) { return sum_of(logs, &Log::samples); }

// So many samples of a log that stand for it: its middle, or where a joint hardly moves there, the stretch in
// which the joint that moves least moves most. Nothing where a joint hardly moves in that one either, as in
// logs that move one joint after the other.
std::optional<Log> part_of(const Log& log, Index count) {
  const Index span = motion_span(log);
  const Vector whole = motion(log, span, 0, log.samples());
  const auto least = [&](Index first) {
    const Vector here = motion(log, span, first, count);
    double out = std::numeric_limits<double>::infinity();
    for (Index j = 0; j < whole.size(); ++j) {
      out = std::min(out, whole[j] > 0.0 ? here[j] / whole[j] : 1.0);
    }
    return out;
  };
  Index best = (log.samples() - count) / 2;
  double most = least(best);
  const Index step = std::max<Index>(count / 4, 1);
  for (Index first = 0; most < even_motion && first + count <= log.samples(); first += step) {
    if (const double moves = least(first); moves > most) {
      most = moves;
      best = first;
    }
  }
  return most >= even_motion ? std::optional(excerpt(log, best, count)) : std::nullopt;
}

// What stands for long logs, or nothing where they are taken whole.
std::vector<Log> parts_of(std::span<const Log> logs) {
  const Index samples = samples_of(logs);
  std::vector<Log> out;
  if (samples <= most_samples) {
    return out;
  }
  for (const Log& log : logs) {
    std::optional<Log> part =
        part_of(log, static_cast<Index>(static_cast<double>(log.samples()) *
                                        static_cast<double>(most_samples) / static_cast<double>(samples)));
    if (!part) {
      return {};
    }
    out.push_back(*std::move(part));
  }
  return out;
}

}  // namespace

Index motion_span(const Log& log) {
  return std::clamp<Index>(static_cast<Index>(0.05 * log.f_m), 1, std::max<Index>(log.samples() / 4, 1));
}

Vector motion(const Log& log, Index span, Index first, Index count) {
  const Index m = std::max<Index>(count - span, 0);
  const auto difference = log.q.middleRows(first + count - m, m) - log.q.middleRows(first, m);
  return difference.colwise().squaredNorm().transpose() / static_cast<double>(std::max<Index>(m, 1));
}

PilotFits::PilotFits(const Robot& robot, std::span<const Log> logs, const Estimation& asked, LoadPoint load)
    : robot_(robot),
      parts_(parts_of(logs)),
      logs_(parts_.empty() ? logs : std::span<const Log>(parts_)),
      part_of_samples_(static_cast<double>(samples_of(logs_)) / static_cast<double>(samples_of(logs))),
      load_(std::move(load)),
      options_{.method = Wls{},
               .signal = asked.signal,
               .covariance = {.kind = CovarianceKind::hac, .lag = asked.covariance.lag},
               .threads = asked.threads} {}

SignalOptions PilotFits::with(int n_d) const {
  SignalOptions out = options_.signal;
  out.decimation = {n_d};
  return out;
}

std::optional<Pilot> PilotFits::fitted(int n_d, bool whole) {
  pilot_ = options_;
  pilot_.signal = with(n_d);
  pilot_.covariance.kind = whole ? CovarianceKind::hac : CovarianceKind::classical;
  rows_a_parameter_ = 0.0;
  try {
    problem_ = std::make_unique<EstimationProblem>(robot_, logs_, pilot_, load_);
    Pilot out{.estimate = *estimated(*problem_).estimate, .statistics = {}, .fit = {}};
    if (whole) {
      out.statistics = statistics_of(*problem_, out.estimate);
      out.fit = fit_to(robot_, problem_->data, out.estimate.chi, out.estimate.rank, pilot_.signal.convention);
    }
    rows_a_parameter_ = rows_a_parameter(out);
    return out;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

double PilotFits::rows_a_parameter(const Pilot& fit) const {
  return static_cast<double>(fit.estimate.rows) / part_of_samples_ /
         static_cast<double>(fit.estimate.chi.size());
}

}  // namespace rivid::detail
