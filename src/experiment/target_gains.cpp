#include <algorithm>
#include <cmath>

#include "dense.hpp"
#include "experiment/recognised_columns.hpp"
#include "experiment/sections.hpp"
#include "rivid/error.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Slower joints are not taken [rad/s | m/s].
constexpr double slow = 0.05;

std::vector<Column> columns_named(const std::vector<std::string>& names, double scale) {
  std::vector<Column> out;
  for (const std::string& name : names) {
    out.push_back({name, scale});
  }
  return out;
}

// The same file with targets in place of torques and control signals; nothing where it has none.
std::optional<LogSource> with_targets(const LogSource& source, const std::filesystem::path& file,
                                      const Robot& robot) {
  const std::vector<std::string> names = column_names(file, source.columns.table);
  const RecognisedLog found = recognised_log(names, joint_names(robot));
  if (found.target_current.columns.empty() || found.target_torque.columns.empty()) {
    return std::nullopt;
  }
  LogSource out;
  out.files = {file};
  out.side = source.side;
  out.irregular = source.irregular;
  out.resample = source.resample;
  out.columns = source.columns;
  out.columns.velocity.clear();
  out.columns.reference.clear();
  out.columns.reference_velocity.clear();
  out.columns.torque =
      columns_named(found.target_torque.columns, unit_scale(found.target_torque.unit.value_or("1")));
  out.columns.control = columns_named(found.target_current.columns, 1.0);
  for (std::size_t j = 0; j < source.columns.control.size(); ++j) {
    out.columns.control[j].scale = std::abs(source.columns.control[j].scale);
  }
  out.columns.default_names = source.columns.position.empty();
  return out;
}

// A log with targets in place of torques and control signals.
void add_log(const Log& log, const Robot& robot, std::vector<TargetSums>& sums) {
  const Matrix R = robot.gears();
  const Matrix torque = log.tau * inverse(R);
  const Matrix velocity = central_difference(log.q, log.f_m) * R.transpose();
  for (Index j = 0; j < R.rows(); ++j) {
    sums[static_cast<std::size_t>(j)].add(log.v_tau.col(j), torque.col(j), velocity.col(j),
                                          slow * R.row(j).cwiseAbs().sum());
  }
}

}  // namespace

bool TargetGains::any() const {
  return std::ranges::any_of(motors, [](const TargetGain& gain) { return gain.missing.empty(); });
}

std::string TargetGains::text(const Robot& robot) const {
  std::string values;
  std::string widths;
  std::string missing;
  for (std::size_t j = 0; j < motors.size(); ++j) {
    const TargetGain& gain = motors[j];
    values += j == 0 ? "" : ", ";
    values += gain.missing.empty() ? number(gain.value, 4) : "?";
    if (gain.missing.empty()) {
      widths += (widths.empty() ? "" : ", ") + number(100.0 * gain.half_width / std::abs(gain.value), 2);
    } else {
      missing += "; " + robot.joints[j].name + ": " + gain.missing;
    }
  }
  return "drive_gain = [" + values + "] by the target currents and torques of " +
         (logs.size() == 1 ? logs.front() : counted(std::ssize(logs), "log")) +
         (widths.empty() ? "" : ", 95 % intervals ± " + widths + " %") + missing;
}

std::optional<TargetGains> target_gains(std::span<const LogSource> sources, const Robot& robot) {
  TargetGains out;
  std::vector<TargetSums> sums(robot.joints.size());
  for (const LogSource& source : sources) {
    for (const std::filesystem::path& file : source.files) {
      try {
        if (const std::optional<LogSource> targets = with_targets(source, file, robot)) {
          for (const Log& log : read_logs(*targets, robot)) {
            add_log(log, robot, sums);
          }
          out.logs.push_back(file.filename().string());
        }
      } catch (const InputError& e) {
        // Nothing else needs these columns.
        out.doubts.emplace_back(e.what());
      }
    }
  }
  if (out.logs.empty() && out.doubts.empty()) {
    return std::nullopt;
  }
  for (std::size_t j = 0; j < sums.size(); ++j) {
    TargetGain& gain = out.motors.emplace_back(sums[j].gain());
    gain.value = std::copysign(gain.value, robot.joints[j].drive_gain);
  }
  return out;
}

}  // namespace rivid::detail
