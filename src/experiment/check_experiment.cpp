#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <variant>

#include "experiment/from_program.hpp"
#include "experiment/recognised_columns.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// A known payload gives joints 2 to 6 of a UR10e gains that are up to so much from those of its controller,
// docs/payload.md.
constexpr double least_difference = 0.05;
// Half-widths of a 95 % interval: about three standard deviations, for all joints together.
constexpr double sure = 1.5;

void add_differences(const Experiment& experiment, const detail::TargetGains& targets,
                     std::vector<Finding>& out) {
  for (std::size_t j = 0; j < targets.motors.size(); ++j) {
    const detail::TargetGain& target = targets.motors[j];
    const Joint& joint = experiment.robot.joints[j];
    const double difference = std::abs(joint.drive_gain - target.value);
    if (target.missing.empty() &&
        difference > std::max(sure * target.half_width, least_difference * std::abs(target.value))) {
      out.push_back({"drive_gain_differs", joint.name,
                     "drive_gain is " + number(joint.drive_gain, 4) + ", by the controller's own model " +
                         number(target.value, 4) + " ± " + number(target.half_width, 2) +
                         ": torques and parameters of the joint are " +
                         number(100.0 * difference / std::abs(target.value), 2) + " % too " +
                         (std::abs(joint.drive_gain) < std::abs(target.value) ? "small" : "large") +
                         " if that is right"});
    }
  }
}

// Drive gains are of use where control signals are the torques.
void check_drive_gains(const Experiment& experiment, std::vector<Finding>& out) {
  const std::array sources = {experiment.log, experiment.validation, experiment.loaded};
  const std::optional<detail::TargetGains> targets = detail::target_gains(sources, experiment.robot);
  if (!targets) {
    return;
  }
  for (const std::string& doubt : targets->doubts) {
    out.push_back({"log_note", "targets", doubt});
  }
  if (!targets->logs.empty()) {
    out.push_back({"target_gains", "all joints", targets->text(experiment.robot)});
  }
  // What is to be estimated needs no value.
  if (!experiment.gains) {
    add_differences(experiment, *targets, out);
  }
}

}  // namespace

std::vector<Finding> check(const Experiment& experiment, int threads) {
  const std::vector<Log> logs = read_logs(experiment.log, experiment.robot);
  std::vector<Finding> out = check(experiment.robot, logs, read_logs(experiment.validation, experiment.robot),
                                   {.signal = experiment.estimation.signal,
                                    .instrumental = std::holds_alternative<Iv>(experiment.estimation.method),
                                    .threads = threads});
  detail::name_lines(experiment, logs.front(), out);
  if (logs.front().v_tau.size() > 0 && experiment.log.columns.torque.empty()) {
    check_drive_gains(experiment, out);
  }
  std::ranges::stable_sort(out, std::ranges::greater(), severity);
  return out;
}

}  // namespace rivid
