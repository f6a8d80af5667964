#include <algorithm>
#include <cmath>
#include <limits>

#include "excite/problem.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::Limited;

constexpr double infinity = std::numeric_limits<double>::infinity();
// That of an identification, see Verdict; the interval holds no zero then.
constexpr double weak_percent = 30.0;
// Deviation of the torque errors where nothing is said of them, as a part of the limit.
constexpr double usual_noise = 0.01;

Vector noise_of(std::string_view who, const Robot& robot, const ExcitationOptions& options,
                std::vector<Finding>& findings) {
  if (options.noise.sigma.size() > 0) {
    return options.noise.sigma;
  }
  Vector out(robot.size());
  for (Index j = 0; j < robot.size(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    const double limit = options.limits.torque.size() > 0 ? options.limits.torque[j] : joint.max_effort;
    if (!std::isfinite(limit)) {
      throw InputError(
          std::string(who) + ": " + joint.name +
          ": neither its torque errors nor its torque limit are known; give noise, their standard "
          "deviation in N·m or N");
    }
    out[j] = usual_noise * limit;
  }
  findings.push_back(
      Finding{"noise_assumed", robot.name,
              "torque errors are taken for 1 % of the torque limits; forecast standard deviations "
              "are in proportion to them"});
  return out;
}

Matrix known_of(std::string_view who, const ExcitationOptions& options, Index b) {
  if (options.known.size() == 0) {
    return Matrix::Zero(b, b);
  }
  if (options.known.rows() != b || options.known.cols() != b) {
    throw InputError(std::string(who) + ": known is (" + std::to_string(options.known.rows()) + " × " +
                     std::to_string(options.known.cols()) +
                     "), must have a row and a column for each of the " + counted(b, "base parameter"));
  }
  return options.known;
}

ForecastParameter forecast_of(const BaseParameter& parameter, double value, double sigma) {
  using enum ForecastParameter::Prospect;
  ForecastParameter out{.name = parameter.name, .unit = parameter.unit, .value = value, .sigma = sigma};
  out.relative_sigma_percent = value == 0.0 ? infinity : 100.0 * sigma / std::abs(value);
  // A deviation of ten thousand times the value is what rounding leaves of a motion that does not show it.
  if (!std::isfinite(sigma) || (value != 0.0 && out.relative_sigma_percent > most_said)) {
    out.prospect = unseen;
    out.relative_sigma_percent = infinity;
  } else if (out.relative_sigma_percent > weak_percent) {
    out.prospect = weak;
  }
  return out;
}

// Central differences, one-sided at the ends.
Matrix derivative(const Matrix& x, double f_m) {
  const Index N = x.rows();
  Matrix out = Matrix::Zero(N, x.cols());
  for (Index k = 0; N > 1 && k < N; ++k) {
    const Index before = std::max<Index>(k - 1, 0);
    const Index after = std::min(k + 1, N - 1);
    out.row(k) = (x.row(after) - x.row(before)) * (f_m / static_cast<double>(after - before));
  }
  return out;
}

// @param C  covariance of the estimates
void add_correlations(const Matrix& C, std::vector<ForecastParameter>& parameters) {
  const Vector sigma = C.diagonal().cwiseSqrt();
  for (Index i = 0; i < C.rows() && C.rows() > 1; ++i) {
    Vector others = C.col(i).cwiseQuotient(sigma) / sigma[i];
    others[i] = 0.0;
    Index closest = 0;
    others.cwiseAbs().maxCoeff(&closest);
    ForecastParameter& parameter = parameters[static_cast<std::size_t>(i)];
    parameter.closest = parameters[static_cast<std::size_t>(closest)].name;
    parameter.correlation = others[closest];
  }
}

// Rows of joints that are slower than a twentieth of their rms velocity are zero: identification leaves them
// out.
std::vector<Matrix> moving_rows(std::span<const Matrix> W, const Motion& motion, Index first) {
  constexpr double slow_part = 0.05;  // a choice that stands for the masks of identification
  std::vector<Matrix> out(W.begin(), W.end());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto v = motion.qd.col(static_cast<Index>(i)).array().abs();
    const double least = slow_part * std::sqrt(v.square().mean());
    out[i].array().colwise() *= (v.segment(first, out[i].rows()) >= least).cast<double>();
  }
  return out;
}

// What each row adds to the information, w C wᵀ / σ²: Σ over all rows is b where nothing was known before.
Matrix leverages(detail::SampledRegressor& regressor, const Motion& motion, const Matrix& C,
                 const Vector& weights) {
  Matrix out(motion.samples(), motion.joints());
  regressor.pieces(motion, [&](Index first, std::span<const Matrix> all) {
    const std::vector<Matrix> W = moving_rows(all, motion, first);
    for (std::size_t i = 0; i < W.size(); ++i) {
      const std::vector<Index>& columns = regressor.columns(i);
      const auto joint = static_cast<Index>(i);
      out.col(joint).segment(first, W[i].rows()) =
          weights[joint] * (W[i] * C(columns, columns)).cwiseProduct(W[i]).rowwise().sum();
    }
  });
  return out;
}

