#pragma once

#include <string>
#include <string_view>
#include <vector>

// The tools. Each is a subcommand of rivid and, by a link of its old name, a program.
namespace rivid::apps {

int identify_tool(int argc, char** argv);
int excite_tool(int argc, char** argv);
int simulate_tool(int argc, char** argv);
int montecarlo_tool(int argc, char** argv);
int online_tool(int argc, char** argv);

/// Subcommands that a tool has as a program of its own.
[[nodiscard]] std::vector<std::string> subcommands_of(std::string_view tool);

/// rivid convert LOG LOG.csv, by the Python package.
int convert_command(int argc, char** argv);
int play_command(int argc, char** argv);

/// rivid demo [DIR]: a simulated robot from its description to the report.
int demo_command(int argc, char** argv);

}  // namespace rivid::apps
