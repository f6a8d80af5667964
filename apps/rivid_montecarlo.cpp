#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>
#include <thread>

#include "progress_bar.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/report/file.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"
#include "tool.hpp"

namespace {

using namespace rivid;
using namespace rivid::apps;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::filesystem::path experiment;
  std::optional<int> runs;
  int threads = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
  std::filesystem::path output;
  bool restart = false;
  bool report = false;
  bool json = false;
  bool quiet = false;
  bool dry_run = false;
};

void declare(CLI::App& app, Arguments& arguments) {
  app.add_option("experiment", arguments.experiment,
                 "Experiment file (TOML): robot, control, reference, simulation, montecarlo")
      ->required()
      ->type_name("EXPERIMENT.toml");
  app.add_option("--runs", arguments.runs, "Runs instead of the experiment file's")
      ->check(CLI::Range(1, 1'000'000'000))
      ->type_name("NUMBER");
  app.add_option("--threads", arguments.threads, "Runs at a time; default: one for each processor")
      ->check(CLI::Range(1, 1024))
      ->type_name("NUMBER");
  app.add_option("--output", arguments.output,
                 "Folder for runs.csv and summary.json; default: EXPERIMENT_montecarlo")
      ->type_name("DIR");
  app.add_flag("--restart", arguments.restart, "Begin anew instead of going on with the runs in the folder");
  app.add_flag("--report", arguments.report, "Write report.html beside summary.json: plots to look at");
  app.add_flag("--json", arguments.json, "Print the summary as JSON");
  app.add_flag("--quiet", arguments.quiet, "Print nothing but errors");
  app.add_flag("--dry-run", arguments.dry_run,
               "Read and check everything, tell what would be done, write nothing");
  app.set_version_flag("--version", std::string("rivid_montecarlo ") + version);
  app.footer(
      "A run that was finished is never made again: stopped and started anew, the program goes on, and ends "
      "with the\n"
      "same summary. Run k has the seed of the file plus k, whatever the threads.\n"
      "Exit codes: 0 all runs done, 2 bad input or usage, 3 numerical failure.");
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
    bar.show(
        std::to_string(done) + " of " + std::to_string(wanted) + " runs, " + time_left(begin, done, wanted),
        static_cast<double>(done) / static_cast<double>(wanted));
  });
  bar.clear();
}

// The page of a plan. Runs are all that the command line can change in it.
std::string page_of(const Arguments& arguments, const MonteCarlo& plan,
                    std::span<const MonteCarloSummary> found, std::span<const MonteCarloRow> rows) {
  Overrides overrides;
  if (arguments.runs) {
    overrides.emplace_back("runs", std::to_string(*arguments.runs));
  }
  return html_report(
      plan, found, rows,
      provenance_of("rivid_montecarlo", plan.experiment.inputs(Use::simulation), std::move(overrides)));
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

// What would be done.
void dry_run(const Arguments& arguments, const MonteCarlo& plan, const std::filesystem::path& folder,
             std::vector<std::filesystem::path> files) {
  const auto held = arguments.restart ? std::map<int, std::vector<MonteCarloRow>>() : held_runs(folder, plan);
  const auto there = std::ranges::count_if(held, [&](const auto& run) { return run.first < plan.runs; });
  std::string out = in_words(plan, outlook(plan.experiment), there);
  if (!arguments.report) {
    files.pop_back();
  }
  for (const std::filesystem::path& file : files) {
    out += "would write " + file.string() + "\n";
  }
  if (!arguments.quiet) {
    print(out);
  }
}

int run_from(const Arguments& arguments) {
  MonteCarlo plan = read_monte_carlo(arguments.experiment);
  plan.runs = arguments.runs.value_or(plan.runs);
  const std::filesystem::path folder = output_folder(arguments.output, arguments.experiment, "_montecarlo");
  const std::filesystem::path summary = folder / "summary.json";
  const std::filesystem::path report = folder / "report.html";
  if (arguments.dry_run) {
    dry_run(arguments, plan, folder, {folder / "runs.csv", summary, report});
    return success;
  }
  MonteCarloFile file(folder, plan, arguments.restart);
  ProgressBar bar(!arguments.quiet);
  make_missing(plan, file, arguments.threads, bar);

  const std::vector<MonteCarloRow> rows = file.rows();
  const std::vector<MonteCarloSummary> found = summaries(plan, rows);
  const std::string json = to_json(found);
  write_file(summary, json);
  if (arguments.report) {
    write_file(report, page_of(arguments, plan, found, rows));
  }
  if (!arguments.quiet) {
    std::ostringstream table;
    table << std::span<const MonteCarloSummary>(found);
    print(arguments.json ? json : table.str());
    std::cerr << "wrote " << file.path().string() << " and " << summary.string() << '\n';
    if (arguments.report) {
      std::cerr << "wrote " << report.string() << '\n';
    }
  }
  return success;
}

int tool(int argc, char** argv) {
  CLI::App app(
      "Simulates an experiment many times, identifies each, and tells how far the results can be trusted.",
      "rivid_montecarlo");
  Arguments arguments;
  declare(app, arguments);
  if (const std::optional<int> ended = parse(app, argc, argv)) {
    return *ended;
  }
  return run_from(arguments);
}

}  // namespace

int main(int argc, char** argv) { return run_tool("rivid_montecarlo", tool, argc, argv); }