std::vector<JointInformation> joint_information(const Robot& robot, const Vector& weights,
                                                const Matrix& leverage, Index b) {
  std::vector<JointInformation> out;
  for (Index j = 0; j < robot.size(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    out.push_back({.joint = joint.name,
                   .unit = unit_of(Limited::torque, joint.type),
                   .sigma = 1.0 / std::sqrt(weights[j]),
                   .share = leverage.size() > 0 ? leverage.col(j).sum() / static_cast<double>(b)
                                                : std::numeric_limits<double>::quiet_NaN()});
  }
  return out;
}

// Of both sides of a limit the one that is nearer.
std::vector<LimitUse> uses(const Robot& robot, const MotionBounds& bounds,
                           const detail::LimitedMotion& motion, double f_m) {
  std::vector<LimitUse> out;
  const std::vector<detail::SideLimit> sides = detail::side_limits(bounds);
  for (std::size_t l = 0; l + 1 < sides.size(); l += 2) {
    const detail::Peak upper = detail::peak(sides[l], motion);
    const detail::Peak lower = detail::peak(sides[l + 1], motion);
    const detail::SideLimit& nearer = upper.value >= lower.value ? sides[l] : sides[l + 1];
    const detail::Peak& at = upper.value >= lower.value ? upper : lower;
    const Joint& joint = robot.joints[static_cast<std::size_t>(nearer.joint)];
    out.push_back({.joint = joint.name,
                   .quantity = std::string(detail::about(nearer.quantity).name),
                   .unit = unit_of(nearer.quantity, joint.type),
                   .value = motion.of(nearer)[at.sample],
                   .limit = nearer.side * nearer.edge,
                   .share = 1.0 + at.value,
                   .time = static_cast<double>(at.sample) / f_m});
  }
  return out;
}

}  // namespace

namespace detail {

Task task_of(std::string_view who, const Robot& robot, const ExcitationOptions& options, double rate_hz,
             std::vector<Finding>& findings) {
  if (const auto fault = robot.complaint()) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  if (const auto fault = options.complaint(robot)) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  Task out{.robot = robot,
           .base = base_parameters(robot),
           .chi = {},
           .weights = {},
           .known = {},
           .objective = Information{},
           .bounds = motion_bounds(robot, options.limits),
           .space = options.space};
  if (!options.space.wanted()) {
    out.space.self_collision = false;  // nobody asked
  }
  findings.insert(findings.end(), out.space.model.findings.begin(), out.space.model.findings.end());
  out.clearances =
      std::make_shared<const Clearances>(robot, out.space, out.bounds.lower, out.bounds.upper, findings);
  findings.insert(findings.end(), out.bounds.findings.begin(), out.bounds.findings.end());
  if (out.bounds.torque.array().isFinite().any()) {
    out.chi = out.base.from_standard(robot.chi_st());
  }
  const double rate = options.noise.rate_hz > 0.0 ? options.noise.rate_hz : rate_hz;
  out.weights = rate * noise_of(who, robot, options, findings).array().square().inverse();
  out.known = known_of(who, options, out.base.size());
  return out;
}

}  // namespace detail

Forecast forecast(const Robot& robot, const Motion& motion, double f_m, const ExcitationOptions& options) {
  if (!(f_m > 0.0) || !std::isfinite(f_m)) {
    throw InputError("forecast: the rate of the motion is " + number(f_m) + " Hz, must be positive");
  }
  if (motion.samples() < 1) {
    throw InputError("forecast: the motion has no sample, must have at least one");
  }
  Forecast out;
  out.f_m = f_m;
  out.duration = static_cast<double>(motion.samples() - 1) / f_m;
  const detail::Task task = detail::task_of("forecast", robot, options, f_m, out.findings);
  RegressorBatch(robot, task.base.columns()).require("forecast", motion, 0, motion.samples());
  detail::require_finite("forecast", motion);
  detail::SampledRegressor regressor(robot, task.base);
  out.information = task.known;
  const Vector weights = task.weights / f_m;
  regressor.pieces(motion, [&](Index first, std::span<const Matrix> W) {
    detail::add_information(regressor, moving_rows(W, motion, first), weights, out.information);
  });
  if (!out.information.allFinite()) {
    throw InputError("forecast: q, qd or qdd of the motion is so large that the information overflows");
  }
  const detail::Spread spread = detail::spread(out.information);
  out.log_det = spread.log_det;
  out.condition = spread.condition;
  out.base = task.base;
  out.chi = task.base.from_standard(robot.chi_st());
  for (Index i = 0; i < task.base.size(); ++i) {
    out.parameters.push_back(
        forecast_of(task.base.parameters[static_cast<std::size_t>(i)], out.chi[i], spread.sigma[i]));
    out.parameters.back().sigma_alone = 1.0 / std::sqrt(out.information(i, i));
  }
  if (const auto scored = detail::score(out.information, detail::Information{})) {
    add_correlations(scored->K, out.parameters);
    out.leverage = leverages(regressor, motion, scored->K, weights);
  }
  out.joints = joint_information(robot, weights, out.leverage, task.base.size());
  if (task.chi.size() > 0) {
    out.tau = detail::predicted_torques(regressor, motion, task.chi);
  }
  out.clearances = detail::checked_clearances(robot, task.space, task.clearances->kept(), motion.q, f_m);
  const Matrix jerk = derivative(motion.qdd, f_m);
  out.limits = uses(robot, task.bounds, {motion, jerk, out.tau}, f_m);
  return out;
}

}  // namespace rivid
