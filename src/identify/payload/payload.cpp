#include "rivid/identify/payload.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "accept.hpp"
#include "dense.hpp"
#include "identify/payload/payload_model.hpp"
#include "model/link_poses.hpp"
#include "rivid/error.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::PayloadFit;
using detail::PayloadProblem;

void require(bool condition, const std::string& words) {
  if (!condition) {
    throw InputError("identify_payloads: " + words);
  }
}

PayloadReport fitted(const PayloadProblem& problem, const PayloadOptions& options,
                     std::span<const LoadedLogs> with) {
  PayloadReport out;
  PayloadFit fit(problem);
  const bool settled = fit.solve();
  out.chi = fit.chi();
  out.Fl = fit.load_friction();
  out.rows = fit.rows();
  out.iterations = fit.iterations();
  out.relative_error = fit.relative_error();
  if (!settled || !fit.theta().allFinite()) {
    out.reason = "the iteration does not settle in " + std::to_string(fit.iterations()) + " steps";
    return out;
  }
  if (fit.freedom() <= 0) {
    out.reason = std::to_string(fit.rows()) + " rows for " + std::to_string(fit.theta().size()) + " unknowns";
    return out;
  }
  const detail::Uncertainty uncertainty = fit.uncertainty();
  out.covariance = uncertainty.report;
  for (std::size_t k = 0; k < with.size(); ++k) {
    out.payloads.push_back(detail::payload_of(fit, uncertainty, k, options));
    out.payloads.back().name = with[k].name;
    for (std::size_t from = 0; from < k; ++from) {
      out.differences.push_back(detail::difference_of(fit, uncertainty, k, from, options));
      out.differences.back().name = with[k].name + " - " + with[from].name;
    }
  }
  out.gains = detail::gain_estimates(problem.robot, fit, uncertainty);
  out.gain_sigma = problem.gain_sigma;
  out.identified = true;
  for (std::size_t k = 0; k < with.size(); ++k) {
    out.identified = out.identified && fit.determined(fit.payload_at(k), inertial_count);
  }
  if (!out.identified) {
    out.reason = "the motion does not determine all parameters of arm and payload";
  } else if (!fit.full_rank()) {
    out.reason = "the motion does not determine all parameters of the arm, but those of the payload";
  }
  const auto unweighed = std::ranges::find(out.payloads, true, &Payload::unweighed);
  if (unweighed != out.payloads.end()) {
    out.identified = false;
    out.reason = unweighed->name + ": the motion does not show its mass";
  }
  return out;
}

bool told_nothing_of_gains(const PayloadProblem& problem, const PayloadOptions& options) {
  return options.gain_sigma.size() == 0 &&
         (problem.arm == nullptr || problem.arm->gain_covariance.size() == 0);
}

PayloadReport fitted_on(PayloadProblem& problem, std::span<const Log> without,
                        std::span<const LoadedLogs> with, Estimation estimation,
                        const PayloadOptions& options) {
  problem.logs = detail::stacked_rows(problem.robot, problem.columns, without, with, estimation);
  PayloadReport out = fitted(problem, options, with);
  if (out.payloads.empty()) {
    // No body at all explains such torques, let alone a usual one: what there is of an answer is judged.
    for (PayloadProblem::Load& load : problem.loads) {
      load.usual = false;
    }
    out = fitted(problem, options, with);
  }
  if (!out.identified && told_nothing_of_gains(problem, options)) {
    // Torques nearly without noise leave no room for gains that are off by that much.
    problem.gain_information = {};
    PayloadReport exact = fitted(problem, options, with);
    if (exact.identified) {
      exact.reason = "the drive gains count as exact: off by 1 % each they leave the payload undetermined";
      out = std::move(exact);
    }
  }
  out.signal = estimation.signal;
  return out;
}

// Of drive gains of which nothing is told.
constexpr double usual_gain_sigma = 0.01;

