#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "programs.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/experiment/rehearsal.hpp"
#include "rivid/output.hpp"
#include "rivid/report/excitation.hpp"
#include "rivid/report/plan.hpp"
#include "rivid/report/players.hpp"
#include "rivid/report/rehearsal.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/text.hpp"
#include "tool.hpp"

namespace {

using namespace rivid;
using namespace rivid::apps;
using Clock = std::chrono::steady_clock;

struct DesignArguments : Given {
  std::filesystem::path motion;  // of the subcommands forecast and rehearse
  std::filesystem::path first;   // plans of the subcommand compare
  std::filesystem::path second;
  std::optional<std::int64_t> seconds;
  std::optional<int> starts;
  std::optional<std::int64_t> seed;
  int threads = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
  std::vector<std::string> players;
  bool report = false;
  RehearsalOptions rehearsal;
  bool as_planned = false;
};

const std::string exit_codes = "Exit codes: 0 done, 2 bad input or usage, 3 numerical failure.\n";

Command command_of(DesignArguments& to) {
  return {
      .name = "rivid excite",
      .description =
          "Designs an exciting trajectory for a robot, and forecasts the standard deviation of each "
          "parameter.",
      .arguments = {{"experiment", "EXPERIMENT.toml", "Experiment file (TOML): robot, excitation",
                     &to.experiment, true},
                    {"--seconds", "NUMBER", "Time for the search: the best motion found until then is taken",
                     &to.seconds},
                    {"--starts", "NUMBER", "Random motions to begin with, instead of the experiment file's",
                     &to.starts},
                    {"--seed", "NUMBER", "Seed instead of the experiment file's", &to.seed},
                    {"--threads", "NUMBER", "Starts at a time; default: one for each processor", &to.threads},
                    {.name = "--player",
                     .value = "ros|urscript|libfranka",
                     .text =
                         "Also write the motion for this controller: joint_trajectory.yaml, motion.script, "
                         "libfranka.csv; may be repeated",
                     .target = &to.players,
                     .one_each = true},
                    set_argument(to.set),
                    {"--output", "DIR", "Folder for the files; default: EXPERIMENT_excitation", &to.output},
                    {"--report", "", "Also write report.html: tables and plots to look at", &to.report},
                    {"--json", "", "Print plan.json", &to.json},
                    {"--quiet", "", "Print nothing but errors", &to.quiet},
                    {"--dry-run", "", "Read and check everything, print what would be done, write nothing",
                     &to.dry_run}},
      .footer =
          "Ctrl-C ends the search and keeps the best motion so far.\n"
          "\"rivid excite forecast EXPERIMENT.toml MOTION.csv\" forecasts the same for a motion that is "
          "there already.\n"
          "\"rivid excite rehearse EXPERIMENT.toml MOTION.csv\" plays it with a hidden robot in the "
          "simulator.\n"
          "\"rivid excite compare A B\" prints what plan B is worth in experiment time of plan A.\n" +
          exit_codes + "The keys of an experiment file are listed in docs/experiment.md."};
}

Command forecast_command(DesignArguments& to) {
  return {.name = "rivid excite forecast",
          .description = "Forecasts the standard deviation of each parameter from a motion.",
          .arguments = {{"experiment", "EXPERIMENT.toml", "Experiment file (TOML): robot, excitation",
                         &to.experiment, true},
                        {"motion", "MOTION.csv", "Positions over time, with the columns of [log]", &to.motion,
                         true},
                        set_argument(to.set),
                        {"--output", "DIR", "Folder for forecast.json; without it nothing is written",
                         &to.output},
                        {.name = "--report",
                         .value = "",
                         .text = "Also write report.html: tables and plots to look at",
                         .target = &to.report,
                         .needs = "--output"},
                        {"--json", "", "Print forecast.json", &to.json},
                        {"--quiet", "", "Print nothing but errors", &to.quiet}},
          .footer = exit_codes};
}

Command rehearse_command(DesignArguments& to) {
  return {.name = "rivid excite rehearse",
          .description =
              "Rehearses a motion with a hidden robot in the simulator: as planned, then with troubles.",
          .arguments =
              {{"experiment", "EXPERIMENT.toml", "Experiment file (TOML): robot, excitation, control",
                &to.experiment, true},
               {"motion", "MOTION.csv", "Positions over time, with the columns of [log]", &to.motion, true},
               {"--as-planned", "", "Plant no troubles", &to.as_planned},
               {"--spread", "NUMBER", "Largest relative error of masses, inertias and friction; default: 0.3",
                &to.rehearsal.spread},
               {"--seed", "NUMBER", "Seed of hidden robot and noise; default: 1", &to.rehearsal.seed},
               set_argument(to.set),
               {"--output", "DIR",
                "Folder for rehearsal.json and log.csv, the log as planned; without it nothing is written",
                &to.output},
               {"--json", "", "Print rehearsal.json", &to.json},
               {"--quiet", "", "Print nothing but errors", &to.quiet}},
          .footer =
              "Exit codes: 0 go, 1 no go: the first lines say why, 2 bad input or usage,\n"
              "3 numerical failure.\n"};
}

Command compare_command(DesignArguments& to) {
  return {
      .name = "rivid excite compare",
      .description = "Compares two plans for a robot: what B is worth in experiment time of A.",
      .arguments = {{"A", "FILE", "plan.json or forecast.json, or the folder of a design", &to.first, true},
                    {"B", "FILE", "The same", &to.second, true},
                    {"--json", "", "Print JSON", &to.json}},
      .footer = exit_codes};
}

// The first interrupt ends the search, the next one the program.
volatile std::sig_atomic_t interrupted = 0;
void interrupt(int /*signal*/) {
  interrupted = 1;
  exit_on_signals();
}

// Flags override the experiment file; what they changed is kept for the provenance.
Overrides apply(const DesignArguments& arguments, ExcitationPlan& plan) {
  Overrides overrides;
  const auto note = [&](const std::string& key, const std::string& value) {
    overrides.emplace_back(key, value);
    plan.experiment.origins["excitation." + key] = "--" + key;
  };
  if (arguments.starts) {
    plan.options.starts = *arguments.starts;
    note("starts", std::to_string(*arguments.starts));
  }
  if (arguments.seed) {
    plan.options.seed = static_cast<std::uint64_t>(*arguments.seed);
    note("seed", std::to_string(*arguments.seed));
  }
  if (arguments.seconds) {
    overrides.emplace_back("seconds", std::to_string(*arguments.seconds));
  }
  return overrides;
}

Provenance provenance_of_plan(const ExcitationPlan& plan, Overrides overrides) {
  Provenance out{
      .program = "rivid_excite", .inputs = {}, .overrides = std::move(overrides), .settings = settings(plan)};
  add_origins(plan.settings, plan.inputs(), out);
  return out;
}

Excitation designed(const DesignArguments& arguments, ExcitationPlan& plan) {
  ProgressBar bar(!arguments.quiet);
  plan.options.threads = arguments.threads;
  plan.options.progress = std::ref(bar);
  const auto end = Clock::now() + std::chrono::seconds(arguments.seconds.value_or(0));
  plan.options.stopped = [&] { return interrupted != 0 || (arguments.seconds && Clock::now() >= end); };
  struct sigaction before = {};
  sigaction(SIGINT, nullptr, &before);
  if (before.sa_handler != SIG_IGN) {
    struct sigaction action = {};
    action.sa_handler = interrupt;
    sigaction(SIGINT, &action, nullptr);
  }
  return design(plan.experiment.robot, plan.options);
}

// The players of the command line, which can all play the plan's motions.
std::vector<Player> players_of(const DesignArguments& arguments, const ExcitationPlan& plan) {
  std::vector<Player> out;
  for (const std::string& name : arguments.players) {
    const Player player = named<Player>(name).value();
    if (const auto fault = complaint(player, plan.experiment.robot, plan.options)) {
      throw InputError(arguments.experiment.string() + ": " + *fault);
    }
    if (std::ranges::find(out, player) == out.end()) {
      out.push_back(player);
    }
  }
  return out;
}

int design_from(const DesignArguments& arguments) {
  ExcitationPlan plan = read_excitation(arguments.experiment, arguments.set);
  Overrides overrides = apply(arguments, plan);
  const std::vector<Player> players = players_of(arguments, plan);
  const std::filesystem::path folder = output_folder(arguments.output, arguments.experiment, "_excitation");
  const std::filesystem::path motion = folder / "motion.csv";
  const std::filesystem::path experiment = folder / "experiment.toml";
  const std::filesystem::path file = folder / "plan.json";
  const std::filesystem::path report = folder / "report.html";
  plan.options.known = known_information(plan);
  std::vector<PlannedFile> files = {{motion, ".csv"}, {experiment, ".toml"}, {file, ".json"}};
  if (arguments.report) {
    files.push_back({report, ".html"});
  }
  for (const Player player : players) {
    const std::filesystem::path path = folder / file_name(player);
    files.push_back({path, path.extension().string()});
  }
  Outputs outputs = planned(plan.inputs(), files);
  if (arguments.dry_run) {
    const MotionBounds bounds = motion_bounds(plan.experiment.robot, plan.options.limits);
    if (const auto fault = missing_limit(plan.experiment.robot, bounds)) {
      throw InputError(arguments.experiment.string() + ": " + *fault);
    }
    if (!arguments.quiet) {
      print("settings\n" + in_lines(settings(plan)) + "\n" + would_write(files));
      tell(bounds.findings);
    }
    return success;
  }
  const Excitation found = designed(arguments, plan);
  Provenance provenance = provenance_of_plan(plan, std::move(overrides));
  put_with_hash(motion, motion_csv(found), outputs, provenance);
  put_with_hash(experiment, experiment_text(plan, found, folder), outputs, provenance);
  for (const Player player : players) {
    put_with_hash(folder / file_name(player), player_file(player, plan.experiment.robot, plan.options, found),
                  outputs, provenance);
  }
  const std::string json = to_json(plan, found, provenance);
  outputs.put(file, json);
  if (arguments.report) {
    outputs.put(report, html_report(plan, found, provenance));
  }
  finish(arguments, outputs, files, json, summary(found, screen_width()));
  return success;
}

int forecast_from(const DesignArguments& arguments) {
  ExcitationPlan plan = read_excitation(arguments.experiment, arguments.set);
  const std::filesystem::path file = arguments.output / "forecast.json";
  const std::filesystem::path report = arguments.output / "report.html";
  std::vector<std::filesystem::path> inputs = plan.inputs();
  inputs.push_back(arguments.motion);
  std::vector<PlannedFile> files;
  if (!arguments.output.empty()) {
    files.push_back({file, ".json"});
  }
  if (arguments.report) {
    files.push_back({report, ".html"});
  }
  Outputs outputs = planned(inputs, files);
  plan.options.known = known_information(plan);
  const Log log = read_csv(arguments.motion, plan.experiment.log.columns);
  if (const auto fault = log.complaint()) {
    throw InputError(*fault);
  }
  const Motion motion = differentiate(log.q, log.f_m);
  const Forecast found = forecast(plan.experiment.robot, motion, log.f_m, plan.options);
  Provenance provenance = provenance_of_plan(plan, {});
  provenance.inputs.push_back(input_file(arguments.motion));
  const std::string json = to_json(plan, found, provenance);
  if (!arguments.output.empty()) {
    outputs.put(file, json);
    if (arguments.report) {
      outputs.put(report, html_report(plan, motion, found, provenance));
    }
  }
  finish(arguments, outputs, files, json, summary(found, screen_width()));
  return success;
}

int rehearse_from(const DesignArguments& arguments) {
  const ExcitationPlan plan = read_excitation(arguments.experiment, arguments.set);
  RehearsalOptions options = arguments.rehearsal;
  options.troubles = !arguments.as_planned;
  const std::filesystem::path file = arguments.output / "rehearsal.json";
  const std::filesystem::path log = arguments.output / "log.csv";
  std::vector<std::filesystem::path> inputs = plan.inputs();
  inputs.push_back(arguments.motion);
  const bool writes = !arguments.output.empty();
  const std::vector<PlannedFile> files =
      writes ? std::vector<PlannedFile>{{file, ".json"}, {log, ".csv"}} : std::vector<PlannedFile>{};
  Outputs outputs = planned(inputs, files);
  ProgressBar bar(!arguments.quiet);
  const Rehearsal found = rehearse(plan, arguments.motion, options, std::ref(bar));
  bar.clear();
  Provenance provenance = provenance_of_plan(plan, {{"seed", std::to_string(options.seed)}});
  provenance.inputs.push_back(input_file(arguments.motion));
  if (writes) {
    put_with_hash(log, found.as_planned.log, outputs, provenance);
  }
  const std::string json = to_json(plan, found, provenance);
  if (writes) {
    outputs.put(file, json);
  }
  finish(arguments, outputs, files, json, summary(found, screen_width()));
  return found.passes() ? success : no_success;
}

int compare_plans(const DesignArguments& arguments) {
  const PlanFile a = read_plan(arguments.first);
  const PlanFile b = read_plan(arguments.second);
  const PlanComparison comparison = compare(a, b);
  print(arguments.json ? to_json(a, b, comparison) : in_words(a, b, comparison));
  return success;
}

}  // namespace

int rivid::apps::excite_tool(int argc, char** argv) {
  DesignArguments arguments;
  if (argc > 1 && std::string_view(argv[1]) == "compare") {
    return run_command(compare_command(arguments), argc - 1, argv + 1,
                       [&] { return compare_plans(arguments); });
  }
  if (argc > 1 && std::string_view(argv[1]) == "rehearse") {
    return run_command(rehearse_command(arguments), argc - 1, argv + 1,
                       [&] { return rehearse_from(arguments); });
  }
  if (argc > 1 && std::string_view(argv[1]) == "forecast") {
    return run_command(forecast_command(arguments), argc - 1, argv + 1,
                       [&] { return forecast_from(arguments); });
  }
  return run_command(command_of(arguments), argc, argv, [&] { return design_from(arguments); });
}
