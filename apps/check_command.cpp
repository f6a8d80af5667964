#include "check_command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/report/text.hpp"
#include "rivid/text.hpp"
#include "tool.hpp"

namespace rivid::apps {

int check_command(int argc, char** argv) {
  std::filesystem::path file;
  bool json = false;
  bool quiet = false;
  int threads = 1;
  CLI::App app("Looks for faults of robot, logs and motion before anything is identified.",
               "rivid_identify check");
  app.add_option("experiment", file, "Experiment file (TOML): robot, log, signal chain, method")
      ->required()
      ->type_name("EXPERIMENT.toml");
  app.add_option("--threads", threads, "Threads that share the work")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  app.add_flag("--json", json, "Print the findings as JSON");
  app.add_flag("--quiet", quiet, "Print nothing but errors; the exit code tells");
  app.footer(
      "Exit codes: 0 fine, warnings allowed; 1 a finding makes an identification useless; 2 bad input or "
      "usage; 3 numerical failure.\n"
      "rivid_identify explain CODE tells cause and cure of a finding.");
  if (const std::optional<int> ended = parse(app, argc, argv)) {
    return *ended;
  }
  const Experiment experiment = read_experiment(file);
  const std::vector<Log> logs = read_logs(experiment.log, experiment.robot);
  const std::vector<Log> validation = read_logs(experiment.validation, experiment.robot);
  const std::vector<Finding> findings = check(
      experiment.robot, logs, validation,
      {.signal = experiment.signal, .instrumental = experiment.method == Method::iv, .threads = threads});
  if (!quiet) {
    print(json ? to_json(findings) : in_words(findings));
  }
  const bool useless = std::ranges::any_of(
      findings, [](const Finding& finding) { return finding.severity == Severity::error; });
  return useless ? no_success : success;
}

int explain_command(int argc, char** argv) {
  std::string code;
  CLI::App app("Tells cause and cure of what rivid_identify finds.", "rivid_identify explain");
  app.add_option("code", code, "Code of a finding; default: list them all")->type_name("CODE");
  if (const std::optional<int> ended = parse(app, argc, argv)) {
    return *ended;
  }
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
                   "; rivid_identify explain lists all codes");
}

}  // namespace rivid::apps
