#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "tool.hpp"

// The subcommands of rivid identify: what comes before an identification, and after one. argv[0] is the name
// of the subcommand.
namespace rivid::apps {

/// rivid init ROBOT.urdf LOG.csv…: an experiment file to begin with.
///
/// @return  exit code: success, no_success where something is left to be filled in
int init_command(int argc, char** argv);

/// Of "rivid identify ROBOT.urdf LOG.csv…".
struct RobotAndLogs {
  std::filesystem::path robot;
  std::vector<std::filesystem::path> logs;
  std::string tip;
};
/// The same where the identification follows: it tells no next command.
int init_before_identification(const Given& how, const RobotAndLogs& given);

/// rivid check EXPERIMENT.toml.
///
/// @return  exit code: success, no_success where a finding makes an identification useless
int check_command(int argc, char** argv);

/// rivid try CODE EXPERIMENT.toml: the hint of a finding, taken and judged.
///
/// @return  exit code: success, no_success where the hint does not help
int try_command(int argc, char** argv);

/// rivid factors EXPERIMENT.toml --log LOG.csv: a log reduced to what least squares needs of it.
int factors_command(int argc, char** argv);

/// rivid merge FILE.factors…
///
/// @return  exit code: success, no_success where the robot is not identified
int merge_command(int argc, char** argv);

/// rivid payload EXPERIMENT.toml --loaded LOG.csv.
///
/// @return  exit code: success, no_success where the payload is not identified
int payload_command(int argc, char** argv);

/// rivid export RESULT --to FORMAT: the identified robot as a model for another program.
///
/// @return  exit code: success, no_success where the result is not identified or has a physically
///          inconsistent link
int export_command(int argc, char** argv);

/// rivid compare MODEL… --log LOG.csv, and its simplest form, rivid validate RESULT
/// LOG.csv.
int compare_command(int argc, char** argv);
int validate_command(int argc, char** argv);

/// Where a file is that a result names: as it was named then, or seen from where the result's folder stands.
[[nodiscard]] std::filesystem::path found_again(const std::filesystem::path& named,
                                                const std::filesystem::path& result);

/// Prints a result: its first screen, or with --verbose all of it, and its notes.
///
/// @param beside  what is printed below it
void print_result(const Given& how, const Robot& robot, const Identification& result, const std::string& json,
                  const std::string& beside = {});

/// The command that comes after a result, with what it does.
///
/// @param folder  of the result
[[nodiscard]] std::string next_command(const Identification& result, const std::filesystem::path& folder);

/// rivid explain [CODE].
int explain_command(int argc, char** argv);

}  // namespace rivid::apps
