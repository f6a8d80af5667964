#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <thread>

#include "programs.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/output.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/text.hpp"
#include "tool.hpp"

namespace {

using namespace rivid;
using namespace rivid::apps;
using Clock = std::chrono::steady_clock;

struct StudyArguments : Given {
  std::optional<int> runs;
  int first_run = 0;
  int threads = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
  bool restart = false;
  bool report = false;
  std::vector<std::filesystem::path> parts;  // of the subcommand merge
};

Command command_of(StudyArguments& to) {
  return {
      .name = "rivid study",
      .description =
          "Simulates an experiment many times, identifies each, and reports how far the results can be "
          "trusted.",
      .arguments = {{"experiment", "EXPERIMENT.toml",
                     "Experiment file (TOML): robot, control, reference, simulation, montecarlo",
                     &to.experiment, true},
                    {"--runs", "NUMBER", "Runs instead of the experiment file's", &to.runs},
                    {"--first-run", "NUMBER",
                     "Number of the first run; default: 0. With --runs the part of a study that one machine "
                     "makes",
                     &to.first_run, false, "--runs"},
                    {"--threads", "NUMBER", "Threads at work; default: one for each processor", &to.threads},
                    set_argument(to.set),
                    {"--output", "DIR",
                     "Folder for runs.csv, inputs.sha256 and summary.json; default: EXPERIMENT_montecarlo",
                     &to.output},
                    {"--restart", "", "Begin anew instead of going on with the runs in the folder",
                     &to.restart},
                    {"--report", "", "Write report.html beside summary.json: plots to look at", &to.report},
                    {"--json", "", "Print the summary as JSON", &to.json},
                    {"--quiet", "", "Print nothing but errors", &to.quiet},
                    {"--dry-run", "", "Read and check everything, print what would be done, write nothing",
                     &to.dry_run}},
      .footer =
          "A run that was finished is never made again: stopped and started anew, the program goes on, and "
          "ends with the\n"
          "same summary. Run k has the seed of the file plus k, whatever the threads.\n"
          "Parts of a study: rivid study EXPERIMENT.toml --first-run 200 --runs 100 --output part_2, "
          "and then\n"
          "rivid study merge EXPERIMENT.toml part_0 part_1 part_2.\n"
          "Exit codes: 0 all runs done, 1 no run of a trial is identified, 2 bad input or usage, 3 numerical "
          "failure."};
}

std::string time_left(Clock::time_point begin, int done, int missing) {
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  const double left = seconds / static_cast<double>(done) * static_cast<double>(missing - done);
  return number(left, left < 10.0 ? 1 : 2) + " s left";
}

// All runs that the file does not hold yet.
void make_missing(const MonteCarlo& plan, MonteCarloFile& file, int threads, ProgressBar& bar) {
  const std::vector<int> missing = file.missing();
  const auto wanted = static_cast<int>(missing.size());
  const Clock::time_point begin = Clock::now();
  int done = 0;
  monte_carlo_runs(plan, missing, threads, [&](const std::vector<MonteCarloRow>& rows) {
    file.add(rows);
    ++done;
    bar(std::to_string(done) + " of " + std::to_string(wanted) + " runs, " + time_left(begin, done, wanted),
        static_cast<double>(done) / static_cast<double>(wanted));
  });
  bar.clear();
}

// Number and first of the runs are all that the command line can change in a plan.
Provenance provenance_of_runs(const std::optional<int>& runs, int first, const MonteCarlo& plan) {
  Overrides overrides;
  if (runs) {
    overrides.emplace_back("runs", std::to_string(*runs));
  }
  if (first > 0) {
    overrides.emplace_back("first-run", std::to_string(first));
  }
  return provenance_of("rivid_montecarlo", plan.experiment, Use::simulation, std::move(overrides),
                       plan.settings);
}

std::string in_words(const MonteCarlo& plan, const SimulationOutlook& one, std::ptrdiff_t there) {
  std::string out = "simulation  " + counted(one.samples, "sample") + " at " + number(one.f_m) +
                    " Hz, seeds from " + std::to_string(one.record.seed) + "\n";
  if (!one.record.simulation.reason.empty()) {
    out += "            " + one.record.simulation.reason + "\n";
  }
  return out + "trials      " + std::to_string(plan.trials.size()) + " a run\nruns        " +
         std::to_string(plan.runs) + ", of which " + std::to_string(there) + " are done\n";
}

// What the runs are simulated with, then what each trial identifies them with.
std::string settings_of(const MonteCarlo& plan) {
  std::string out = "\nsettings\n" + in_lines(settings(plan.experiment, Use::simulation));
  for (const MonteCarlo::Trial& trial : plan.trials) {
    std::vector<Setting> own = settings(trial.experiment);
    std::erase_if(own, [](const Setting& s) {
      return s.key.starts_with("robot.") || s.key.starts_with("log.") || s.key.starts_with("validation.");
    });
    out += "\ntrial " + trial.label + "\n" + in_lines(own);
  }
  return out + "\n";
}

// Where a study goes, and what is said of it.
struct StudyFolder {
  const StudyArguments& how;
  std::filesystem::path folder = output_folder(how.output, how.experiment, "_montecarlo");

