#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "rivid/output.hpp"
#include "rivid/report/json.hpp"
#include "terminal.hpp"

// What the command line tools share. tool.cpp alone includes the parser of command lines, which takes long to
// compile.
namespace rivid::apps {

/// How a tool ends.
enum ExitCode {
  success = 0,
  no_success = 1,  ///< not identified, not simulated to its end: the result says why
  bad_input = 2,
  numerics = 3
};

/// One positional or option of a command line, and the variable that it sets. A vector takes several values;
/// what a number may be stands in command_line_numbers().
struct Argument {
  using Target = std::variant<bool*, int*, double*, std::uint64_t*, std::optional<int>*,
                              std::optional<std::int64_t>*, std::string*, std::filesystem::path*,
                              std::vector<std::string>*, std::vector<std::filesystem::path>*>;
  std::string name;   ///< "--log", or "experiment" for a positional
  std::string value;  ///< what stands for it in --help: "FILE", or its words: "ols|wls|iv"; empty: a flag
  std::string text = {};
  Target target = {};  ///< none: a --force that holds for all outputs of the run
  bool required = false;
  std::string needs = {};     ///< option without which this one is refused
  std::string excludes = {};  ///< option with which this one is refused
  bool one_each = false;      ///< of a vector: each occurrence has one value
};

struct Command {
  std::string name;  ///< "rivid identify", or "rivid check" for a subcommand
  std::string description;
  std::vector<Argument> arguments;
  std::string footer;
};

/// What most command lines give.
struct Given {
  std::filesystem::path experiment;
  std::vector<std::string> set;
  std::filesystem::path output;
  bool json = false;
  bool quiet = false;
  bool verbose = false;
  bool dry_run = false;
};

/// Parses the command line, then runs the command, whose exit code is returned.
///
/// @throws InputError  where the command line can not be understood
int run_command(const Command& command, int argc, char** argv, const std::function<int()>& run);

/// Refuses a file that is clearly no experiment file, with what to do instead.
///
/// @throws InputError  for a robot, a log or a result
void expect_experiment(const std::filesystem::path& file);

/// Runs a tool, whose exit code is what `tool` returns, and turns what it throws into a message on standard
/// error and an exit code.
///
/// @param name  of the tool, for messages
int run_tool(std::string_view name, int (*tool)(int argc, char** argv), int argc, char** argv);

/// Prints an answer: as JSON with --json, whether --quiet or not; else in words, unless --quiet.
void print_answer(const Given& how, const std::string& json, const std::string& words);

/// Says which files were written, unless --quiet.
void tell_written(const Given& how, const std::vector<PlannedFile>& files);

/// The end of a run: its files take their places, then its answer and their names are printed.
void finish(const Given& how, Outputs& outputs, const std::vector<PlannedFile>& files,
            const std::string& json, const std::string& words);

/// Whether a file is a robot's description by its name.
[[nodiscard]] bool is_robot(const std::filesystem::path& file);

/// --set of a tool: settings that are laid over the experiment file.
[[nodiscard]] Argument set_argument(std::vector<std::string>& to);

/// All settings, one line each: key, value with its unit, and whether that is the default or where else it
/// comes from.
[[nodiscard]] std::string in_lines(const std::vector<Setting>& settings);

/// The outputs of a run, planned: see Outputs. Without --force only files that rivid wrote are replaced:
/// documents and models, which name it, and tables whose SHA-256 such a document among `files` has.
///
/// @throws InputError  where writing one of them would destroy something
[[nodiscard]] Outputs planned(const std::vector<std::filesystem::path>& inputs,
                              const std::vector<PlannedFile>& files, bool force = false);

/// "would write FILE", one line each: the end of what --dry-run prints.
[[nodiscard]] std::string would_write(const std::vector<PlannedFile>& files);

/// Files for a result: the folder of the flag, or one beside the user that is called after the experiment.
///
/// @throws InputError  where that is one of another experiment of the same name, without --force
[[nodiscard]] std::filesystem::path output_folder(const std::filesystem::path& flag,
                                                  const std::filesystem::path& experiment,
                                                  std::string_view suffix);

/// result.json, of a folder that was given too.
[[nodiscard]] std::filesystem::path result_file(const std::filesystem::path& given);

/// Command line flags that changed the experiment, and their values.
using Overrides = std::vector<std::pair<std::string, std::string>>;

/// Puts a file that has no place for the run id; the provenance names it with its SHA-256.
void put_with_hash(const std::filesystem::path& file, std::string_view content, Outputs& outputs,
                   Provenance& provenance);

/// Adds values of --set, which count as overrides, and files that were read.
///
/// @throws InputError  where an input can not be read
void add_origins(const std::vector<std::string>& set, const std::vector<std::filesystem::path>& inputs,
                 Provenance& to);

/// @param set  values of --set, which count as overrides too
/// @throws InputError  where an input can not be read
[[nodiscard]] Provenance provenance_of(const std::string& program, const Experiment& experiment, Use use,
                                       Overrides overrides, const std::vector<std::string>& set);

}  // namespace rivid::apps
