#include <algorithm>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/identify/comparison.hpp"
#include "rivid/identify/rollouts.hpp"
#include "rivid/input.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/report/comparison.hpp"
#include "rivid/text.hpp"
#include "subcommands.hpp"
#include "tool.hpp"

namespace rivid::apps {

namespace {

using Path = std::filesystem::path;

struct CompareArguments : Given {
  std::vector<Path> models;
  std::vector<Path> logs;
  int threads = 1;
  bool report = false;
  bool rollout = false;
};

// A model that was asked for, and the result that it is from, where it is from one.
struct JudgedModel {
  Path file;
  std::optional<IdentifiedRobot> result;
};

JudgedModel opened(const Path& given) {
  const Path file = result_file(given);
  if (file.extension() == ".toml" && read_input(file).bytes().find("[robot]") != std::string_view::npos) {
    throw InputError(file.string() +
                     ": is an experiment file, a result or parameters are required; rivid identify " +
                     file.string() + " writes the result");
  }
  const bool is_result = file.extension() == ".json";
  return {file, is_result ? std::optional(read_identified_robot(file, {.parameters = {}, .force = true}))
                          : std::nullopt};
}

// How logs are read: by the file of the flag, else by that of the first result. A result of a program without
// one has the usual names of columns.
Experiment experiment_of(const CompareArguments& arguments, const std::vector<JudgedModel>& models) {
  if (!arguments.experiment.empty()) {
    return read_experiment(arguments.experiment, Use::identification, arguments.set);
  }
  for (const JudgedModel& model : models) {
    if (model.result && !model.result->experiment && arguments.set.empty()) {
      Experiment out;
      out.file = out.robot_file = model.file;
      out.robot = model.result->robot;
      out.log.irregular = Irregular::resample;
      out.estimation.signal = model.result->signal;
      return out;
    }
    if (model.result && model.result->experiment) {
      const Path file = found_again(model.result->experiment->path, model.file);
      if (!std::filesystem::exists(file)) {
        throw InputError(model.file.string() + ": its experiment file " + file.string() +
                         " is not there; --experiment says how logs are read");
      }
      return read_experiment(file, Use::identification, arguments.set);
    }
  }
  static_cast<void>(read_input(models.front().file));
  throw InputError(
      "none of the models is a result, which knows how logs are read; --experiment EXPERIMENT.toml says it");
}

// What a URDF alone predicts: its bodies and its friction, without rotors.
Robot urdf_robot(const Path& file, const Robot& like) {
  Robot out = read_urdf(file, same_part(like));
  for (Joint& joint : out.joints) {
    joint.friction = Friction::coulomb;
    joint.rotor_inertia = false;
  }
  return out;
}

// Drives and gears, which turn control signals into torques, are those of the experiment: all models are
// judged by the same torques.
void take_drives(const Robot& from, Robot& to) {
  if (to.size() != from.size()) {
    return;  // compare() says so
  }
  for (std::size_t j = 0; j < to.joints.size(); ++j) {
    to.joints[j].drive_gain = from.joints[j].drive_gain;
    to.joints[j].gear_ratio = from.joints[j].gear_ratio;
  }
  to.gear_matrix = from.gear_matrix;
}

ComparedModel compared(const JudgedModel& model, const Path& given, const Robot& robot) {
  ComparedModel out{.name = given.string(), .robot = robot, .chi_st = {}};
  if (model.result) {
    out.robot = model.result->robot;
    out.chi_st = model.result->chi_st;
  } else if (model.file.extension() == ".urdf") {
    out.robot = urdf_robot(model.file, robot);
    out.chi_st = out.robot.chi_st();
  } else {
    out.chi_st = read_parameters(model.file, base_parameters(robot));
  }
  take_drives(robot, out.robot);
  return out;
}

// Motions of the models on the logs, beside those of the robot's description where there is one model alone.
Rollouts rolled_out(std::vector<ComparedModel> models, const std::vector<Log>& logs,
                    const Experiment& experiment) {
  if (models.size() == 1) {
    models.push_back({"robot description", experiment.robot, experiment.robot.chi_st()});
  }
  RolloutOptions options;
  options.window = experiment.estimation.signal.window;
  if (experiment.control) {
    options.control = experiment.control->control;
    options.sampling = experiment.control->sampling;
  }
  return rollouts(models, logs, options);
}

// From the first result to each of the others.
std::vector<ResultChanges> changes_of(const std::vector<JudgedModel>& models,
                                      const std::vector<ComparedModel>& named) {
  std::vector<ResultChanges> out;
  const auto first = std::ranges::find_if(models, [](const JudgedModel& m) { return m.result.has_value(); });
  for (auto other = first; other != models.end(); ++other) {
    if (other != first && first->result && other->result) {
      out.push_back({named[static_cast<std::size_t>(first - models.begin())].name,
                     named[static_cast<std::size_t>(other - models.begin())].name,
                     parameter_changes(first->result->estimates, other->result->estimates)});
    }
  }
  return out;
}

// What keeps the figures from being a judgement: errors of the logs by themselves, and models that are worse
// than none.
std::vector<Finding> doubts_of(const Robot& robot, std::span<const Log> logs, const Comparison& comparison) {
  std::vector<Finding> out = examined(robot, logs, {.signal = comparison.signal}).warnings;
  std::erase_if(out, [](const Finding& f) { return severity(f) != Severity::error; });
  for (const Comparison::Error& model : comparison.models) {
    if (!(model.relative_error <= 1.0)) {
      out.push_back({"poor_fit", model.name,
                     "its error is " + number_that_says(100.0 * model.relative_error, 3) +
                         " % of the torques: no torque at all would be nearer"});
    }
  }
  return out;
}

int compare_models(const CompareArguments& arguments, const std::string& program) {
  std::vector<JudgedModel> models;
  models.reserve(arguments.models.size());
  for (const Path& given : arguments.models) {
    models.push_back(opened(given));
  }
  Experiment experiment = experiment_of(arguments, models);
  experiment.log.files = arguments.logs;
  experiment.validation.files.clear();
  std::vector<PlannedFile> files;
  if (!arguments.output.empty()) {
    files.push_back({arguments.output / "comparison.json", ".json"});
    if (arguments.report) {
      files.push_back({arguments.output / "comparison.html", ".html"});
    }
  } else if (arguments.report) {
    throw InputError("--report needs --output, the folder that the page is written to");
  }
  std::vector<Path> inputs = experiment.inputs();
  for (const JudgedModel& model : models) {
    inputs.push_back(model.file);
  }
  Outputs outputs = planned(inputs, files);

  std::vector<ComparedModel> named;
  named.reserve(models.size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    named.push_back(compared(models[i], arguments.models[i], experiment.robot));
  }
  const ComparisonOptions options{.signal = experiment.estimation.signal, .threads = arguments.threads};
  const std::vector<Log> logs = read_logs(experiment.log, experiment.robot);
  Comparison comparison = compare(named, logs, options);
  if (arguments.rollout) {
    comparison.rollouts = rolled_out(named, logs, experiment);
  }
  const std::vector<ResultChanges> changes = changes_of(models, named);
  const std::vector<Finding> doubts = doubts_of(named.front().robot, logs, comparison);

  Provenance provenance = provenance_of(program, experiment, Use::identification, {}, arguments.set);
  for (const JudgedModel& model : models) {
    provenance.inputs.push_back(input_file(model.file));
  }
  const std::string json = to_json(comparison, changes, doubts, provenance);
  if (!arguments.output.empty()) {
    outputs.put(files.front().path, json);
    if (arguments.report) {
      outputs.put(files.back().path, html_report(comparison, changes, doubts, options.level, provenance));
    }
    outputs.commit();
  }
  print_answer(arguments, json, in_words(comparison, changes, doubts, options.level, screen_width()));
  if (!arguments.quiet) {
    if (arguments.json) {
      tell(doubts);
    }
    tell_written(files);
  }
  return doubts.empty() ? success : no_success;
}

// What both commands take beside models and logs.
std::vector<Argument> with_common(std::vector<Argument> own, CompareArguments& to) {
  const std::vector<Argument> common = {
      {"--experiment", "EXPERIMENT.toml",
       "How the logs are read and filtered; default: as those of the first result", &to.experiment},
      set_argument(to.set),
      {"--output", "DIR", "Write comparison.json into this folder", &to.output},
      {"--report", "", "Write comparison.html beside it", &to.report},
      {"--rollout", "",
       "Judge by simulated motions as well, after 0.1 to 3 s; one model beside the robot's description",
       &to.rollout},
      {"--threads", "N", "Threads that share the work", &to.threads},
      {"--json", "", "Print the comparison as JSON", &to.json},
      {"--quiet", "", "Print nothing but errors", &to.quiet}};
  own.insert(own.end(), common.begin(), common.end());
  return own;
}

constexpr const char* compare_exit_codes =
    "Exit codes: 0 compared; 1 compared, but the logs have errors or a model's error is above 100 %; 2 bad "
    "input or usage; 3 numerical failure.";

}  // namespace

int compare_command(int argc, char** argv) {
  CompareArguments to;
  return run_command(
      {.name = "rivid compare",
       .description =
           "Judges models by the torques that they predict on logs, and says which one predicts better.",
       .arguments = with_common(
           {{"models", "FILE", "Models: result.json or its folder, a URDF, or a parameter file (.toml, .csv)",
             &to.models, true},
            {"--log", "LOG.csv", "Logs to judge them by", &to.logs, true}},
           to),
       .footer = compare_exit_codes},
      argc, argv, [&] { return compare_models(to, "rivid compare"); });
}

int validate_command(int argc, char** argv) {
  CompareArguments to;
  Path result;
  return run_command({.name = "rivid validate",
                      .description = "Validates a result on logs that took no part in it.",
                      .arguments = with_common(
                          {{"result", "RESULT.json",
                            "result.json of rivid identify, or the folder that it is in", &result, true},
                           {"logs", "LOG.csv", "Logs to validate it on", &to.logs, true}},
                          to),
                      .footer = compare_exit_codes},
                     argc, argv, [&] {
                       to.models = {result};
                       return compare_models(to, "rivid validate");
                     });
}

}  // namespace rivid::apps