  [[nodiscard]] std::filesystem::path summary() const { return folder / "summary.json"; }
  [[nodiscard]] std::filesystem::path page() const { return folder / "report.html"; }
  [[nodiscard]] std::vector<PlannedFile> files() const {
    std::vector<PlannedFile> out = {{folder / "runs.csv", ".csv", true},
                                    {folder / "inputs.sha256", ".sha256", true},
                                    {summary(), ".json"}};
    if (how.report) {
      out.push_back({page(), ".html"});
    }
    return out;
  }
};

// What would be done.
void dry_run(const StudyArguments& arguments, const MonteCarlo& plan, const StudyFolder& to) {
  const auto held =
      arguments.restart ? std::map<int, std::vector<MonteCarloRow>>() : held_runs(to.folder, plan);
  const auto there = std::ranges::count_if(held, [&](const auto& run) {
    return arguments.first_run <= run.first && run.first < arguments.first_run + plan.runs;
  });
  const SimulationOutlook one = outlook(plan.experiment);
  if (!arguments.quiet) {
    print(in_words(plan, one, there) + settings_of(plan) + would_write(to.files()));
  }
}

int sum_up(const MonteCarlo& plan, const std::vector<MonteCarloRow>& rows, const Provenance& provenance,
           Outputs& outputs, const StudyFolder& to) {
  const std::vector<MonteCarloSummary> found = summaries(plan, rows);
  const std::string json = to_json(found, run_id(provenance));
  outputs.put(to.summary(), json);
  if (to.how.report) {
    outputs.put(to.page(), html_report(plan, found, rows, provenance));
  }
  finish(to.how, outputs, to.files(), json, in_words(found, screen_width()));
  const auto is_empty = [](const MonteCarloSummary& trial) { return trial.identified == 0; };
  return std::ranges::any_of(found, is_empty) ? no_success : success;
}

int run_from(const StudyArguments& arguments) {
  MonteCarlo plan = read_monte_carlo(arguments.experiment, arguments.set);
  plan.runs = arguments.runs.value_or(plan.runs);
  const StudyFolder to{arguments};
  Outputs outputs = planned(plan.experiment.inputs(Use::simulation), to.files());
  if (arguments.dry_run) {
    dry_run(arguments, plan, to);
    return success;
  }
  MonteCarloFile file(to.folder, plan, arguments.restart, arguments.first_run);
  ProgressBar bar(!arguments.quiet);
  make_missing(plan, file, arguments.threads, bar);
  return sum_up(plan, file.rows(), provenance_of_runs(arguments.runs, arguments.first_run, plan), outputs,
                to);
}

// throws InputError naming the first stretch of runs that no part holds
void require_all(const std::map<int, std::vector<MonteCarloRow>>& held, int runs) {
  const auto missing = [&](int run) { return run < runs && !held.contains(run); };
  int first = 0;
  while (first < runs && !missing(first)) {
    ++first;
  }
  int end = first;
  while (missing(end)) {
    ++end;
  }
  if (end > first) {
    throw InputError("merge: no folder holds runs " + std::to_string(first) + " to " +
                     std::to_string(end - 1) + "; --first-run " + std::to_string(first) + " --runs " +
                     std::to_string(end - first) + " makes them, --runs says how many the study has");
  }
}

int merge(const StudyArguments& arguments) {
  MonteCarlo plan = read_monte_carlo(arguments.experiment, arguments.set);
  const auto held = merged_runs(arguments.parts, plan);
  const int highest = held.empty() ? 0 : held.rbegin()->first + 1;
  const int runs = arguments.runs.value_or(std::max(plan.runs, highest));
  require_all(held, runs);
  // As a study of so many runs would have been asked for.
  const std::optional<int> asked = runs == plan.runs ? std::nullopt : std::optional(runs);
  plan.runs = runs;
  const StudyFolder to{arguments};
  std::vector<std::filesystem::path> inputs = plan.experiment.inputs(Use::simulation);
  for (const std::filesystem::path& part : arguments.parts) {
    inputs.push_back(part / "runs.csv");
    inputs.push_back(part / "inputs.sha256");
    inputs.push_back(part / "summary.json");
  }
  Outputs outputs = planned(inputs, to.files());
  MonteCarloFile file(to.folder, plan, false);
  for (const int run : file.missing()) {
    file.add(held.at(run));
  }
  return sum_up(plan, file.rows(), provenance_of_runs(asked, 0, plan), outputs, to);
}

int merge_runs(int argc, char** argv) {
  StudyArguments to;
  return run_command(
      {.name = "rivid study merge",
       .description = "Sums up the parts of a study that several machines made.",
       .arguments =
           {{"experiment", "EXPERIMENT.toml", "Experiment file of all parts", &to.experiment, true},
            {"parts", "DIR", "Folders that rivid study --output wrote", &to.parts, true},
            {"--runs", "NUMBER",
             "Runs of the study; default: the experiment file's, or more where there are more", &to.runs},
            set_argument(to.set),
            {"--output", "DIR",
             "Folder for the same files of the whole, no part itself; default: EXPERIMENT_montecarlo",
             &to.output},
            {"--report", "", "Write report.html beside summary.json", &to.report},
            {"--json", "", "Print the summary as JSON", &to.json},
            {"--quiet", "", "Print nothing but errors", &to.quiet}},
       .footer =
           "The files are those of one study of all runs, save the seconds that identifications took.\n"
           "Exit codes: 0 all runs are there, 1 no run of a trial is identified, 2 bad input or usage, 3 "
           "numerical failure."},
      argc, argv, [&] { return merge(to); });
}

}  // namespace

int rivid::apps::montecarlo_tool(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "merge") {
    return merge_runs(argc - 1, argv + 1);
  }
  StudyArguments arguments;
  return run_command(command_of(arguments), argc, argv, [&] { return run_from(arguments); });
}