void require_usable(const Robot& robot, std::span<const LoadedLogs> with, const Estimation& asked,
                    const PayloadOptions& options) {
  require(!with.empty(), "no log with a payload is given");
  detail::accept("identify_payloads", robot.complaint());
  detail::accept("identify_payloads", options.complaint(robot));
  const auto unknown = [](double sigma) { return std::isinf(sigma); };
  bool scale = options.gain_sigma.size() == 0 || !std::ranges::all_of(options.gain_sigma, unknown);
  for (std::size_t k = 0; k < with.size(); ++k) {
    detail::accept("identify_payloads", with[k].complaint());
    const auto same_name = [&](const LoadedLogs& other) { return other.name == with[k].name; };
    require(std::ranges::none_of(with.first(k), same_name),
            "two payloads are named " + in_quotes(with[k].name));
    scale = scale || with[k].mass.has_value();
  }
  require(scale,
          "no gain is known and no mass: torques determine only their ratios; give the mass of a payload, or "
          "what is known of one gain");
  require(!std::holds_alternative<Iv>(asked.method) && !asked.robust,
          "it is weighted least squares: method \"iv\" and robust estimation are not for payloads");
}

PayloadProblem problem_of(const Robot& robot, std::span<const LoadedLogs> with, const Estimation& asked,
                          const PayloadOptions& options) {
  // Friction by load is an unknown of the fit itself.
  Robot plain = without_load(robot);
  detail::PayloadColumns columns(plain, static_cast<int>(options.link_of(robot).value()));
  PayloadProblem out{.robot = std::move(plain),
                     .columns = std::move(columns),
                     .covariance = asked.covariance,
                     .load_friction = options.load_friction || has_load(robot)};
  for (const LoadedLogs& logs : with) {
    out.loads.push_back(
        {.usual = options.model != PayloadModel::body, .mass = logs.mass, .mass_sigma = logs.mass_sigma});
  }
  out.gain_sigma =
      options.gain_sigma.size() > 0 ? options.gain_sigma : Vector::Constant(robot.size(), usual_gain_sigma);
  out.gain_information = detail::gain_information(out.gain_sigma);
  return out;
}

// What a fit with other logs leaves of a joint, beside what one of these logs alone leaves; and as a part of
// its torque.
constexpr double much_more = 2.0;
constexpr double most_left = 0.3;
// Rows of a joint for each parameter of the robot from which on what a fit of its own leaves can be compared.
constexpr Index rows_a_parameter = 2;

// Torques by the gains that were found.
std::vector<Log> with_gains(std::span<const Log> logs, const std::vector<GainEstimate>& gains) {
  std::vector<Log> out(logs.begin(), logs.end());
  for (Log& log : out) {
    for (std::size_t j = 0; j < gains.size(); ++j) {
      for (Matrix* const torques : {&log.tau, &log.v_tau}) {
        if (torques->size() > 0) {
          torques->col(static_cast<Index>(j)) *= gains[j].value / gains[j].nominal;
        }
      }
    }
  }
  return out;
}

// Gains that the logs contradict: far outside of what was known of them, whatever takes part in that.
std::vector<Finding> contradicted_gains(const PayloadReport& found) {
  constexpr double sure = 4.0;  // deviations; chance is 6e-5 for each gain
  std::vector<Finding> out;
  for (std::size_t j = 0; j < found.gains.size(); ++j) {
    const GainEstimate& gain = found.gains[j];
    const double known = found.gain_sigma[static_cast<Index>(j)];
    const double off = std::abs(gain.value / gain.nominal - 1.0);
    if (off > sure * known && off > sure * gain.sigma / std::abs(gain.nominal)) {
      out.push_back({"torque_gain", gain.joint,
                     "its torque is " + number(gain.nominal / gain.value, 3) +
                         " times what arm and payload ask for, where its gain is known to " +
                         number(100.0 * known, 2) + " %"});
    }
  }
  return out;
}

bool is_error(const Finding& finding) { return severity(finding) == Severity::error; }

}  // namespace

std::vector<Finding> detail::about(const std::string& name, std::vector<Finding> findings) {
  for (Finding& finding : findings) {
    finding.subject = name + (finding.subject.empty() ? "" : ": " + finding.subject);
  }
  return findings;
}

