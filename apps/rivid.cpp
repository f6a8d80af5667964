// The program: the tools as its subcommands, and by links of their old names.

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "programs.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"
#include "subcommands.hpp"
#include "tool.hpp"

namespace rivid::apps {

namespace {

struct Program {
  std::string_view word;      ///< the subcommand
  std::string_view old_name;  ///< the tool, or its subcommand, that it is
  int (*run)(int argc, char** argv);
  std::string_view operands;  ///< for the help, as what it does
  std::string_view what;
};

constexpr auto programs = std::to_array<Program>({
    {"init", "rivid_identify init", init_command, "ROBOT.urdf LOG.csv", "an experiment file to begin with"},
    {"check", "rivid_identify check", check_command, "EXPERIMENT.toml", "faults of robot, logs and settings"},
    {"identify", "rivid_identify", identify_tool, "EXPERIMENT.toml", "the parameters; or ROBOT.urdf LOG.csv"},
    {"payload", "rivid_identify payload", payload_command, "EXPERIMENT.toml --loaded LOG.csv",
     "a payload, or drive gains"},
    {"validate", "rivid_identify validate", validate_command, "RESULT LOG.csv",
     "a result judged on another log"},
    {"compare", "rivid_identify compare", compare_command, "MODELS --log LOG.csv",
     "which model predicts better"},
    {"export", "rivid_identify export", export_command, "RESULT --to FORMAT",
     "a model for a simulator or a controller"},
    {"excite", "rivid_excite", excite_tool, "EXPERIMENT.toml", "an exciting trajectory"},
    {"simulate", "rivid_simulate", simulate_tool, "EXPERIMENT.toml", "a log of the robot in its closed loop"},
    {"study", "rivid_montecarlo", montecarlo_tool, "EXPERIMENT.toml", "a Monte Carlo study of the intervals"},
    {"online", "rivid_online", online_tool, "LOG.csv --result RESULT",
     "a log replayed to estimators of a control loop"},
    {"factors", "rivid_identify factors", factors_command, "EXPERIMENT.toml --log LOG.csv",
     "one of many logs, reduced"},
    {"merge", "rivid_identify merge", merge_command, "FILES", "an identification from reduced logs"},
    {"convert", "rivid convert", convert_command, "LOG LOG.csv", "a bag, .mat, .npz or Parquet file as CSV"},
    {"play", "rivid play", play_command, "PLAN --on ARM",
     "a designed motion on a robot, watched and recorded"},
    {"explain", "rivid_identify explain", explain_command, "CODE", "cause and cure of a finding or a status"},
    {"try", "rivid_identify try", try_command, "CODE EXPERIMENT.toml",
     "the hint of a finding, taken and judged"},
    {"demo", "rivid demo", demo_command, "DIR", "a simulated robot, from description to report"},
});

// That is called by a link of its old name, or by that and a subcommand.
const Program* program_of(std::string_view name) {
  const auto at = std::ranges::find(programs, name, &Program::old_name);
  return at == programs.end() ? nullptr : &*at;
}

// "rivid init ROBOT.urdf LOG.csv   an experiment file to begin with", a line each.
std::string overview() {
  constexpr std::size_t column = 48;  // where descriptions begin; a choice of layout
  std::string out;
  for (const Program& each : programs) {
    std::string line = "rivid " + std::string(each.word) + " " + std::string(each.operands);
    line.resize(std::max(line.size() + 1, column), ' ');
    out += line + std::string(each.what) + "\n";
  }
  return out +
         "rivid help COMMAND prints its options; docs/experiment.md lists the keys of an experiment file.\n"
         "Exit codes: 0 done, 1 no success, 2 bad input or usage, 3 numerical failure.";
}

// What to do with a word that is no subcommand.
std::string instead_of(const std::string& word) {
  const std::string ending = std::filesystem::path(word).extension().string();
  if (ending == ".toml") {
    return "; rivid identify " + word + " identifies the robot";
  }
  if (ending == ".urdf") {
    return "; rivid identify " + word + " LOG.csv identifies it";
  }
  std::vector<std::string> words = {"help"};
  for (const Program& each : programs) {
    words.emplace_back(each.word);
  }
  return did_you_mean(word, words) + "; rivid help lists them";
}

int rivid_tool(int argc, char** argv) {
  const std::string word = argc > 1 ? argv[1] : "--help";
  const auto program = std::ranges::find(programs, word, &Program::word);
  if (program != programs.end()) {
    return program->run(argc - 1, argv + 1);
  }
  if (!word.starts_with('-')) {
    throw InputError(in_quotes(word) + " is no subcommand" + instead_of(word));
  }
  std::array<std::string, 2> help = {"rivid", word};
  std::array<char*, 2> arguments = {help[0].data(), help[1].data()};
  std::string command;
  return run_command({.name = "rivid",
                      .description = "Identifies the dynamic parameters of robot arms from logs.",
                      .arguments = {{"command", "COMMAND", "One of those below", &command}},
                      .footer = overview()},
                     argc > 1 ? argc : 2, argc > 1 ? argv : arguments.data(), [] { return success; });
}

}  // namespace

std::vector<std::string> subcommands_of(std::string_view tool) {
  std::vector<std::string> out;
  for (const Program& each : programs) {
    if (each.old_name.starts_with(std::string(tool) + " ")) {
      out.emplace_back(each.word);
    }
  }
  return out;
}

// Becomes the program of the Python package; returns only where there is no Python.
int python_program(int argc, char** argv) {
  std::array<std::string, 3> python = {
      "python3", "-c",
      "import sys\ntry:\n  from rivid.__main__ import main\nexcept ImportError:\n"
      "  sys.exit(f'rivid: error: {sys.argv[1]} needs the Python package of rivid: pip install .')\n"
      "sys.exit(main())"};
  std::vector<char*> words = {python[0].data(), python[1].data(), python[2].data()};
  words.insert(words.end(), argv, argv + argc);
  words.push_back(nullptr);
  ::execvp(words[0], words.data());
  throw InputError(std::string(argv[0]) + " needs Python, which is not found");
}

int convert_command(int argc, char** argv) {
  std::string source;
  std::string target;
  bool list = false;
  return run_command(
      {.name = "rivid convert",
       .description =
           "Writes a bag (MCAP, rosbag2, ROS 1), .mat, .npz, .npy, Parquet or Feather file as CSV.",
       .arguments = {{"log", "LOG", "The log", &source, true},
                     {"csv", "LOG.csv", "The file to write", &target},
                     {"--list", "", "Print what the file holds, write nothing", &list},
                     {"--force", "", "Replace a CSV file of another content"}},
       .footer = "The Python package of rivid does it."},
      argc, argv, [&] { return python_program(argc, argv); });
}

int play_command(int argc, char** argv) {
  std::string plan;
  std::string arm;
  std::string speeds;
  std::string tracking;
  std::string torque_band;
  return run_command(
      {.name = "rivid play",
       .description = "Plays the motion of a plan on a robot: at a tenth of its speed, at half, at its own. "
                      "Stops it where positions or torques are not as foretold, and records log.csv.",
       .arguments = {{"plan", "PLAN", "Folder that rivid excite wrote", &plan, true},
                     {"--on", "ARM", "ros, ur:HOST, franka:HOST or simulation", &arm, true},
                     {"--speeds", "LIST", "Shares of the motion's speed; default: 0.1,0.5,1", &speeds},
                     {"--tracking", "RAD", "Largest distance from the positions told; default: 0.1",
                      &tracking},
                     {"--torque-band", "LIST", "Largest distance of the torques from the forecast [N·m]",
                      &torque_band},
                     {"--yes", "", "Do not ask before each speed"},
                     {"--force", "", "Replace logs of an earlier run"}},
       .footer =
           "The Python package of rivid does it, with ur_rtde, pylibfranka or rclpy of the robot's maker."},
      argc, argv, [&] { return python_program(argc, argv); });
}

}  // namespace rivid::apps

int main(int argc, char** argv) {
  using namespace rivid::apps;
#ifdef __GLIBC__
  // Matrices come and go. Where each gave its pages back, the kernel's zeroing of new ones would take a fifth
  // of a short run.
  constexpr int large = 1 << 25;
  mallopt(M_MMAP_THRESHOLD, large);
  mallopt(M_TRIM_THRESHOLD, 4 * large);
  mallopt(M_TOP_PAD, large / 2);
#endif
  // "rivid help check" is "rivid check --help".
  std::string help = "--help";
  std::vector<char*> words(argv, argv + argc);
  if (argc > 1 && std::string_view(argv[1]) == "help") {
    words.erase(words.begin() + 1);
    words.push_back(help.data());
  }
  const std::string name = argc > 0 ? std::filesystem::path(argv[0]).filename().string() : "";
  const int count = static_cast<int>(words.size());
  const Program* const link = program_of(name);
  const Program* const command = count > 1 ? program_of(name + " " + words[1]) : nullptr;
  if (command != nullptr) {
    return run_tool(name, command->run, count - 1, words.data() + 1);
  }
  return run_tool(link != nullptr ? name : "rivid", link != nullptr ? link->run : rivid_tool, count,
                  words.data());
}
