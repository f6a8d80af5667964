#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "excite/design_parts.hpp"
#include "excite/information.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr double unreached = std::numeric_limits<double>::infinity();
// Part of the target that the forecast is aimed at, and the least that is taken as reached without waste.
constexpr double aim = 0.97;
constexpr double enough = 0.94;

double percent_of(const ExcitationTarget& target, ParameterKind kind) {
  if (kind == ParameterKind::Fv) {
    return target.Fv_percent;
  }
  if (kind == ParameterKind::Fc) {
    return target.Fc_percent;
  }
  return is_friction(kind) ? 0.0 : target.mass_percent;
}

// The largest standard deviation that the target leaves each parameter, (b); infinite: not asked for.
Vector allowed_by(const ExcitationTarget& target, const Forecast& found) {
  // of the largest value of its unit: percentages of smaller ones refer to that; a choice
  constexpr double small = 0.1;
  Vector out(found.chi.size());
  for (Index i = 0; i < out.size(); ++i) {
    const BaseParameter& own = found.base.parameters[static_cast<std::size_t>(i)];
    const double percent = percent_of(target, own.leading.kind);
    double largest = 0.0;
    for (Index k = 0; k < out.size(); ++k) {
      const BaseParameter& other = found.base.parameters[static_cast<std::size_t>(k)];
      if (other.unit == own.unit && is_friction(other.leading.kind) == is_friction(own.leading.kind)) {
        largest = std::max(largest, std::abs(found.chi[k]));
      }
    }
    out[i] = percent > 0.0 ? percent / 100.0 * std::max(std::abs(found.chi[i]), small * largest) : unreached;
    if (out[i] == 0.0) {
      throw InputError(
          "design: target: " + own.name +
          " has no a-priori value that a percentage could be of; give masses and friction in the "
          "robot description");
    }
  }
  return out;
}

// A design of one period and what repetitions of it come to.
struct Period {
  Excitation found;
  Matrix known;  // information from elsewhere
  Matrix once;   // that one period adds
  Vector allowed;

  // Largest share of what is allowed, after so many periods, and the parameter that has it.
  [[nodiscard]] double share(double periods, Index& worst) const {
    const Vector sigma = spread(known + periods * once).sigma;
    return allowed.array().isFinite().select(sigma.cwiseQuotient(allowed), 0.0).maxCoeff(&worst);
  }
  [[nodiscard]] double share(double periods) const {
    Index worst = 0;
    return share(periods, worst);
  }
  // So many that the share is as wanted; infinite where no number is enough.
  [[nodiscard]] double periods_for(double wanted) const {
    double low = 0.0;
    double high = 1.0;
    while (share(high) > wanted) {
      low = high;
      high *= 2.0;
      if (high > 1e9) {
        return unreached;
      }
    }
    for (int k = 0; k < 40; ++k) {
      const double middle = 0.5 * (low + high);
      (share(middle) > wanted ? low : high) = middle;
    }
    return high;
  }
};

Period period(const ExcitationOptions& options,
              const std::function<Excitation(const ExcitationOptions&)>& once) {
  Period out{.found = once(options), .known = options.known, .once = {}, .allowed = {}};
  const Matrix& all = out.found.forecast.information;
  if (out.known.size() == 0) {
    out.known = Matrix::Zero(all.rows(), all.cols());
  }
  out.once = all - out.known;
  out.allowed = allowed_by(options.target, out.found.forecast);
  return out;
}

// The parameter that stays worst, and the limits that its joint and those before it use to the full.
[[noreturn]] void refuse_target(const Robot& robot, const ExcitationOptions& options, const Period& best) {
  constexpr double full = 0.98;  // of a limit; a choice: the search keeps a little of each free
  Index worst = 0;
  const double share = best.share(options.target.seconds / best.found.forecast.duration, worst);
  const BaseParameter& parameter = best.found.forecast.base.parameters[static_cast<std::size_t>(worst)];
  const double percent = percent_of(options.target, parameter.leading.kind);
  const std::string text =
      "design: the target is out of reach in " + number(options.target.seconds, 4) + " s: " +
      (std::isfinite(share) ? "σ of " + parameter.name + " comes to " + number(share * percent, 3) +
                                  " % where " + number(percent, 3) + " % is asked for"
                            : "the motion does not show " + parameter.name);
  std::string used;
  for (const LimitUse& use : best.found.forecast.limits) {
    const auto joint = std::ranges::find(robot.joints, use.joint, &Joint::name) - robot.joints.begin();
    if (joint <= parameter.leading.joint && use.share >= full) {
      used += (used.empty() ? "" : ", ") + use.joint + ": " + use.quantity;
    }
  }
  const JointInformation& own = best.found.forecast.joints[static_cast<std::size_t>(parameter.leading.joint)];
  throw InputError(text + (used.empty() ? "" : "; the motion is at the limits " + used) +
                   "; torque errors of its joint are " + number(own.sigma, 3) + " " + own.unit +
                   " a sample. Ask for less, or give more seconds, wider limits or less noise");
}

