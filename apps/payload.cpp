#include "rivid/report/payload.hpp"

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/output.hpp"
#include "rivid/text.hpp"
#include "subcommands.hpp"
#include "tool.hpp"

namespace rivid::apps {

namespace {

struct PayloadArguments {
  std::filesystem::path experiment;
  std::vector<std::filesystem::path> loaded;
  std::vector<std::filesystem::path> logs;
  double mass = 0.0;
  std::string gains;
  std::string flange;
  std::string model = "automatic";
  std::vector<std::string> set;
  std::filesystem::path output;
  int threads = 1;
  bool load_friction = false;
  bool json = false;
  bool quiet = false;
};

// Words between commas; one that `unknown` names is infinite.
std::vector<double> numbers_of(const std::string& text, const char* flag, std::string_view unknown = {}) {
  std::vector<double> out;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) {
    double value = std::numeric_limits<double>::infinity();
    if (unknown.empty() || word != unknown) {
      const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (fault != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
        throw InputError(std::string(flag) + ": " + in_quotes(word) + " is no number");
      }
    }
    out.push_back(value);
  }
  return out;
}

// Percent, one number for all joints or one each; "estimate" for what is not known.
Vector gain_sigma_of(const PayloadArguments& arguments, const Robot& robot) {
  if (arguments.gains.empty()) {
    return {};
  }
  const std::vector<double> values = numbers_of(arguments.gains, "--gains", "estimate");
  if (values.size() != 1 && values.size() != robot.joints.size()) {
    throw InputError("--gains has " + counted(static_cast<Index>(values.size()), "value") +
                     ", must have one, or one for each of the " + std::to_string(robot.size()) + " joints");
  }
  Vector out(robot.size());
  for (Index j = 0; j < out.size(); ++j) {
    out[j] = 0.01 * values[values.size() == 1 ? 0 : static_cast<std::size_t>(j)];
  }
  return out;
}

void take_flange(const std::string& text, PayloadOptions& to) {
  if (text.empty()) {
    return;
  }
  const std::vector<double> v = numbers_of(text, "--flange");
  if (v.size() != 6) {
    throw InputError("--flange: " + counted(static_cast<Index>(v.size()), "number") +
                     ", must be x,y,z in m and roll,pitch,yaw in rad, as the origin of a URDF joint");
  }
  to.p = {v[0], v[1], v[2]};
  to.R =
      (Eigen::AngleAxisd(v[5], Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(v[4], Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(v[3], Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
}

int payload(const PayloadArguments& arguments) {
  expect_experiment(arguments.experiment);
  Experiment experiment = read_experiment(arguments.experiment, Use::identification, arguments.set);
  if (!arguments.logs.empty()) {
    experiment.log.files = arguments.logs;
  }
  experiment.estimation.threads = arguments.threads;
  PayloadOptions options;
  options.gain_sigma = gain_sigma_of(arguments, experiment.robot);
  take_flange(arguments.flange, options);
  options.load_friction = arguments.load_friction;
  options.model = named<PayloadModel>(arguments.model).value_or(PayloadModel::automatic);
  if (arguments.mass > 0.0) {
    options.mass = arguments.mass;
  }
  LogSource loaded = experiment.log;
  loaded.files = arguments.loaded;
  const std::filesystem::path file =
      output_folder(arguments.output, arguments.experiment, "_result") / "payload.json";
  std::vector<std::filesystem::path> inputs = experiment.inputs();
  inputs.insert(inputs.end(), arguments.loaded.begin(), arguments.loaded.end());
  const std::vector<PlannedFile> files = {{file, ".json"}};
  Outputs outputs = planned(inputs, files);
  const std::vector<Log> with = read_logs(loaded, experiment.robot);
  const std::vector<Log> without = read_logs(experiment.log, experiment.robot);
  Estimation estimation = experiment.estimation;
  estimation.method = Wls{};
  const Payload found = identify_payload(experiment.robot, without, with, estimation, options);
  const std::string json = to_json(found, options);
  outputs.put(file, json);
  outputs.commit();
  if (!arguments.quiet) {
    print(arguments.json ? json : in_words(found, screen_width()));
    tell_written(files);
  }
  return found.identified ? success : no_success;
}

}  // namespace

int payload_command(int argc, char** argv) {
  PayloadArguments to;
  return run_command(
      {.name = "rivid_identify payload",
       .description =
           "Identifies a payload, and drive gains from a known one, from logs without and with it.",
       .arguments =
           {{.name = "experiment",
             .value = "EXPERIMENT.toml",
             .text = "Experiment file (TOML) of the arm without payload: robot, log, signal chain",
             .target = &to.experiment,
             .required = true},
            {.name = "--loaded",
             .value = "FILE",
             .text = "Logs with the payload, whose columns are those of the experiment file",
             .target = &to.loaded,
             .required = true},
            {"--log", "FILE", "Logs without it instead of the experiment file's", &to.logs},
            {"--mass", "KG", "Mass of the payload where it is known, to find drive gains with", &to.mass},
            {"--gains", "PERCENT",
             "Standard deviation of the drive gains in percent, or estimate; one, or one a joint: 1,1,2. "
             "Default: they are exact",
             &to.gains},
            {"--flange", "POSE",
             "Flange in the frame of the last link: x,y,z,roll,pitch,yaw [m, rad]. Default: that frame",
             &to.flange},
            {"--model", "automatic|point|body", "Ten parameters, or mass and centre of mass alone",
             &to.model},
            {"--load-friction", "", "Dry friction of each joint grows with its load", &to.load_friction},
            set_argument(to.set),
            {"--output", "DIR", "Folder for payload.json; default: EXPERIMENT_result", &to.output},
            {"--threads", "N", "Threads that share the work", &to.threads, thread_range},
            {"--json", "", "Print the result as JSON instead of the table", &to.json},
            {"--quiet", "", "Print nothing but errors", &to.quiet}},
       .footer = "Exit codes: 0 identified; 1 not identified; 2 bad input or usage; 3 numerical failure."},
      argc, argv, [&] { return payload(to); });
}

}  // namespace rivid::apps
