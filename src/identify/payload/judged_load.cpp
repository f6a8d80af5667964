#include "identify/payload/judged_load.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "rivid/identify/check.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

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
  constexpr double sure = 4.0;
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

}  // namespace rivid