std::vector<Finding> detail::judged_load(const Robot& robot, const std::string& name,
                                         std::span<const Log> logs, const Estimation& estimation,
                                         const std::vector<GainEstimate>& gains, const Vector& sigma_rho) {
  const Identification alone = examined(robot, with_gains(logs, gains), estimation);
  std::vector<Finding> out = alone.warnings;
  std::vector<std::string> joints;
  double most = 0.0;
  std::string text;  // of the worst joint
  for (std::size_t j = 0; j < alone.fit.joints.size(); ++j) {
    const JointFit& joint = alone.fit.joints[j];
    const double scale = gains.empty() ? 1.0 : std::abs(gains[j].value / gains[j].nominal);
    const double left = scale * sigma_rho[static_cast<Index>(j)];
    const double times = left / joint.sigma_rho;
    const double part = times * joint.centred_relative_error;
    const bool fits_itself = joint.rows > rows_a_parameter * std::ssize(alone.parameters);
    if (!fits_itself || !(times > much_more || part > most_left)) {
      continue;
    }
    joints.push_back(joint.name);
    if (times > most) {
      most = times;
      text = "arm and payload leave " + number(left, 3) + " " + joint.unit + " of the torque of " +
             joint.name + ", " + number(100.0 * part, 2) + " % (mean taken off); an identification from " +
             "these logs alone " + number(joint.sigma_rho, 3) + " " + joint.unit;
    }
  }
  if (!joints.empty()) {
    out.push_back({"payload_misfit", listed(joints), std::move(text)});
  }
  return about(name, std::move(out));
}

void examine(const Robot& robot, std::span<const Log> without, std::span<const LoadedLogs> with,
             const Estimation& asked, PayloadReport& found) {
  Estimation estimation = asked;
  estimation.signal = found.signal;
  const auto take = [&](const std::vector<Finding>& some) {
    found.warnings.insert(found.warnings.end(), some.begin(), some.end());
  };
  found.warnings.clear();
  if (!without.empty()) {
    take(detail::about("without payload", examined(robot, without, estimation).warnings));
  }
  take(contradicted_gains(found));
  for (std::size_t k = 0; k < with.size(); ++k) {
    const bool settled = k < found.payloads.size();
    take(detail::judged_load(robot, with[k].name, with[k].logs, estimation, found.gains,
                             settled ? found.payloads[k].sigma_rho : Vector::Zero(robot.size())));
    if (settled && !found.payloads[k].none() && found.payloads[k].mass < 0.0) {
      const PayloadValue& mass = found.payloads[k].values.front();
      take({{"negative_mass", with[k].name,
             number(mass.value, 3) + " ± " + number(mass.sigma, 2) + " kg, masses are positive"}});
    }
  }
  std::ranges::stable_sort(found.warnings, std::ranges::greater(), severity);
  if (found.identified && std::ranges::any_of(found.warnings, is_error)) {
    found.identified = false;
    found.doubtful = true;
    found.reason = sentence(found.warnings.front());
  }
}

std::string untold_reason(const PayloadReport& found, const Payload& payload) {
  return found.doubtful      ? "the result is doubtful"
         : !found.identified ? "it is not identified"
         : payload.none()    ? payload.reason
         : payload.mass < 0  ? "its mass is negative"
                             : "";
}

std::optional<std::string> LoadedLogs::complaint() const {
  if (logs.empty()) {
    return "no log with " + in_quotes(name) + " is given";
  }
  if (mass && (!std::isfinite(*mass) || *mass <= 0.0)) {
    return "mass is " + number(*mass) + " kg, must be positive";
  }
  if (!std::isfinite(mass_sigma) || mass_sigma < 0.0) {
    return "mass_sigma is " + number(mass_sigma) + " kg, must not be negative";
  }
  return std::nullopt;
}

std::optional<std::size_t> PayloadOptions::link_of(const Robot& robot) const {
  if (link.empty()) {
    const std::vector<std::size_t> tips = robot.chain.tips();
    return tips.size() == 1 ? std::optional(tips.front()) : std::nullopt;
  }
  return detail::link_called(robot, link);
}

std::optional<std::string> PayloadOptions::complaint(const Robot& robot) const {
  if (robot.base_joints > 0) {
    return "payloads are identified on a base that stands still, that of robot \"" + robot.name + "\" floats";
  }
  if (!link_of(robot)) {
    return (link.empty() ? "the robot branches, so the link of the payload must be named"
                         : "no moving link is called " + in_quotes(link)) +
           " (links: " + quoted_list(detail::link_names(robot)) + ")";
  }
  if (!detail::is_rotation(R)) {
    return "R is no rotation";
  }
  if (!p.allFinite()) {
    return "p must be finite";
  }
  if (gain_sigma.size() > 0 &&
      (gain_sigma.size() != robot.size() || gain_sigma.hasNaN() || gain_sigma.minCoeff() < 0.0)) {
    return "gain_sigma has " + counted(gain_sigma.size(), "value") +
           ", must have one, not negative, for each of the " + std::to_string(robot.size()) + " joints";
  }
  return std::nullopt;
}

