#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/data/table.hpp"
#include "rivid/experiment/experiment.hpp"

// What experiment files say, from a program that holds it: the keys of docs/experiment.md as TOML text, with
// the same defaults, checks and messages. The bindings of other languages hand their options over in this
// way.
namespace rivid::detail {

/// A robot's description as its file holds it.
struct RobotDescription {
  std::string text;    ///< a URDF, or a modified Denavit-Hartenberg table
  std::string source;  ///< that messages name it by
  std::string name;    ///< of the robot, where it is a table
  bool mdh = false;    ///< whether it is a table
};

/// The robot of a description with the keys of [robot], save those that name its file.
///
/// @throws InputError  as read_experiment() does
[[nodiscard]] Robot robot_of(const RobotDescription& description, std::string_view keys);

/// An experiment of a robot with the sections of an experiment file beside [robot], all of which may be
/// absent. Paths in them are relative to the working directory.
///
/// @param source  that messages begin with
/// @throws InputError  as read_experiment() does
[[nodiscard]] Experiment experiment_from(const Robot& robot, std::string_view sections,
                                         const std::string& source);

/// read_experiment() of a text that that file could hold.
///
/// @throws InputError  as read_experiment() does
[[nodiscard]] Experiment experiment_of_text(const std::filesystem::path& path, std::string_view text);

/// What is to be done to logs on the way in: the keys of [log], whose files are not opened.
///
/// @throws InputError  as read_experiment() does
[[nodiscard]] LogSource log_source_of(const Robot& robot, std::string_view keys, const std::string& source);

/// The logs in a table, as read_logs() makes them of a file.
///
/// @throws InputError  as read_logs() does
[[nodiscard]] std::vector<Log> logs_of(const Table& table, const LogSource& source, const Robot& robot);

/// The estimation of an experiment, its method with the control law.
///
/// @throws InputError  where the method simulates a loop and the experiment has no control law
[[nodiscard]] Estimation estimation_of(const Experiment& experiment);

/// Adds the line of [log] that mends a wrong sign to findings of one: torque = ["tau1", { column = "tau2",
/// sign = -1 }]. Columns with units, scales or offsets are left to the cure of the finding.
void name_lines(const Experiment& experiment, const Log& log, std::vector<Finding>& findings);

/// take_friction() by logs that are there.
///
/// @throws InputError  as take_friction() does
void take_friction(Experiment& experiment, std::span<const Log> logs, std::span<const Log> validation,
                   const Progress& progress);

/// take_gains() by logs that are there.
///
/// @throws InputError  as take_gains() does
void take_gains(Experiment& experiment, std::span<const Log> logs, Reading& reading);

}  // namespace rivid::detail
