#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "accept.hpp"
#include "dense.hpp"
#include "identify/payload/payload_model.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::PayloadFit;
using detail::PayloadProblem;
using detail::Uncertainty;

constexpr double infinity = std::numeric_limits<double>::infinity();
// Deviation of the logarithm of an inverse gain of which nothing is known: weak enough to move no gain that
// is identifiable by a part of its deviation, and enough to hold one that is not.
constexpr double nothing_known = 1.5;
// What is said of gains that no log determines: a nominal one is known to 10 % without better knowledge.
constexpr double of_nominal_gain = 0.1;
// A gain is identifiable where its interval is narrower than this part of it.
constexpr double visible_gain = 0.3;

void require_for_gains(bool condition, const std::string& words) {
  if (!condition) {
    throw InputError("identify_gains: " + words);
  }
}

void require_control_signals(std::span<const Log> logs) {
  for (const Log& log : logs) {
    require_for_gains(
        log.tau.size() == 0 && log.v_tau.size() > 0,
        log.source +
            " has torques, or no control signals: a drive gain is the torque of a unit of the control "
            "signal; name the columns control in [log], with drive_gain = 1 where they are torques already");
  }
}

Vector known_sigmas(const Robot& robot, const GainOptions& options) {
  Vector out(robot.size());
  for (Index j = 0; j < robot.size(); ++j) {
    const auto known = options.known.find(robot.joints[static_cast<std::size_t>(j)].name);
    out[j] = known == options.known.end() ? nothing_known : known->second;
  }
  return out;
}

// Of log K_j − log K_k.
double ratio_variance(const PayloadFit& fit, const Matrix& C, Index j, Index k) {
  const Index a = fit.gains_at() + j;
  const Index b = fit.gains_at() + k;
  const double by_a = -1.0 / fit.theta()[a];
  const double by_b = 1.0 / fit.theta()[b];
  return by_a * by_a * C(a, a) + 2.0 * by_a * by_b * C(a, b) + by_b * by_b * C(b, b);
}

// The joint to which the gains of the others are determined best, by the median of their deviations.
Index best_reference(const PayloadFit& fit, const Matrix& C, Index n) {
  Index best = 0;
  double least = infinity;
  for (Index k = 0; k < n; ++k) {
    std::vector<double> sigmas;
    for (Index j = 0; j < n; ++j) {
      if (j != k) {
        sigmas.push_back(std::sqrt(ratio_variance(fit, C, j, k)));
      }
    }
    std::ranges::sort(sigmas);
    const double median = sigmas[(sigmas.size() - 1) / 2];
    if (median < least) {
      best = k;
      least = median;
    }
  }
  return best;
}

std::string scale_in_words(const Robot& robot, const GainOptions& options, std::optional<Index> reference) {
  if (reference) {
    return "Only ratios of the gains are determined, for neither a mass nor a gain is known: that of " +
           robot.joints[static_cast<std::size_t>(*reference)].name +
           " counts as exact, and its relative error is that of all gains and parameters";
  }
  std::string from = options.mass ? "the payload of " + number(*options.mass, 5) + " kg" : "";
  for (const auto& [joint, sigma] : options.known) {
    from += (from.empty() ? "the known gain of " : ", ") + joint;
  }
  return "The scale of the gains comes from " + from;
}

// What a fit that did not come to an end leaves: nominal gains.
GainReport nominal_gains(const Robot& robot, std::string why) {
  GainReport out;
  out.scale = std::move(why);
  for (const Joint& joint : robot.joints) {
    out.joints.push_back({.joint = joint.name,
                          .nominal = joint.g_tau(),
                          .value = joint.g_tau(),
                          .sigma = infinity,
                          .interval_95 = {-infinity, infinity}});
  }
  out.C = of_nominal_gain * of_nominal_gain * Matrix::Identity(robot.size(), robot.size());
  return out;
}

// Relative deviation of a nominal gain that is used because its estimate is not good enough: how far the two
// are apart and what is open of the estimate, but no less than what is known of any nominal gain, and no more
// than what would have made the estimate the better one.
double deviation_of_nominal(const GainEstimate& gain, double variance) {
  const double apart = gain.value / gain.nominal - 1.0;
  return std::clamp(std::sqrt(variance + apart * apart), of_nominal_gain, visible_gain);
}

// Why a fit came to nothing; empty where it did not.
std::string why_no_gains(PayloadFit& fit) {
  if (!fit.solve()) {
    return "The gains are not estimated: the iteration does not settle in " +
           counted(fit.iterations(), "step");
  }
  return fit.rows() > fit.theta().size() ? ""
                                         : "The gains are not estimated: " + counted(fit.rows(), "row") +
                                               " for " + counted(fit.theta().size(), "unknown");
}

// Where the ratios are known far better than the scale, rounding leaves it neither symmetric nor positive.
Matrix relative_covariance(const PayloadFit& fit, const Matrix& C, Index n) {
  const Vector scale = fit.theta().segment(fit.gains_at(), n).cwiseInverse();
  const Matrix rounded =
      scale.asDiagonal() * C.block(fit.gains_at(), fit.gains_at(), n, n) * scale.asDiagonal();
  const auto eigen = detail::symmetric_eigen(0.5 * (rounded + rounded.transpose()));
  return eigen.vectors * eigen.values.cwiseMax(0.0).asDiagonal() * eigen.vectors.transpose();
}

}  // namespace

