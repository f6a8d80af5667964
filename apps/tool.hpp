#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rivid/finding.hpp"
#include "rivid/report/json.hpp"

// What the command line tools share.
namespace rivid::apps {

/// How a tool ends.
enum ExitCode {
  success = 0,
  no_success = 1,  ///< not identified, not simulated to its end: the result says why
  bad_input = 2,
  numerics = 3
};

/// Command line flags that changed the experiment, and their values.
using Overrides = std::vector<std::pair<std::string, std::string>>;

/// Runs a tool, whose exit code is what `tool` returns, and turns what it throws into a message on standard error and an
/// exit code.
///
/// @param name  of the tool, for messages
int run_tool(std::string_view name, int (*tool)(int argc, char** argv), int argc, char** argv);

/// Parses the command line. An exit code where the tool ends with that, because help or version were asked for.
///
/// @throws InputError  where the command line can not be understood
[[nodiscard]] std::optional<int> parse(CLI::App& app, int argc, char** argv);

/// Standard output.
///
/// @throws InputError  where it can not be written to
void print(const std::string& text);

/// One line each on standard error: "warning: …".
void tell(std::string_view kind, const std::vector<std::string>& lines);
/// The same with codes: "warning [code] …".
void tell(std::string_view kind, const std::vector<Warning>& warnings);

/// Files for a result: the folder of the flag, or one beside the user that is called after the experiment.
[[nodiscard]] std::filesystem::path output_folder(const std::filesystem::path& flag,
                                                  const std::filesystem::path& experiment,
                                                  std::string_view suffix);

/// @throws InputError  where an input can not be read
[[nodiscard]] Provenance provenance_of(const std::string& program,
                                       const std::vector<std::filesystem::path>& inputs, Overrides overrides);

}  // namespace rivid::apps
