#include "subcommands.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/hint.hpp"
#include "rivid/output.hpp"
#include "rivid/report/text.hpp"
#include "rivid/text.hpp"
#include "tool.hpp"

namespace rivid::apps {

namespace {

struct InitArguments : Given {
  std::filesystem::path robot;
  std::vector<std::filesystem::path> logs;
  UrdfOptions options;
  bool print_only = false;
  bool force = false;
  bool identified_next = false;  // so that nothing is to be typed
};

int init(InitArguments arguments) {
  std::filesystem::path& output = arguments.output;
  if (output.empty()) {
    output = arguments.robot.filename().replace_extension(".toml");
  }
  if (!arguments.print_only && !arguments.force && std::filesystem::exists(output)) {
    throw InputError(output.string() +
                     ": is there already; --output names another file, --force writes over it");
  }
  std::vector<std::filesystem::path> inputs = arguments.logs;
  inputs.push_back(arguments.robot);
  Outputs outputs(inputs, arguments.force);
  if (!arguments.print_only) {
    outputs.plan(output, ".toml");
  }
  const ExperimentDraft draft = draft_experiment(output, arguments.robot, arguments.options, arguments.logs);
  if (arguments.print_only) {
    print(draft.text);
  } else {
    outputs.put(output, draft.text);
    outputs.commit();
  }
  if (arguments.quiet) {
    return draft.complete ? success : no_success;
  }
  tell("note", draft.doubts);
  if (!arguments.print_only) {
    tell("wrote " + output.string() + (draft.complete ? "" : ", incomplete") + "\n" +
         (arguments.identified_next && draft.complete ? ""
          : arguments.logs.empty() ? "next: rivid excite " + output.string() + " --output plan --report\n"
                                   : "next: rivid check " + output.string() + "\n"));
  }
  return draft.complete ? success : no_success;
}

struct CheckArguments : Given {
  int threads = 1;
};

int check(const CheckArguments& arguments) {
  expect_experiment(arguments.experiment);
  const Experiment experiment = read_experiment(arguments.experiment, Use::identification, arguments.set);
  const std::vector<Finding> findings = check(experiment, arguments.threads);
  print_answer(arguments, to_json(findings), in_words(findings, screen_width()));
  const bool useless = std::ranges::any_of(
      findings, [](const Finding& finding) { return severity(finding) == Severity::error; });
  return useless ? no_success : success;
}

struct TryArguments : Given {
  std::string code;
  std::string of;
  std::filesystem::path write;
};

int try_one(const TryArguments& arguments) {
  expect_experiment(arguments.experiment);
  const auto folder = [](const std::filesystem::path& file) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(file)).parent_path();
  };
  std::vector<PlannedFile> files;
  if (!arguments.write.empty()) {
    if (folder(arguments.write) != folder(arguments.experiment)) {
      throw InputError("--write: " + arguments.write.string() + " must be in the folder of " +
                       arguments.experiment.string() + ", which its paths are relative to");
    }
    files.push_back({arguments.write, ".toml"});
  }
  Outputs outputs = planned({arguments.experiment}, files);
  ProgressBar bar(!arguments.quiet);
  const HintTrial trial = try_hint(arguments.experiment, arguments.code, arguments.of, std::ref(bar));
  bar.clear();
  print_answer(arguments, to_json(trial), in_words(trial));
  if (!trial.helps()) {
    return no_success;
  }
  if (!arguments.write.empty()) {
    outputs.put(arguments.write, trial.text);
    outputs.commit();
  }
  tell_written(arguments, files);
  return success;
}

int explain(const std::string& code) {
  if (code.empty()) {
    std::string list;
    for (const DiagnosticCode& known : diagnostic_codes()) {
      list += in_one_line(known);
    }
    print(list);
    return success;
  }
  if (const std::optional<DiagnosticCode> known = diagnostic_code(code)) {
    print(explained(*known));
    return success;
  }
  std::vector<std::string> names;
  for (const DiagnosticCode& known : diagnostic_codes()) {
    names.emplace_back(known.code);
  }
  throw InputError("explain: nothing is called " + in_quotes(code) + did_you_mean(code, names) +
                   "; rivid explain lists all codes");
}

}  // namespace

void print_result(const Given& how, const Robot& robot, const Identification& result, const std::string& json,
                  const std::string& beside) {
  print_answer(
      how, json,
      (how.verbose ? in_words(result, screen_width()) : first_screen(robot, result, screen_width())) +
          beside);
  if (how.quiet) {
    return;
  }
  constexpr std::size_t few = 2;  // notes that are printed; a choice
  const std::vector<std::string> count = {std::to_string(result.notes.size()) +
                                          " notes on the data are in the result; --verbose prints them"};
  tell("note", how.verbose || result.notes.size() <= few ? result.notes : count);
  if (how.json) {
    tell(result.warnings);
  }
}

