#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "identify/check/target_gain.hpp"
#include "rivid/experiment/experiment.hpp"

// What the columns of a log hold, by their names alone, and what follows from those of a controller.
namespace rivid::detail {

/// The columns of one quantity, one for each joint.
struct RecognisedColumns {
  std::vector<std::string> columns;  ///< base to tip; empty: none were found
  std::optional<std::string> unit;   ///< that the names give, as unit_scale() knows it
};

/// Sorted by the keys of a [log] section, and targets.
struct RecognisedLog {
  RecognisedColumns time;  ///< one column
  RecognisedColumns position;
  RecognisedColumns velocity;
  RecognisedColumns torque;
  RecognisedColumns control;  ///< looked for where there are no torques
  RecognisedColumns reference;
  RecognisedColumns reference_velocity;
  RecognisedColumns target_current;  ///< by the controller's own model; no key of a [log] section takes them
  RecognisedColumns target_torque;
  std::vector<std::string> doubts;  ///< choices that were not the only ones, and columns that almost fit
};

/// What a column holds.
enum class ColumnKind {
  position,
  velocity,
  torque,
  control,
  reference,
  reference_velocity,
  target_current,
  target_torque,
  time
};

/// A key of [log] whose columns are one a joint, in the order of a draft; control signals are behind torques,
/// in whose place they are.
struct LogKey {
  std::string_view key;
  ColumnKind kind;
  RecognisedColumns RecognisedLog::* columns;
};
inline constexpr std::array<LogKey, 6> log_keys = {
    {{"position", ColumnKind::position, &RecognisedLog::position},
     {"torque", ColumnKind::torque, &RecognisedLog::torque},
     {"control", ColumnKind::control, &RecognisedLog::control},
     {"velocity", ColumnKind::velocity, &RecognisedLog::velocity},
     {"reference", ColumnKind::reference, &RecognisedLog::reference},
     {"reference_velocity", ColumnKind::reference_velocity, &RecognisedLog::reference_velocity}}};

/// Names are taken apart into words ("actual_q_0", "/joint_states/elbow/position", "Axis1 Torque [Nm]"); a
/// quantity is where they say the same of all joints, which are distinguished by their names or by numbers
/// from 0 or 1. Words that say that a column holds something else (accelerations, external torques,
/// temperatures) rule it out.
///
/// @param names   of the columns of a file
/// @param joints  their names, base to tip
[[nodiscard]] RecognisedLog recognised_log(std::span<const std::string> names,
                                           std::span<const std::string> joints);

/// Columns of the pose of a floating base, as [log.base] takes them, and of forces on links; all empty where
/// the pose is not there.
struct RecognisedBase {
  std::vector<std::string> position;
  std::vector<std::string> orientation;
  std::map<std::string, std::vector<std::string>> forces;  ///< or wrenches, by what their names begin with
};

/// "base_x" and its like, "pose.position.x" beside "pose.orientation.w"; "FL_foot_fx", "left.force.x". Those
/// of tools and hands are no base.
[[nodiscard]] RecognisedBase recognised_base(std::span<const std::string> names);

/// The joints that columns are named after, in their order.
[[nodiscard]] std::vector<std::string> joints_in(std::span<const std::string> names,
                                                 std::span<const std::string> joints);

struct TargetGains {
  std::vector<TargetGain> motors;
  std::vector<std::string> logs;    ///< that have target currents and target torques
  std::vector<std::string> doubts;  ///< logs whose targets can not be read, and why

  [[nodiscard]] bool any() const;
  /// "drive_gain = [11.9, 12, ?] by the target currents and torques of run.csv, 95 % intervals ± 0.4, 0.1 %;
  /// elbow: its target torque hardly changes".
  [[nodiscard]] std::string text(const Robot& robot) const;
};

/// Drive gains by what a controller logs of its own model, its target currents and target torques, whose
/// columns are recognised by their names: see TargetSums. The interval is by blocks of time.
///
/// @param sources  their files, positions, control columns, clocks and side of the gears; target currents are
///                 taken to be in the unit of the control columns, with the factors of these but without
///                 their signs
/// @return         nothing where no log has such columns
[[nodiscard]] std::optional<TargetGains> target_gains(std::span<const LogSource> sources, const Robot& robot);

}  // namespace rivid::detail