std::optional<std::string> IdentifiedArm::complaint() const {
  if (auto fault = robot.complaint()) {
    return fault;
  }
  const Index b = base_parameters(robot).size();
  const Index n = robot.size();
  if (chi.size() != b || C_chi.rows() != b || C_chi.cols() != b) {
    return "chi and C_chi must have " + std::to_string(b) + " values and as many rows and columns, not " +
           std::to_string(chi.size()) + " and " + std::to_string(C_chi.rows());
  }
  if (gain_slopes.rows() != b || gain_slopes.cols() != n) {
    return "gain_slopes must have " + std::to_string(b) + " rows and " + std::to_string(n) +
           " columns, not " + std::to_string(gain_slopes.rows()) + " and " +
           std::to_string(gain_slopes.cols());
  }
  if (gain_covariance.size() > 0 &&
      (gain_covariance.rows() != n || !detail::is_positive_semidefinite(gain_covariance))) {
    return "gain_covariance is " + std::to_string(gain_covariance.rows()) + " × " +
           std::to_string(gain_covariance.cols()) +
           ", must be n × n, finite, symmetric and positive semidefinite for the " + counted(n, "joint");
  }
  if (!chi.allFinite() || !C_chi.allFinite() || !gain_slopes.allFinite() ||
      !(C_chi.diagonal().minCoeff() > 0.0)) {
    return "the arm is not determined: its parameters must be finite, their variances finite and positive";
  }
  return std::nullopt;
}

IdentifiedArm identified_arm(const Robot& robot, const Identification& result) {
  if (result.status != Status::identified) {
    throw InputError("identified_arm: the result is not identified");
  }
  IdentifiedArm out{robot, result.chi, result.C_chi, result.gain_slopes, result.estimation.gain_covariance};
  detail::accept("identified_arm", out.complaint());
  return out;
}

PayloadReport identify_payloads(const Robot& robot, std::span<const Log> without,
                                std::span<const LoadedLogs> with, const Estimation& asked,
                                const PayloadOptions& options) {
  require(!without.empty(), "no log without the payload is given");
  require_usable(robot, with, asked, options);
  PayloadProblem problem = problem_of(robot, with, asked, options);
  return fitted_on(problem, without, with, asked, options);
}

PayloadReport identify_payloads(const IdentifiedArm& arm, std::span<const LoadedLogs> with,
                                const Estimation& asked, const PayloadOptions& options) {
  detail::accept("identify_payloads", arm.complaint());
  require_usable(arm.robot, with, asked, options);
  PayloadProblem problem = problem_of(arm.robot, with, asked, options);
  problem.arm = &arm;
  if (options.gain_sigma.size() == 0 && arm.gain_covariance.size() > 0) {
    problem.gain_sigma = arm.gain_covariance.diagonal().cwiseSqrt();
    problem.gain_information = detail::gain_information_of(arm.gain_covariance);
  }
  return fitted_on(problem, {}, with, asked, options);
}

std::string urscript_line(const Payload& payload) {
  const Eigen::Vector3d& c = payload.com;
  const Eigen::Matrix3d& I = payload.inertia;
  return "set_target_payload(" + number(payload.mass, 5) + ", [" + number(c[0], 5) + ", " + number(c[1], 5) +
         ", " + number(c[2], 5) + "], [" + number(I(0, 0), 5) + ", " + number(I(1, 1), 5) + ", " +
         number(I(2, 2), 5) + ", " + number(I(0, 1), 5) + ", " + number(I(0, 2), 5) + ", " +
         number(I(1, 2), 5) + "])";
}

std::string libfranka_line(const Payload& payload) {
  std::string out = "robot.setLoad(" + number(payload.mass, 5) + ", {";
  for (Index k = 0; k < 3; ++k) {
    out += (k > 0 ? ", " : "") + number(payload.com[k], 5);
  }
  out += "}, {";
  for (Index k = 0; k < 9; ++k) {
    out += (k > 0 ? ", " : "") + number(payload.inertia(k % 3, k / 3), 5);
  }
  return out + "});";
}

}  // namespace rivid