std::string next_command(const Identification& result, const std::filesystem::path& folder) {
  if (result.status != Status::identified) {
    return "rivid explain " + std::string(name(result.status)) + " prints cause and cure";
  }
  return result.validation.empty()
             ? "rivid validate " + folder.string() + " LOG.csv, with a log of another motion"
             : "rivid export " + folder.string() + " --to " + (result.physical ? "urdf" : "header");
}

int init_command(int argc, char** argv) {
  InitArguments to;
  return run_command(
      {.name = "rivid init",
       .description = "Writes an experiment file to begin with, from a robot and its logs, or without a log "
                      "for the design of a motion.",
       .arguments = {{"robot", "ROBOT.urdf",
                      "The robot: a URDF, or a table of modified Denavit-Hartenberg parameters (.csv)",
                      &to.robot, true},
                     {"logs", "LOG.csv",
                      "Logs of its motion; the last of several is kept for validation; none: rivid excite "
                      "designs one",
                      &to.logs},
                     {"--base", "LINK", "Link that stands still; default: the root", &to.options.base},
                     {"--tip", "LINK", "Last link of an arm; default: all joints of the logs",
                      &to.options.tip},
                     {"--output", "FILE.toml", "The experiment file; default: ROBOT.toml in this folder",
                      &to.output},
                     {"--print", "", "Print it instead", &to.print_only},
                     {"--force", "", "Write it over a file that is there", &to.force},
                     {"--quiet", "", "Print nothing but errors; the exit code is the answer", &to.quiet}},
       .footer = "Columns are recognised by their names: q1 or actual_q_0 or elbow_joint/position [deg].\n"
                 "Exit codes: 0 complete; 1 something is left to be filled in; 2 bad input or usage."},
      argc, argv, [&] { return init(to); });
}

int init_before_identification(const Given& how, const RobotAndLogs& given) {
  InitArguments to;
  to.robot = given.robot;
  to.logs = given.logs;
  to.options.tip = given.tip;
  to.print_only = how.dry_run;
  to.quiet = how.quiet;
  to.identified_next = true;
  return init(to);
}

int check_command(int argc, char** argv) {
  CheckArguments to;
  return run_command(
      {.name = "rivid check",
       .description = "Looks for faults of robot, logs and motion before anything is identified.",
       .arguments = {{"experiment", "EXPERIMENT.toml",
                      "Experiment file (TOML): robot, log, signal chain, method", &to.experiment, true},
                     set_argument(to.set),
                     {"--threads", "N", "Threads that share the work", &to.threads},
                     {"--json", "", "Print the findings as JSON", &to.json},
                     {"--quiet", "", "Print nothing but errors; the exit code is the answer", &to.quiet}},
       .footer =
           "Exit codes: 0 fine, warnings allowed; 1 a finding makes an identification useless; 2 bad input "
           "or usage; 3 numerical failure.\n"
           "rivid explain CODE prints cause and cure of a finding."},
      argc, argv, [&] { return check(to); });
}

int try_command(int argc, char** argv) {
  TryArguments to;
  return run_command(
      {.name = "rivid try",
       .description = "Takes the hint of a finding: errors before and after, and the lines to paste.",
       .arguments = {{"code", "CODE", "Code of a finding of the identification: torque_gain", &to.code, true},
                     {"experiment", "EXPERIMENT.toml", "Experiment file (TOML), which is not changed",
                      &to.experiment, true},
                     {"--of", "NAME", "Joint or joints that the finding is about; default: the first one",
                      &to.of},
                     {"--write", "FILE.toml", "Write the experiment with the hint taken, if that helps",
                      &to.write},
                     {"--force", "", "Replace a file that is there"},
                     {"--json", "", "Print the trial as JSON", &to.json},
                     {"--quiet", "", "Print nothing but errors; the exit code is the answer", &to.quiet}},
       .footer = "Held out are the validation logs; without any, each half of the logs, which the parameters "
                 "of the other half predict.\n"
                 "Exit codes: 0 it helps; 1 it does not; 2 bad input or usage; 3 numerical failure."},
      argc, argv, [&] { return try_one(to); });
}

int explain_command(int argc, char** argv) {
  std::string code;
  return run_command({.name = "rivid explain",
                      .description = "Prints cause and cure of what rivid identify finds.",
                      .arguments = {{"code", "CODE", "Code of a finding; default: list them all", &code}},
                      .footer = ""},
                     argc, argv, [&] { return explain(code); });
}

}  // namespace rivid::apps
