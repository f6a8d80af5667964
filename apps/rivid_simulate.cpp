#include <filesystem>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "programs.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/output.hpp"
#include "rivid/report/json.hpp"
#include "rivid/text.hpp"
#include "tool.hpp"

namespace {

using namespace rivid;
using namespace rivid::apps;

struct SimulateArguments : Given {
  std::optional<std::int64_t> seed;
  std::filesystem::path parameters;
};

Command command_of(SimulateArguments& to) {
  return {
      .name = "rivid simulate",
      .description = "Simulates a robot in its closed loop, and writes the log of its motion.",
      .arguments = {{"experiment", "EXPERIMENT.toml",
                     "Experiment file (TOML): robot, control, reference, simulation", &to.experiment, true},
                    {"--seed", "NUMBER", "Seed instead of the experiment file's", &to.seed},
                    {"--parameters", "FILE", "Parameter file instead of the experiment file's",
                     &to.parameters},
                    set_argument(to.set),
                    {"--output", "DIR",
                     "Folder for log.csv and simulation.json; default: EXPERIMENT_simulation", &to.output},
                    {"--json", "", "Print the summary as JSON", &to.json},
                    {"--quiet", "", "Print nothing but errors", &to.quiet},
                    {"--dry-run", "", "Read and check everything, print what would be done, write nothing",
                     &to.dry_run}},
      .footer =
          "Exit codes: 0 simulated, 1 ended early (log.csv goes up to there), 2 bad input or usage, 3 "
          "numerical failure.\n"
          "The keys of an experiment file are listed in docs/experiment.md."};
}

// Flags override the experiment file; what they changed is kept for the provenance.
Overrides apply(const SimulateArguments& arguments, Experiment& experiment) {
  SimulationPlan plan = experiment.simulation.value_or(SimulationPlan{});
  Overrides overrides;
  if (arguments.seed) {
    plan.noise.seed = static_cast<std::uint64_t>(*arguments.seed);
    overrides.emplace_back("seed", std::to_string(*arguments.seed));
    experiment.origins["simulation.seed"] = "--seed";
  }
  if (!arguments.parameters.empty()) {
    plan.parameters = arguments.parameters;
    overrides.emplace_back("parameters", arguments.parameters.string());
    experiment.origins["simulation.parameters"] = "--parameters";
  }
  experiment.simulation = std::move(plan);
  return overrides;
}

std::string in_words(const Experiment& experiment, const SimulationOutlook& found,
                     const std::vector<PlannedFile>& files) {
  const Robot& robot = experiment.robot;
  const SimulationRecord& record = found.record;
  std::ostringstream out;
  out << "robot       " << experiment.robot_file.string() << ": \"" << robot.name << "\", "
      << counted(robot.size(), "joint") << ", " << counted(record.base.size(), "base parameter") << '\n';
  if (record.simulation.outcome != Outcome::completed) {
    out << "            " << record.simulation.reason << '\n';
  }
  out << "control     " << record.control.law << ", "
      << (record.control_hz > 0.0 ? number(record.control_hz) + " Hz" : std::string("continuous")) << '\n';
  for (const Gain& gain : record.control.gains) {
    out << "            " << gain.name << " " << gain.values.transpose() << '\n';
  }
  out << "simulation  " << counted(found.samples, "sample") << " at " << number(found.f_m) << " Hz, "
      << number(static_cast<double>(found.samples - 1) / found.f_m, 4) << " s, seed " << record.seed << '\n';
  out << "\nsettings\n" << in_lines(settings(experiment, Use::simulation)) << '\n' << would_write(files);
  return out.str();
}

int simulate_from(const SimulateArguments& arguments) {
  Experiment experiment = read_experiment(arguments.experiment, Use::simulation, arguments.set);
  const Overrides overrides = apply(arguments, experiment);
  const std::filesystem::path folder = output_folder(arguments.output, arguments.experiment, "_simulation");
  const std::filesystem::path log = folder / "log.csv";
  const std::filesystem::path file = folder / "simulation.json";
  const std::vector<PlannedFile> files = {{log, ".csv"}, {file, ".json"}};
  Outputs outputs = planned(experiment.inputs(Use::simulation), files);
  if (arguments.dry_run) {
    const SimulationOutlook found = outlook(experiment);
    if (!arguments.quiet) {
      print(in_words(experiment, found, files));
      tell(found.record.warnings);
    }
    return found.record.simulation.outcome == Outcome::completed ? success : no_success;
  }
  ProgressBar bar(!arguments.quiet);
  const SimulationRecord record = run_simulation(experiment, std::ref(bar));
  bar.clear();

  Provenance provenance =
      provenance_of("rivid_simulate", experiment, Use::simulation, overrides, arguments.set);
  put_with_hash(log, to_csv(record.log), outputs, provenance);
  const std::string json = to_json(experiment.robot, record, provenance);
  outputs.put(file, json);
  outputs.commit();
  print_answer(arguments, json, summary(experiment.robot, record, screen_width()));
  if (!arguments.quiet) {
    tell(record.warnings);
    tell_written(files);
  }
  return record.simulation.outcome == Outcome::completed ? success : no_success;
}

}  // namespace

int rivid::apps::simulate_tool(int argc, char** argv) {
  SimulateArguments arguments;
  return run_command(command_of(arguments), argc, argv, [&] { return simulate_from(arguments); });
}
