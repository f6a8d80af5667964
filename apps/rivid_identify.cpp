#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <optional>
#include <sstream>

#include "joined.hpp"
#include "programs.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/friction_curves.hpp"
#include "rivid/identify/row_table.hpp"
#include "rivid/output.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/report/html.hpp"
#include "rivid/report/json.hpp"
#include "rivid/report/plan.hpp"
#include "rivid/report/text.hpp"
#include "rivid/text.hpp"
#include "subcommands.hpp"
#include "tool.hpp"

namespace {

using namespace rivid;
using namespace rivid::apps;

struct IdentifyArguments : Given {
  std::string method;
  std::string robust;
  std::vector<std::filesystem::path> logs;
  std::vector<std::filesystem::path> validate;
  int threads = 1;
  std::filesystem::path write_rows;
  std::filesystem::path write_friction;
  std::filesystem::path plan;
  bool physical = false;
  bool report = false;
};

Command command_of(IdentifyArguments& to) {
  return {
      .name = "rivid identify",
      .description = "Identifies the dynamic parameters of a robot from logs of its motion.",
      .arguments =
          {{"experiment", "EXPERIMENT.toml", "Experiment file (TOML): robot, log, signal chain, method",
            &to.experiment, true},
           {"--method", "auto|ols|wls|iv|didim|output_error", "Method instead of the experiment file's",
            &to.method},
           {"--robust", "huber|bisquare|off",
            "Loss of robust estimation instead of the experiment file's, or off", &to.robust},
           {"--physical", "", "Also the physically consistent standard parameters", &to.physical},
           {"--log", "FILE", "Log files instead of the experiment file's; - is standard input", &to.logs},
           {"--validate", "FILE", "Validation logs instead of the experiment file's", &to.validate},
           set_argument(to.set),
           {"--output", "DIR", "Folder for result.json; default: EXPERIMENT_result", &to.output},
           {"--report", "", "Write report.html beside result.json: plots to look at", &to.report},
           {"--write-rows", "FILE", "Write the rows of the fit, .npz for NumPy or .csv", &to.write_rows},
           {"--write-friction", "FILE", "Write the friction curves of all joints, .csv", &to.write_friction},
           {"--plan", "FILE", "plan.json of rivid excite: writes plan_check.json, its forecast compared",
            &to.plan},
           {"--threads", "N", "Threads that share the work; 0: one a processor; no result depends on them",
            &to.threads},
           {"--json", "", "Print the result as JSON instead of the table", &to.json},
           {"--quiet", "", "Print nothing but errors", &to.quiet},
           {"--verbose", "", "Print all parameters and tests, and the plan of --dry-run before the work",
            &to.verbose},
           {"--dry-run", "", "Read and check everything, print what would be done, write nothing",
            &to.dry_run}},
      .footer =
          "Exit codes: 0 identified, 1 doubtful or not identified, 2 bad input or usage, 3 numerical "
          "failure.\n"
          "Before it: rivid init ROBOT.urdf LOG.csv, rivid check EXPERIMENT.toml.\n"
          "After it: rivid validate RESULT LOG.csv, rivid export RESULT --to FORMAT,\n"
          "rivid compare MODELS --log LOG.csv, rivid payload EXPERIMENT.toml --loaded "
          "LOG.csv.\n"
          "Many logs: rivid factors EXPERIMENT.toml --log LOG.csv, rivid merge FILES.\n"
          "rivid explain CODE prints cause and cure; docs/experiment.md lists the keys of the "
          "file."};
}

// Flags override the experiment file; what they changed is kept for the provenance.
Overrides apply(const IdentifyArguments& arguments, Experiment& experiment) {
  Overrides overrides;
  const auto in_a_row = [](const std::vector<std::filesystem::path>& files) {
    return detail::joined(files, " ", [](const std::filesystem::path& file) { return file.string(); });
  };
  if (!arguments.method.empty()) {
    experiment.take_method(arguments.method);
    overrides.emplace_back("method", arguments.method);
    experiment.origins["method.name"] = "--method";
  }
  if (!arguments.robust.empty()) {
    const std::optional<RobustKind> kind = named<RobustKind>(arguments.robust);
    std::optional<Robust>& robust = experiment.estimation.robust;
    if (!kind) {
      robust.reset();
    } else if (!robust || robust->kind != *kind) {
      robust = Robust{.kind = *kind};
    }
    overrides.emplace_back("robust", arguments.robust);
    experiment.origins["method.robust"] = "--robust";
  }
  if (arguments.physical && !experiment.estimation.physical) {
    experiment.estimation.physical = Physical{};
    overrides.emplace_back("physical", "true");
    experiment.origins["method.physical"] = "--physical";
  }
  if (!arguments.logs.empty()) {
    experiment.log.files = arguments.logs;
    overrides.emplace_back("log", in_a_row(arguments.logs));
    experiment.origins["log.files"] = "--log";
  }
  if (!arguments.validate.empty()) {
    experiment.validation.files = arguments.validate;
    overrides.emplace_back("validate", in_a_row(arguments.validate));
    experiment.origins["validation.files"] = "--validate";
  }
  return overrides;
}

// What would be done.
std::string plan_in_words(const Experiment& experiment, const std::vector<PlannedFile>& files,
                          Reading& reading) {
  std::ostringstream out;
  const Robot& robot = experiment.robot;
  const BaseParameters base = base_parameters(robot);
  std::vector<std::string> tips;
  for (const std::size_t tip : robot.chain.tips()) {
    tips.push_back(robot.link_name(tip));
  }
  out << "robot       " << experiment.robot_file.string() << ": \"" << robot.name << "\", " << robot.size()
      << " joints from \"" << robot.base << "\" to " << quoted_list(tips) << ", " << base.size()
      << " base parameters of " << base.standard.size() << " standard ones (gap of the rank decision "
      << number(base.rank_gap(), 2) << ")\n";
  if (const auto doubt = base.doubt()) {
    out << "            warning: " << *doubt << '\n';
  }
  const auto print_logs = [&](const char* what, const LogSource& source) {
    for (const Log& log : reading.logs(source, robot)) {
      out << what << log.source << ": " << log.samples() << " samples at " << number(log.f_m) << " Hz, "
          << number(static_cast<double>(log.samples()) / log.f_m, 4) << " s\n";
      for (const std::string& note : log.notes) {
        out << "            " << note << '\n';
      }
      const Robot linear = without_load(robot);
      (void)rows(linear, base_parameters(linear), log, experiment.estimation.signal);
    }
  };
  print_logs("log         ", experiment.log);
  print_logs("validation  ", experiment.validation);
  out << "method      " << name(experiment.estimation.method) << '\n';
  out << "\nsettings\n" << in_lines(settings(experiment)) << '\n' << would_write(files);
  return out.str();
}

// The ending of a file, one of those that a flag takes.
std::string ending_of(const std::filesystem::path& file, std::string_view flag,
                      const std::vector<std::string>& endings) {
  std::string ending = file.extension().string();
  if (std::ranges::find(endings, ending) == endings.end()) {
    throw InputError(std::string(flag) + ": " + file.string() + " must end in " +
                     (endings.size() == 1 ? endings.front() : endings.front() + " or " + endings.back()));
  }
  return ending;
}

// What is written, and where.
struct Destination {
  std::filesystem::path result;
  std::filesystem::path report;
  std::filesystem::path check;
  std::vector<PlannedFile> files;
};

Destination destination_of(const IdentifyArguments& arguments) {
  const std::filesystem::path folder = output_folder(arguments.output, arguments.experiment, "_result");
  Destination out{folder / "result.json", folder / "report.html", folder / "plan_check.json", {}};
  out.files = {{out.result, ".json"}};
  if (arguments.report) {
    out.files.push_back({out.report, ".html"});
  }
  if (!arguments.write_rows.empty()) {
    out.files.push_back(
        {arguments.write_rows, ending_of(arguments.write_rows, "--write-rows", {".npz", ".csv"})});
  }
  if (!arguments.write_friction.empty()) {
    out.files.push_back(
        {arguments.write_friction, ending_of(arguments.write_friction, "--write-friction", {".csv"})});
  }
  if (!arguments.plan.empty()) {
    out.files.push_back({out.check, ".json"});
  }
  return out;
}

int identify_from(const IdentifyArguments& arguments) {
  expect_experiment(arguments.experiment);
  Experiment experiment = read_experiment(arguments.experiment, Use::identification, arguments.set);
  const auto overrides = apply(arguments, experiment);
  experiment.estimation.threads = arguments.threads;
  const Destination to = destination_of(arguments);
  std::vector<std::filesystem::path> inputs = experiment.inputs();
  std::optional<PlanFile> plan;
  if (!arguments.plan.empty()) {
    plan = read_plan(arguments.plan);
    inputs.push_back(plan->path);
  }
  Outputs outputs = planned(inputs, to.files);
  ProgressBar bar(!arguments.quiet && !arguments.dry_run);
  Reading reading(std::ref(bar));
  if (arguments.dry_run) {
    const std::string text = plan_in_words(experiment, to.files, reading);
    if (!arguments.quiet) {
      print(text);
    }
    return success;
  }

  if (arguments.verbose) {
    const std::string text = plan_in_words(experiment, to.files, reading);
    bar.clear();
    tell(text);
  }
  take_friction(experiment, reading);
  take_gains(experiment, reading);
  if (plan) {
    require_parameters(*plan, base_parameters(experiment.robot));
  }
  const Identification result = run(experiment, reading);
  const ShownPredictions predicted = arguments.report || !arguments.write_friction.empty()
                                         ? shown_predictions(experiment, result, reading)
                                         : ShownPredictions();
  bar.clear();

  Provenance provenance =
      provenance_of("rivid_identify", experiment, Use::identification, overrides, arguments.set);
  std::string beside;
  if (!arguments.write_rows.empty()) {
    const RowTable rows = row_table(experiment.robot, result, reading.logs(experiment.log, experiment.robot));
    put_with_hash(arguments.write_rows,
                  arguments.write_rows.extension() == ".npz" ? to_npz(rows) : to_csv(rows), outputs,
                  provenance);
  }
  if (!arguments.write_friction.empty()) {
    put_with_hash(arguments.write_friction,
                  to_csv(friction_curves(experiment.robot, result, predicted.predictions)), outputs,
                  provenance);
  }
  if (plan) {
    const PlanCheck check = check_against(*plan, experiment.robot, result);
    put_with_hash(to.check, to_json(*plan, check), outputs, provenance);
    beside = '\n' + in_words(*plan, check);
  }
  const std::string json = to_json(experiment.robot, result, provenance);
  outputs.put(to.result, json);
  if (arguments.report) {
    outputs.put(to.report, html_report(experiment.robot, result, predicted.predictions, provenance));
  }
  outputs.commit();
  print_result(arguments, experiment.robot, result, json, beside);
  if (!arguments.quiet) {
    for (const std::string& log : predicted.left_out) {
      tell("note",
           std::vector<std::string>{
               log + ": has no part in plots and friction curves, whose memory the logs before it take"});
    }
    tell_written(to.files);
    tell("next: " + next_command(result, to.result.parent_path()) + "\n");
  }
  return result.status == Status::identified ? success : no_success;
}

// A word that is no file and looks like a subcommand is one that was mistyped.
void expect_no_mistyped_command(const std::string& word) {
  if (word.empty() || word.find_first_of("-./") != std::string::npos || std::filesystem::exists(word)) {
    return;
  }
  if (const std::string guess = did_you_mean(word, subcommands_of("rivid_identify")); !guess.empty()) {
    throw InputError(in_quotes(word) + " is neither a file nor a subcommand" + guess);
  }
}

// The experiment file is drafted first.
int identify_robot(IdentifyArguments arguments, const RobotAndLogs& given) {
  arguments.experiment = given.robot.filename().replace_extension(".toml");
  if (!arguments.dry_run && std::filesystem::exists(arguments.experiment)) {
    throw InputError(arguments.experiment.string() + ": is there already; rivid identify " +
                     arguments.experiment.string() + " identifies from it, or remove it");
  }
  if (const int drafted = init_before_identification(arguments, given);
      drafted != success || arguments.dry_run) {
    return drafted;
  }
  const int identified = identify_from(arguments);
  if (arguments.report && !arguments.quiet) {
    show_page(destination_of(arguments).report);
  }
  return identified;
}

}  // namespace

int rivid::apps::identify_tool(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  IdentifyArguments arguments;
  Command command = command_of(arguments);
  if (argc > 2 && is_robot(first)) {
    RobotAndLogs given;
    command.arguments[0] = {"robot", "ROBOT.urdf", "", &given.robot, true};
    command.arguments.push_back({"logs", "LOG.csv", "", &given.logs, true});
    command.arguments.push_back({"--tip", "LINK", "Last link of the arm", &given.tip});
    return run_command(command, argc, argv, [&] { return identify_robot(arguments, given); });
  }
  expect_no_mistyped_command(first);
  return run_command(command, argc, argv, [&] { return identify_from(arguments); });
}