// The period so many times, one after the other.
Excitation repeated(const Robot& robot, const ExcitationOptions& options, Excitation one, int times) {
  one.series->duration = times * options.duration;
  std::vector<Finding> findings = std::move(one.forecast.findings);
  std::vector<ClearanceUse> clearances = std::move(one.forecast.clearances);
  const Index samples = static_cast<Index>(std::lround(one.series->duration * options.rate_hz)) + 1;
  const Index period = one.t.size() - 1;
  std::vector<Index> rows(static_cast<std::size_t>(samples));
  for (Index k = 0; k < samples; ++k) {
    rows[static_cast<std::size_t>(k)] = k % period;
  }
  one.t = Vector::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) / options.rate_hz);
  one.motion = {.q = one.motion.q(rows, Eigen::all),
                .qd = one.motion.qd(rows, Eigen::all),
                .qdd = one.motion.qdd(rows, Eigen::all)};
  one.forecast = forecast(robot, one.motion, options.rate_hz, options);
  one.forecast.findings = std::move(findings);
  one.forecast.clearances = std::move(clearances);
  return one;
}

}  // namespace

Excitation designed_for_target(const Robot& robot, const ExcitationOptions& options,
                               const std::function<Excitation(const ExcitationOptions&)>& once) {
  constexpr int rounds = 8;         // of periods tried; a choice: each takes a whole search
  constexpr double shortest = 0.2;  // of the period that is given
  const auto whole = [&](double seconds) { return std::round(seconds * options.rate_hz) / options.rate_hz; };
  const double longest = whole(options.duration);
  ExcitationOptions trial = options;
  trial.duration = longest;
  trial.starts = 1;
  std::optional<Period> best;
  int harmonics = options.harmonics;
  for (const int each : {options.harmonics, 8, 12}) {
    trial.harmonics = each;
    Period found = period(trial, once);
    if (!best || found.share(1.0) < best->share(1.0)) {
      best = std::move(found);
      harmonics = each;
    }
  }
  const double periods = best->periods_for(aim);
  if (!(periods * longest <= options.target.seconds)) {
    refuse_target(robot, options, *best);
  }
  // As few periods as the longest one allows, and each only as long as needed, with the same frequencies.
  int times = std::max(1, static_cast<int>(std::ceil(periods)));
  trial.starts = options.starts;
  trial.harmonics = harmonics;
  // Information grows faster than time: larger swings go into a longer period.
  double duration = longest * std::pow(periods / times, times > 1 ? 1.0 : 0.7);
  double total = unreached;
  Excitation out;
  // Of so many periods the shortest that is better than it need be, the longest that is not enough, and their
  // shares.
  std::array<double, 2> good{};
  std::array<double, 2> poor{};
  for (int k = 0; k < rounds; ++k) {
    trial.duration = duration = whole(std::clamp(duration, shortest * longest, longest));
    best = period(trial, once);
    const double share = best->share(times);
    const int needed = share <= 1.0 ? times : static_cast<int>(std::ceil(best->periods_for(1.0)));
    if (needed * duration < total && needed * duration <= options.target.seconds) {
      total = needed * duration;
      out = repeated(robot, trial, best->found, needed);
    }
    const bool at_end = share < enough ? duration <= shortest * longest * 1.001 : duration >= longest;
    if ((share <= 1.0 && share >= enough) || (at_end && share <= 1.0) || best->found.stopped) {
      break;
    }
    (share < enough ? good : poor) = {duration, share};
    if (at_end) {
      duration *= static_cast<double>(times) / (times + 1);
      ++times;
      good = poor = {};
    } else if (good[0] > poor[0] && poor[0] > 0.0) {
      const double part = std::log(aim / good[1]) / std::log(poor[1] / good[1]);
      duration = good[0] * std::pow(poor[0] / good[0], std::clamp(part, 0.2, 0.8));
    } else {
      duration *= std::pow(best->periods_for(aim) / times, 0.7);
    }
  }
  if (!std::isfinite(total)) {
    refuse_target(robot, options, *best);
  }
  return out;
}

}  // namespace rivid::detail
