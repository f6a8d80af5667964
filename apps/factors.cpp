#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/experiment/factors_file.hpp"
#include "rivid/input.hpp"
#include "rivid/output.hpp"
#include "rivid/report/html.hpp"
#include "rivid/report/json.hpp"
#include "rivid/report/text.hpp"
#include "rivid/text.hpp"
#include "subcommands.hpp"
#include "tool.hpp"

namespace rivid::apps {

namespace {

using Path = std::filesystem::path;

constexpr const char* factors_ending = ".factors";

struct FactorsArguments : Given {
  std::vector<Path> logs;
  int blocks = 10;
  int threads = 1;
};

Path factors_output(const FactorsArguments& arguments, const Path& first_log) {
  const Path file =
      arguments.output.empty() ? first_log.filename().replace_extension(factors_ending) : arguments.output;
  if (file.extension() != factors_ending) {
    throw InputError("--output: " + file.string() + " must end in " + factors_ending);
  }
  return file;
}

int make_factors(const FactorsArguments& arguments) {
  expect_experiment(arguments.experiment);
  Experiment experiment = read_experiment(arguments.experiment, Use::identification, arguments.set);
  experiment.estimation.threads = arguments.threads;
  std::vector<std::string> settings = arguments.set;
  const bool open = experiment.estimation.signal.automatic();
  std::vector<Path> inputs = experiment.inputs();
  const std::vector<Path> files = arguments.logs.empty() ? experiment.log.files : arguments.logs;
  inputs.insert(inputs.end(), files.begin(), files.end());
  const Path output = factors_output(arguments, files.front());
  const std::vector<PlannedFile> written = {{output, factors_ending}};
  Outputs outputs = planned(inputs, written);
  Reading reading;
  if (open) {
    experiment.estimation.signal = chosen_signal(
        experiment.robot, reading.logs(experiment.log, experiment.robot), experiment.estimation);
    const std::vector<std::string> chosen = row_settings(experiment.estimation.signal);
    settings.insert(settings.end(), chosen.begin(), chosen.end());
  }
  experiment.log.files = files;
  std::vector<FactoredLog> logs;
  logs.reserve(files.size());
  for (const Path& file : files) {
    logs.push_back({file.string(), input_sha256(file)});
  }
  FactorsFile made =
      factors_of(experiment, reading.logs(experiment.log, experiment.robot), logs, arguments.blocks);
  made.experiment = std::filesystem::absolute(arguments.experiment).lexically_normal();
  made.settings = std::move(settings);
  made.run = run_id(provenance_of("rivid_identify factors", experiment, Use::identification,
                                  {{"blocks", std::to_string(arguments.blocks)}}, arguments.set));
  outputs.put(output, encoded(made));
  outputs.commit();
  tell_written(arguments, written);
  return success;
}

struct MergeArguments : Given {
  std::vector<Path> files;
  std::string method;
  bool physical = false;
  bool report = false;
};

FactorsFile merged(const std::vector<Path>& files) {
  FactorsFile out = read_factors(files.front());
  for (std::size_t k = 1; k < files.size(); ++k) {
    merge(out, read_factors(files[k]), files[k].string());
  }
  return out;
}

// With the settings that the factors were made with, and those of the command line over them.
Experiment experiment_of(const MergeArguments& arguments, const FactorsFile& factors,
                         std::vector<std::string>& settings) {
  const Path file = arguments.experiment.empty() ? factors.experiment : arguments.experiment;
  if (!std::filesystem::exists(file)) {
    throw InputError(arguments.files.front().string() + ": its experiment file " + file.string() +
                     " is not there; --experiment names it");
  }
  settings = factors.settings;
  settings.insert(settings.end(), arguments.set.begin(), arguments.set.end());
  Experiment out = read_experiment(file, Use::identification, settings);
  if (!arguments.method.empty()) {
    out.take_method(arguments.method);
  }
  if (arguments.physical && !out.estimation.physical) {
    out.estimation.physical = Physical{};
  }
  out.log.files.clear();
  for (const FactoredLog& log : factors.logs) {
    out.log.files.emplace_back(log.path);
  }
  return out;
}

// The logs are not there any more, but for their digests.
Provenance provenance_of_merge(const MergeArguments& arguments, const Experiment& experiment,
                               const FactorsFile& factors, const std::vector<std::string>& settings_given) {
  Overrides overrides;
  if (!arguments.method.empty()) {
    overrides.emplace_back("method", arguments.method);
  }
  if (arguments.physical) {
    overrides.emplace_back("physical", "true");
  }
  Experiment others = experiment;
  others.log.files.clear();
  Provenance out = provenance_of("rivid_identify merge", others, Use::identification, std::move(overrides),
                                 settings_given);
  out.settings = settings(experiment);
  for (const FactoredLog& log : factors.logs) {
    out.inputs.push_back({log.path, log.sha256});
  }
  return out;
}

int merge_into_file(const MergeArguments& arguments) {
  const std::vector<PlannedFile> files = {{arguments.output, factors_ending}};
  Outputs outputs = planned(arguments.files, files);
  FactorsFile out = merged(arguments.files);
  Provenance provenance{.program = "rivid_identify merge", .inputs = {}, .overrides = {}};
  add_origins({}, arguments.files, provenance);
  out.run = run_id(provenance);
  outputs.put(arguments.output, encoded(out));
  outputs.commit();
  tell_written(arguments, files);
  return success;
}

int identify_merged(const MergeArguments& arguments) {
  const FactorsFile factors = merged(arguments.files);
  std::vector<std::string> settings;
  const Experiment experiment = experiment_of(arguments, factors, settings);
  const Path folder = output_folder(arguments.output, experiment.file, "_result");
  std::vector<PlannedFile> files = {{folder / "result.json", ".json"}};
  if (arguments.report) {
    files.push_back({folder / "report.html", ".html"});
  }
  std::vector<Path> inputs = arguments.files;
  std::ranges::copy(experiment.inputs(), std::back_inserter(inputs));
  Outputs outputs = planned(inputs, files);
  const Identification result = identify_factors(experiment, factors, arguments.files.front().string());
  const Provenance provenance = provenance_of_merge(arguments, experiment, factors, settings);
  const std::string json = to_json(experiment.robot, result, provenance);
  outputs.put(files.front().path, json);
  if (arguments.report) {
    outputs.put(files.back().path, html_report(experiment.robot, result, {}, provenance));
  }
  outputs.commit();
  print_result(arguments, experiment.robot, result, json);
  if (!arguments.quiet) {
    tell_written(files);
    tell("next: " + next_command(result, folder) + "\n");
  }
  return result.status == Status::identified ? success : no_success;
}

}  // namespace

int factors_command(int argc, char** argv) {
  FactorsArguments to;
  return run_command(
      {.name = "rivid factors",
       .description = "Reduces logs to factors, which rivid merge identifies from.",
       .arguments = {{"experiment", "EXPERIMENT.toml",
                      "Experiment file (TOML): robot, log, signal chain, method", &to.experiment, true},
                     {"--log", "FILE", "Log files instead of the experiment file's", &to.logs},
                     set_argument(to.set),
                     {"--blocks", "N",
                      "Blocks of time for standard deviations; 1 is enough where logs are many", &to.blocks},
                     {"--threads", "N", "Threads that share the work; no result depends on them",
                      &to.threads},
                     {"--output", "FILE.factors", "The factors; default: LOG.factors in this folder",
                      &to.output},
                     {"--quiet", "", "Print nothing but errors", &to.quiet}},
       .footer =
           "Where the rows are chosen by the noise, decimation = \"auto\", the log files of the experiment "
           "file choose them:\n"
           "the same rows whatever --log names.\n"
           "Exit codes: 0 written; 2 bad input or usage; 3 numerical failure."},
      argc, argv, [&] { return make_factors(to); });
}

int merge_command(int argc, char** argv) {
  MergeArguments to;
  return run_command(
      {.name = "rivid merge",
       .description = "Identifies a robot from factors of its logs, or merges these into one file.",
       .arguments = {{"factors", "FILE", "Files of rivid factors, of one robot and with one signal chain",
                      &to.files, true},
                     {"--experiment", "EXPERIMENT.toml", "Experiment file; default: that of the factors",
                      &to.experiment},
                     {"--method", "auto|ols|wls", "Method instead of the experiment file's", &to.method},
                     {"--physical", "", "The physically consistent standard parameters as well",
                      &to.physical},
                     set_argument(to.set),
                     {"--output", "DIR",
                      "Folder for result.json, default: EXPERIMENT_result; or FILE.factors to merge",
                      &to.output},
                     {"--report", "", "Write report.html beside result.json", &to.report},
                     {"--json", "", "Print the result as JSON instead of the table", &to.json},
                     {"--quiet", "", "Print nothing but errors", &to.quiet},
                     {"--verbose", "", "Print all parameters and tests", &to.verbose}},
       .footer = "Exit codes: 0 identified or merged, 1 not identified, 2 bad input or usage, 3 numerical "
                 "failure."},
      argc, argv,
      [&] { return to.output.extension() == factors_ending ? merge_into_file(to) : identify_merged(to); });
}

}  // namespace rivid::apps
