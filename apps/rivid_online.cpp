#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "programs.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/input.hpp"
#include "rivid/output.hpp"
#include "rivid/report/online.hpp"
#include "rivid/text.hpp"
#include "tool.hpp"

namespace {

using namespace rivid;
using namespace rivid::apps;

struct OnlineArguments : Given {
  std::filesystem::path log;
  std::filesystem::path result;
  double gains = 0.0;
  double learn = OnlineReplayOptions{}.learn;
  int stride = 0;
  bool measured = false;
  bool force = false;
};

int run(const OnlineArguments& arguments) {
  const IdentifiedModelOptions force = {.force = arguments.force};
  const std::filesystem::path result = result_file(arguments.result);
  const OnlineModel model = read_online_model(result, force);
  const DynamicModel dynamics = read_identified_model(result, force);
  OnlineReplayOptions options;
  options.learn = arguments.learn;
  options.state.payload.gain_sigma = 0.01 * arguments.gains;
  options.state.payload.rows.torque_held = !arguments.measured;
  options.state.payload.rows.stride = arguments.stride;
  const std::filesystem::path folder = output_folder(arguments.output, arguments.log, "_online");
  const std::vector<PlannedFile> files = {{folder / "online.csv", ".csv"}, {folder / "online.html", ".html"}};
  std::vector<std::filesystem::path> inputs = {arguments.log, result};
  LogSource source;
  if (!arguments.experiment.empty()) {
    // Columns, rate and adjustments are those of its logs.
    const Experiment experiment = read_experiment(arguments.experiment);
    source = experiment.log;
    std::ranges::copy(experiment.inputs(), std::back_inserter(inputs));
  }
  source.files = {arguments.log};
  Outputs outputs = planned(inputs, files, arguments.force);
  const std::vector<Log> logs = read_logs(source, model.robot);
  const OnlineReplay found = replay(model, dynamics, logs.front(), options);
  const std::string table = to_csv(found);
  outputs.put(files[0].path, table);
  outputs.put(files[1].path, to_html(found) + "<!-- \"outputs\": online.csv " + sha256(table) + " -->\n");
  outputs.commit();
  if (!arguments.quiet) {
    print(in_words(found, screen_width()));
    if (logs.size() > 1) {
      tell("warning", {"the log has " + std::to_string(logs.size()) +
                       " parts between gaps; the first one was replayed"});
    }
    tell_written(files);
  }
  return found.warnings.empty() ? success : no_success;
}

}  // namespace

int rivid::apps::online_tool(int argc, char** argv) {
  OnlineArguments to;
  return run_command(
      {.name = "rivid online",
       .description =
           "Replays a log: payload, drift of friction and contacts as a control loop would have seen them.",
       .arguments =
           {{.name = "log", .value = "FILE", .text = "Log of the robot", .target = &to.log, .required = true},
            {.name = "--result",
             .value = "FILE",
             .text = "result.json of the identification, or the folder that it is in",
             .target = &to.result,
             .required = true},
            {"--experiment", "FILE",
             "Experiment file whose [log] says which columns are what; default: columns q1, …, tau1 or v1, …",
             &to.experiment},
            {"--gains", "PERCENT", "Standard deviation of the drive gains in percent; default: 0", &to.gains},
            {"--stride", "SAMPLES", "From one row to the next; default: 25 ms, at least 5", &to.stride},
            {"--learn", "SECONDS", "Time in which thresholds of contacts are learned; default: 30",
             &to.learn},
            {"--measured", "", "Torques are measured at their samples, not held from one to the next",
             &to.measured},
            {"--force", "",
             "Take a result that is not identified, and replace files that rivid did not write", &to.force},
            {"--output", "DIR", "Folder for online.csv and online.html; default: LOG_online", &to.output},
            {"--quiet", "", "Print nothing but errors", &to.quiet}},
       .footer = "Exit codes: 0 replayed; 1 replayed, but the log has errors; 2 bad input or usage; 3 "
                 "numerical failure.\n"
                 "docs/online.md describes the estimators."},
      argc, argv, [&] { return run(to); });
}
