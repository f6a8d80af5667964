#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "rivid/model/urdf.hpp"

namespace rivid {

/// An experiment file to begin with.
struct ExperimentDraft {
  std::string text;                 ///< TOML, with comments on what is a matter of the robot
  bool complete = false;            ///< read_experiment() reads it: positions, torques and time were found
  std::vector<std::string> doubts;  ///< what was a guess, and what is missing
};

/// Writes an experiment file for a robot from the names of the columns of its logs: which are positions,
/// torques, control signals, references and time, in which order of the joints, in which units; with the
/// settings of a first identification for the rate of the logs. The last of several logs is kept for
/// validation. Without a log it is the file of a design, for `rivid excite`, whose motion is the first to
/// record.
///
/// What can not be found out stands in the text as a comment that says what to fill in.
///
/// @param file        where the text will be; paths in it are relative to its folder
/// @param robot_file  a URDF; with the ending .csv a modified Denavit-Hartenberg table
/// @param options     the part of a URDF; without tip and moving joints those that the logs have columns of
/// @param logs        all with the columns of the first; may be empty
/// @throws InputError  for what the robot's reader refuses, and for a log that is no table
[[nodiscard]] ExperimentDraft draft_experiment(const std::filesystem::path& file,
                                               const std::filesystem::path& robot_file,
                                               const UrdfOptions& options,
                                               std::span<const std::filesystem::path> logs);

}  // namespace rivid
