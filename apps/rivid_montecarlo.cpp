#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>
#include <thread>

#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/output.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/text.hpp"
#include "tool.hpp"

namespace {

using namespace rivid;
using namespace rivid::apps;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::filesystem::path experiment;
  std::optional<int> runs;
  int threads = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
  std::vector<std::string> set;
  std::filesystem::path output;
  bool restart = false;
  bool report = false;
  bool json = false;
  bool quiet = false;
  bool dry_run = false;
};

Command command_of(Arguments& to) {
  return {
      .name = "rivid_montecarlo",
      .description =
          "Simulates an experiment many times, identifies each, and reports how far the results can be "
          "trusted.",
      .arguments = {{.name = "experiment",
                     .value = "EXPERIMENT.toml",
                     .text = "Experiment file (TOML): robot, control, reference, simulation, montecarlo",
                     .target = &to.experiment,
                     .required = true},
                    {"--runs", "NUMBER", "Runs instead of the experiment file's", &to.runs,
                     IntegerRange{1, 1'000'000'000}},
                    {"--threads", "NUMBER", "Runs at a time; default: one for each processor", &to.threads,
                     thread_range},
                    set_argument(to.set),
                    {"--output", "DIR",
                     "Folder for runs.csv and summary.json; default: EXPERIMENT_montecarlo", &to.output},
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

// Runs are all that the command line can change in a plan.
Provenance provenance_of_runs(const Arguments& arguments, const MonteCarlo& plan) {
  Overrides overrides;
  if (arguments.runs) {
    overrides.emplace_back("runs", std::to_string(*arguments.runs));
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

// What would be done.
void dry_run(const Arguments& arguments, const MonteCarlo& plan, const std::filesystem::path& folder,
             const std::vector<PlannedFile>& files) {
  const auto held = arguments.restart ? std::map<int, std::vector<MonteCarloRow>>() : held_runs(folder, plan);
  const auto there = std::ranges::count_if(held, [&](const auto& run) { return run.first < plan.runs; });
  const SimulationOutlook one = outlook(plan.experiment);
  if (!arguments.quiet) {
    print(in_words(plan, one, there) + settings_of(plan) + would_write(files));
  }
}

int run_from(const Arguments& arguments) {
  MonteCarlo plan = read_monte_carlo(arguments.experiment, arguments.set);
  plan.runs = arguments.runs.value_or(plan.runs);
  const std::filesystem::path folder = output_folder(arguments.output, arguments.experiment, "_montecarlo");
  const std::filesystem::path summary = folder / "summary.json";
  const std::filesystem::path report = folder / "report.html";
  std::vector<PlannedFile> files = {{folder / "runs.csv", ".csv"}, {summary, ".json"}};
  if (arguments.report) {
    files.push_back({report, ".html"});
  }
  Outputs outputs = planned(plan.experiment.inputs(Use::simulation), files);
  if (arguments.dry_run) {
    dry_run(arguments, plan, folder, files);
    return success;
  }
  MonteCarloFile file(folder, plan, arguments.restart);
  ProgressBar bar(!arguments.quiet);
  make_missing(plan, file, arguments.threads, bar);

  const std::vector<MonteCarloRow> rows = file.rows();
  const std::vector<MonteCarloSummary> found = summaries(plan, rows);
  const Provenance provenance = provenance_of_runs(arguments, plan);
  const std::string json = to_json(found, run_id(provenance));
  outputs.put(summary, json);
  if (arguments.report) {
    outputs.put(report, html_report(plan, found, rows, provenance));
  }
  outputs.commit();
  if (!arguments.quiet) {
    std::ostringstream table;
    table << std::span<const MonteCarloSummary>(found);
    print(arguments.json ? json : table.str());
    std::cerr << "wrote " << file.path().string() << " and " << summary.string() << '\n';
    if (arguments.report) {
      std::cerr << "wrote " << report.string() << '\n';
    }
  }
  const auto is_empty = [](const MonteCarloSummary& trial) { return trial.identified == 0; };
  return std::ranges::any_of(found, is_empty) ? no_success : success;
}

int tool(int argc, char** argv) {
  Arguments arguments;
  return run_command(command_of(arguments), argc, argv, [&] { return run_from(arguments); });
}

}  // namespace

int main(int argc, char** argv) { return run_tool("rivid_montecarlo", tool, argc, argv); }
