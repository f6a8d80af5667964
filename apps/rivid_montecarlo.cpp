#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include "progress_bar.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/report/file.hpp"
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
  bool json = false;
  bool quiet = false;
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
  app.add_flag("--json", arguments.json, "Print the summary as JSON");
  app.add_flag("--quiet", arguments.quiet, "Print nothing but errors");
  app.set_version_flag("--version", std::string("rivid_montecarlo ") + version);
  app.footer(
      "A run that was finished is never made again: stopped and started anew, the program goes on, and ends "
      "with the\n"
      "same summary. Run k has the seed of the file plus k, whatever the threads.\n"
      "Exit codes: 0 all runs done, 2 bad input or usage, 3 numerical failure.");
}

// The file of the rows: those of earlier calls, and what is added.
class RunsFile {
 public:
  RunsFile(std::filesystem::path path, const MonteCarlo& plan, bool restart) : path_(std::move(path)) {
    std::string content = csv_header(plan);
    if (!restart && std::filesystem::exists(path_)) {
      for (const MonteCarloRow& row : read_monte_carlo_rows(path_, plan)) {
        rows_[row.run].push_back(row);
      }
      // Of a run that was cut short nothing is kept.
      std::erase_if(rows_, [&](const auto& run) { return run.second.size() != plan.trials.size(); });
      for (const auto& [run, rows] : rows_) {
        for (const MonteCarloRow& row : rows) {
          content += to_csv(row);
        }
      }
    }
    write_file(path_, content);
    out_.open(path_, std::ios::app);
  }

  [[nodiscard]] bool holds(int run) const { return rows_.contains(run); }
  [[nodiscard]] std::size_t size() const { return rows_.size(); }

  void add(const std::vector<MonteCarloRow>& rows) {
    std::string lines;
    for (const MonteCarloRow& row : rows) {
      lines += to_csv(row);
    }
    out_ << lines << std::flush;
    if (!out_) {
      throw InputError(path_.string() + ": can not be written to");
    }
    rows_[rows.front().run] = rows;
  }

  // Rows of the first runs.
  [[nodiscard]] std::vector<MonteCarloRow> rows(int runs) const {
    std::vector<MonteCarloRow> out;
    for (const auto& [run, rows] : rows_) {
      if (run < runs) {
        out.insert(out.end(), rows.begin(), rows.end());
      }
    }
    return out;
  }

 private:
  std::filesystem::path path_;
  std::map<int, std::vector<MonteCarloRow>> rows_;
  std::ofstream out_;
};

std::string time_left(Clock::time_point begin, int done, int missing) {
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  const double left = seconds / static_cast<double>(done) * static_cast<double>(missing - done);
  return number(left, left < 10.0 ? 1 : 2) + " s left";
}

// All runs that the file does not hold yet.
void make_missing(const MonteCarlo& plan, RunsFile& file, int threads, ProgressBar& bar) {
  std::vector<int> missing;
  for (int run = 0; run < plan.runs; ++run) {
    if (!file.holds(run)) {
      missing.push_back(run);
    }
  }
  const Clock::time_point begin = Clock::now();
  std::mutex adding;
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;
  int done = 0;
  const auto work = [&] {
    try {
      for (std::size_t k = next++; k < missing.size(); k = next++) {
        const std::vector<MonteCarloRow> rows = monte_carlo_run(plan, missing[k]);
        const std::scoped_lock lock(adding);
        file.add(rows);
        ++done;
        bar.show(std::to_string(done) + " of " + std::to_string(missing.size()) + " runs, " +
                     time_left(begin, done, static_cast<int>(missing.size())),
                 static_cast<double>(done) / static_cast<double>(missing.size()));
      }
    } catch (...) {
      const std::scoped_lock lock(adding);
      failure = std::current_exception();
      next = missing.size();
    }
  };
  std::vector<std::thread> others;
  for (int k = 1; k < threads; ++k) {
    others.emplace_back(work);
  }
  work();
  for (std::thread& other : others) {
    other.join();
  }
  if (failure) {
    std::rethrow_exception(failure);
  }
}

int run_from(const Arguments& arguments) {
  MonteCarlo plan = read_monte_carlo(arguments.experiment);
  plan.runs = arguments.runs.value_or(plan.runs);
  const std::filesystem::path folder = output_folder(arguments.output, arguments.experiment, "_montecarlo");
  const std::filesystem::path made_from = folder / "inputs.sha256";
  const std::filesystem::path runs = folder / "runs.csv";
  // The runs belong to the files that they were made from; their number may grow.
  std::string fingerprint = "# rivid " + std::string(version) + "\n";
  for (const std::filesystem::path& input : plan.experiment.inputs(Use::simulation)) {
    fingerprint += input_file(input).sha256 + "  " + input.filename().string() + "\n";
  }
  if (!arguments.restart && std::filesystem::exists(runs) && std::filesystem::exists(made_from)) {
    std::ifstream in(made_from);
    const std::string before((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (before != fingerprint) {
      throw InputError(folder.string() +
                       ": holds runs of other input files, or of another version; --restart begins "
                       "anew, --output names another folder");
    }
  }
  RunsFile file(runs, plan, arguments.restart);
  write_file(made_from, fingerprint);
  ProgressBar bar(!arguments.quiet);
  make_missing(plan, file, arguments.threads, bar);
  bar.clear();

  const std::vector<MonteCarloRow> rows = file.rows(plan.runs);
  const std::vector<MonteCarloSummary> found = summaries(plan, rows);
  const std::string json = to_json(found);
  write_file(folder / "summary.json", json);
  if (!arguments.quiet) {
    std::ostringstream table;
    table << std::span<const MonteCarloSummary>(found);
    print(arguments.json ? json : table.str());
    std::cerr << "wrote " << runs.string() << " and " << (folder / "summary.json").string() << '\n';
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
