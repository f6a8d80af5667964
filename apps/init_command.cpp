#include "init_command.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/report/file.hpp"
#include "tool.hpp"

namespace rivid::apps {

int init_command(int argc, char** argv) {
  std::filesystem::path robot;
  std::vector<std::filesystem::path> logs;
  std::filesystem::path output;
  UrdfOptions options;
  bool print_only = false;
  bool force = false;
  CLI::App app("Writes an experiment file to begin with, from a robot and its logs.", "rivid_identify init");
  app.add_option("robot", robot,
                 "The robot: a URDF, or a table of modified Denavit-Hartenberg parameters (.csv)")
      ->required()
      ->type_name("ROBOT.urdf");
  app.add_option("logs", logs, "Logs of its motion; the last of several is kept for validation")
      ->required()
      ->type_name("LOG.csv");
  app.add_option("--base", options.base, "Link that stands still; default: the root")->type_name("LINK");
  app.add_option("--tip", options.tip, "Last link of the arm; needed where the robot branches")
      ->type_name("LINK");
  app.add_option("--output", output, "The experiment file; default: ROBOT.toml in this folder")
      ->type_name("FILE.toml");
  app.add_flag("--print", print_only, "Print it instead");
  app.add_flag("--force", force, "Write it over a file that is there");
  app.footer(
      "Columns are recognised by their names: q1 or actual_q_0 or elbow_joint/position [deg].\n"
      "Exit codes: 0 complete; 1 something is left to be filled in; 2 bad input or usage.");
  if (const std::optional<int> ended = parse(app, argc, argv)) {
    return *ended;
  }
  if (output.empty()) {
    output = robot.filename().replace_extension(".toml");
  }
  if (!print_only && !force && std::filesystem::exists(output)) {
    throw InputError(output.string() +
                     ": is there already; --output names another file, --force writes over it");
  }
  const ExperimentDraft draft = draft_experiment(output, robot, options, logs);
  if (print_only) {
    print(draft.text);
  } else {
    write_file(output, draft.text);
  }
  tell("note", draft.doubts);
  if (!print_only) {
    std::cerr << "wrote " << output.string() << (draft.complete ? "" : ", incomplete") << '\n'
              << "next: rivid_identify check " << output.string() << '\n';
  }
  return draft.complete ? success : no_success;
}

}  // namespace rivid::apps