std::vector<GainEstimate> detail::gain_estimates(const Robot& robot, const PayloadFit& fit,
                                                 const Uncertainty& uncertainty) {
  std::vector<GainEstimate> out;
  for (Index j = 0; fit.gains_at() >= 0 && j < robot.size(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    const Index at = fit.gains_at() + j;
    const double value = joint.g_tau() / fit.theta()[at];
    const double sigma = fit.determined(at, 1)
                             ? std::sqrt(uncertainty.C(at, at)) * std::abs(value / fit.theta()[at])
                             : infinity;
    const double half = uncertainty.report.quantile_975 * sigma;
    out.push_back({.joint = joint.name,
                   .nominal = joint.g_tau(),
                   .value = value,
                   .sigma = sigma,
                   .interval_95 = {value - half, value + half},
                   .identifiable = half < visible_gain * std::abs(value)});
  }
  return out;
}

std::optional<std::string> GainOptions::complaint(const Robot& robot) const {
  if (robot.base_joints > 0) {
    return "gains can not be estimated on a floating base";
  }
  for (const auto& [name, sigma] : known) {
    if (std::ranges::find(robot.joints, name, &Joint::name) == robot.joints.end()) {
      return "known names joint \"" + name + "\", which robot \"" + robot.name + "\" does not have";
    }
    if (!std::isfinite(sigma) || sigma < 0.0) {
      return "known " + name + " is " + number(sigma) + ", must not be negative";
    }
  }
  const auto exact = [](const auto& one) { return one.second == 0.0; };
  if (std::ssize(known) == robot.size() && std::ranges::all_of(known, exact)) {
    return "all gains are known exactly: none is left to be estimated";
  }
  if (robot.gear_matrix.size() > 0) {
    return "gains of motors whose gears mix the joints (gear_matrix) can not be estimated";
  }
  if (robot.size() == 1 && !mass) {
    return "one joint alone determines no ratio of gains; a payload of known mass is needed";
  }
  return range_fault(*this);
}

GainReport identify_gains(const Robot& its_robot, std::span<const Log> without, std::span<const Log> with,
                          const Estimation& asked, const GainOptions& options) {
  Estimation estimation = asked;
  const Robot robot = without_load(its_robot);
  require_for_gains(!without.empty(), "no log without payload is given");
  detail::accept("identify_gains", robot.complaint());
  detail::accept("identify_gains", options.complaint(robot));
  require_for_gains(options.mass.has_value() == !with.empty(),
                    options.mass ? "the mass belongs to logs with that payload, and none is given"
                                 : "logs with a payload are given, and not its mass");
  require_control_signals(without);
  require_control_signals(with);
  PayloadProblem problem{.robot = robot,
                         .columns = detail::PayloadColumns(robot, static_cast<int>(robot.size()) - 1),
                         .covariance = estimation.covariance,
                         .load_friction = has_load(its_robot)};
  std::vector<LoadedLogs> loaded;
  if (!with.empty()) {
    loaded.push_back({.logs = with});
    problem.loads.push_back({.mass = options.mass, .mass_sigma = options.mass_sigma});
  }
  problem.logs = detail::stacked_rows(robot, problem.columns, without, loaded, estimation);
  Vector sigma = known_sigmas(robot, options);
  problem.gain_information = detail::gain_information(sigma);
  std::optional<Index> reference;
  if (!options.mass && options.known.empty()) {
    PayloadFit free(problem);
    if (std::string why = why_no_gains(free); !why.empty()) {
      return nominal_gains(robot, std::move(why));
    }
    reference = best_reference(free, free.uncertainty().C, robot.size());
    sigma[*reference] = 0.0;
    problem.gain_information = detail::gain_information(sigma);
  }
  PayloadFit fit(problem);
  const auto judged = [&](const std::vector<GainEstimate>& gains, const Vector& sigma_rho) {
    std::vector<Finding> errors;
    if (!with.empty()) {
      errors = detail::judged_load(robot, "loaded", with, estimation, gains, sigma_rho);
      std::erase_if(errors, [](const Finding& f) { return severity(f) != Severity::error; });
    }
    return errors;
  };
  if (std::string why = why_no_gains(fit); !why.empty()) {
    GainReport out = nominal_gains(robot, std::move(why));
    out.warnings = judged(out.joints, Vector::Zero(robot.size()));
    return out;
  }
  const Uncertainty uncertainty = fit.uncertainty();
  GainReport out{.identified = true,
                 .scale = scale_in_words(robot, options, reference),
                 .joints = detail::gain_estimates(robot, fit, uncertainty),
                 .C = relative_covariance(fit, uncertainty.C, robot.size()),
                 .relative_error = fit.relative_error(),
                 .rows = fit.rows(),
                 .covariance = uncertainty.report,
                 .warnings = {}};
  out.warnings = judged(out.joints, with.empty() ? Vector() : fit.rest_with(0).sigma_rho);
  for (std::size_t j = 0; j < out.joints.size(); ++j) {
    if (!out.joints[j].identifiable) {
      const auto at = static_cast<Index>(j);
      const double deviation = deviation_of_nominal(out.joints[j], out.C(at, at));
      out.C.row(at).setZero();
      out.C.col(at).setZero();
      out.C(at, at) = deviation * deviation;
    }
  }
  return out;
}

Robot with_gains(Robot robot, const GainReport& gains) {
  if (gains.joints.size() != robot.joints.size()) {
    throw InputError("with_gains: there are " + std::to_string(gains.joints.size()) +
                     " gains, must be one for each of the " + counted(robot.size(), "joint"));
  }
  for (std::size_t j = 0; j < gains.joints.size(); ++j) {
    const GainEstimate& gain = gains.joints[j];
    if (gain.identifiable) {
      robot.joints[j].drive_gain *= gain.value / gain.nominal;
    }
  }
  robot.warnings.insert(robot.warnings.end(), gains.warnings.begin(), gains.warnings.end());
  return robot;
}

}  // namespace rivid
