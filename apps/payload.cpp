#include "rivid/report/payload.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/output.hpp"
#include "rivid/report/limits.hpp"
#include "rivid/text.hpp"
#include "subcommands.hpp"
#include "tool.hpp"

namespace rivid::apps {

namespace {

struct PayloadArguments : Given {
  std::vector<std::string> loaded;
  std::vector<std::filesystem::path> logs;
  std::filesystem::path arm;
  std::vector<std::string> masses;
  std::string gains;
  std::string link;
  std::string flange;
  std::string model = "automatic";
  int threads = 1;
  bool load_friction = false;
};

// Words between commas; one that `unknown` names is infinite.
std::vector<double> numbers_of(const std::string& text, const char* flag, std::string_view unknown = {}) {
  std::vector<double> out;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) {
    double value = std::numeric_limits<double>::infinity();
    if (unknown.empty() || word != unknown) {
      const std::optional<double> read = finite_number(word);
      if (!read) {
        throw InputError(std::string(flag) + ": " + in_quotes(word) + " is no number");
      }
      value = *read;
      const CommandLineNumber& allowed = command_line_number(flag);
      if (!allowed.range.holds(value)) {
        throw InputError(out_of_range(flag, value, allowed.unit, allowed.range));
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

// A log, and when the payload is on the arm [s].
struct Carried {
  std::filesystem::path file;
  std::string time;  ///< as it was given; empty where all of the log is with the payload
  double from = -std::numeric_limits<double>::infinity();
  double to = std::numeric_limits<double>::infinity();
};

// The logs of one payload.
struct NamedLogs {
  std::string name;
  std::vector<Carried> files;
  std::vector<Log> logs = {};
  std::optional<double> mass = {};
};

// FILE, FILE@FROM or FILE@FROM:TO.
Carried carried(const std::string& text) {
  const std::size_t at = text.rfind('@');
  if (at == std::string::npos || std::filesystem::exists(text)) {
    return {.file = text, .time = {}};
  }
  const std::string time = text.substr(at + 1);
  const std::size_t colon = time.find(':');
  const std::optional<double> from = finite_number(time.substr(0, colon));
  const std::optional<double> to = colon == std::string::npos ? std::numeric_limits<double>::infinity()
                                                              : finite_number(time.substr(colon + 1));
  if (!from || !to || !(*to > *from)) {
    throw InputError(
        "--loaded " + text + ": " + in_quotes(time) +
        " must be the time in s at which the payload is taken, or FROM:TO, also that at which it is "
        "put down, later");
  }
  return {.file = text.substr(0, at), .time = time, .from = *from, .to = *to};
}

// Puts the rows of a log with the payload and those without it to the logs of their kind. A gripper takes a
// while to close: what is within half a second of the time given goes to neither.
void divide(const Log& log, const Carried& by, std::vector<Log>& with, std::vector<Log>& without) {
  constexpr double closing = 0.5;  // [s] left out at both ends of a grasp; a choice
  const auto rows_before = [&](double time) {
    return static_cast<Index>(std::ranges::lower_bound(log.t, time) - log.t.begin());
  };
  const auto take = [&](double from, double to, std::vector<Log>& parts) {
    const Index first = rows_before(from);
    const Index count = rows_before(to) - first;
    if (count > 0) {
      parts.push_back(excerpt(log, first, count));
      parts.back().warnings = log.warnings;
    }
  };
  const std::size_t before = with.size();
  take(by.from + closing, by.to - closing, with);
  if (with.size() == before) {
    throw InputError("--loaded " + by.file.string() + "@" + by.time + ": the log, from " + number(log.t[0]) +
                     " to " + number(log.t[log.samples() - 1]) +
                     " s, has no row then, half a second from both ends");
  }
  take(-std::numeric_limits<double>::infinity(), by.from - closing, without);
  take(by.to + closing, std::numeric_limits<double>::infinity(), without);
}

// NAME=rest, or the rest alone, which has no name.
std::pair<std::string, std::string> name_and_rest(const std::string& text) {
  const std::size_t at = text.find('=');
  return at == std::string::npos ? std::pair(std::string(), text)
                                 : std::pair(text.substr(0, at), text.substr(at + 1));
}

std::vector<NamedLogs> loads_of(const PayloadArguments& arguments) {
  std::vector<NamedLogs> out;
  const auto named = [&](const std::string& name) {
    return std::ranges::find(out, name.empty() ? "payload" : name, &NamedLogs::name);
  };
  for (const std::string& word : arguments.loaded) {
    // A file may have = in its name.
    const auto [name, file] =
        std::filesystem::exists(word) ? std::pair(std::string(), word) : name_and_rest(word);
    if (named(name) == out.end()) {
      out.push_back({.name = name.empty() ? "payload" : name, .files = {}});
    }
    named(name)->files.push_back(carried(file));
  }
  for (const std::string& word : arguments.masses) {
    const auto [name, text] = name_and_rest(word);
    const auto of = named(name);
    if (of == out.end()) {
      throw InputError("--mass " + word + ": no logs of --loaded are those of " +
                       (name.empty() ? "a payload without a name" : in_quotes(name)));
    }
    const std::vector<double> values = numbers_of(text, "--mass");
    if (values.size() != 1) {
      throw InputError("--mass " + word + " must be one number, or NAME=number");
    }
    if (of->mass) {
      throw InputError("--mass " + word + ": the mass of " + in_quotes(of->name) + " is given twice");
    }
    of->mass = values.front();
  }
  return out;
}

PayloadReport found_on(const Robot& robot, const Experiment& experiment,
                       const std::optional<IdentifiedArm>& arm, const std::vector<NamedLogs>& loads,
                       std::vector<Log> without, const PayloadOptions& options) {
  std::vector<LoadedLogs> with;
  for (const NamedLogs& load : loads) {
    with.push_back({.name = load.name, .logs = load.logs, .mass = load.mass});
  }
  Estimation estimation = experiment.estimation;
  estimation.method = Wls{};
  if (!arm && !experiment.log.files.empty()) {
    std::ranges::move(read_logs(experiment.log, robot), std::back_inserter(without));
  }
  PayloadReport out = arm ? identify_payloads(*arm, with, estimation, options)
                          : identify_payloads(robot, without, with, estimation, options);
  examine(robot, without, with, estimation, out);
  return out;
}

int payload(const PayloadArguments& arguments) {
  expect_experiment(arguments.experiment);
  Experiment experiment = read_experiment(arguments.experiment, Use::identification, arguments.set);
  if (!arguments.logs.empty()) {
    experiment.log.files = arguments.logs;
  }
  experiment.estimation.threads = arguments.threads;
  std::optional<IdentifiedArm> arm;
  if (!arguments.arm.empty()) {
    arm = read_identified_arm(arguments.arm, experiment.robot);
  }
  const Robot& robot = arm ? arm->robot : experiment.robot;
  PayloadOptions options;
  options.gain_sigma = gain_sigma_of(arguments, robot);
  options.link = arguments.link;
  take_flange(arguments.flange, options);
  options.load_friction = arguments.load_friction;
  options.model = named<PayloadModel>(arguments.model).value_or(PayloadModel::automatic);
  std::vector<NamedLogs> loads = loads_of(arguments);
  const std::filesystem::path file =
      output_folder(arguments.output, arguments.experiment, "_result") / "payload.json";
  std::vector<std::filesystem::path> inputs = experiment.inputs();
  if (arm) {
    inputs.push_back(arguments.arm);
  }
  for (const NamedLogs& load : loads) {
    for (const Carried& one : load.files) {
      inputs.push_back(one.file);
    }
  }
  const std::vector<PlannedFile> files = {{file, ".json"}};
  Outputs outputs = planned(inputs, files);
  std::vector<Log> without;
  for (NamedLogs& load : loads) {
    for (const Carried& one : load.files) {
      LogSource source = experiment.log;
      source.files = {one.file};
      for (const Log& log : read_logs(source, robot)) {
        divide(log, one, load.logs, without);
      }
      if (!one.time.empty()) {
        // Of a log that is divided the experiment takes the parts without payload alone.
        std::erase_if(experiment.log.files, [&](const auto& whole) {
          std::error_code missing;  // which the reader says
          return std::filesystem::equivalent(whole, one.file, missing);
        });
      }
    }
  }
  if (arm) {
    without.clear();
  }
  const PayloadReport found = found_on(robot, experiment, arm, loads, std::move(without), options);
  const std::string json = to_json(found, options);
  outputs.put(file, json);
  finish(arguments, outputs, files, json, in_words(found, screen_width()));
  return found.identified ? success : no_success;
}

}  // namespace

int payload_command(int argc, char** argv) {
  PayloadArguments to;
  return run_command(
      {.name = "rivid payload",
       .description =
           "Identifies payloads, and drive gains from a known one, from logs without and with them.",
       .arguments =
           {{"experiment", "EXPERIMENT.toml",
             "Experiment file (TOML) of the arm without payload: robot, log, signal chain", &to.experiment,
             true},
            {"--loaded", "[NAME=]FILE[@FROM[:TO]]",
             "Logs with a payload, whose columns are those of the experiment file; of several "
             "payloads with their names. FROM: the time in the log [s] at which it is taken, TO: put down; "
             "what is outside is a log without it",
             &to.loaded, true},
            {"--log", "FILE", "Logs without it instead of the experiment file's", &to.logs},
            {.name = "--arm",
             .value = "RESULT.json",
             .text = "The arm as it was identified before, instead of logs without payload",
             .target = &to.arm,
             .excludes = "--log"},
            {"--mass", "[NAME=]KG", "Mass of a payload where it is known, to find drive gains with",
             &to.masses},
            {"--gains", "PERCENT",
             "Standard deviation of the drive gains in percent, or estimate; one, or one a joint: 1,1,2. "
             "Default: 1, or what the arm's result says; 0: they are exact",
             &to.gains},
            {"--link", "LINK", "Moving link that the payload is on. Default: the last of the arm", &to.link},
            {"--flange", "POSE",
             "Flange in the frame of that link: x,y,z,roll,pitch,yaw [m, rad]. Default: that frame",
             &to.flange},
            {"--model", "automatic|point|body", "Ten parameters, or mass and centre of mass alone",
             &to.model},
            {"--load-friction", "", "Dry friction of each joint grows with its load", &to.load_friction},
            set_argument(to.set),
            {"--output", "DIR", "Folder for payload.json; default: EXPERIMENT_result", &to.output},
            {"--threads", "N", "Threads that share the work", &to.threads},
            {"--json", "", "Print the result as JSON instead of the table", &to.json},
            {"--quiet", "", "Print nothing but errors", &to.quiet}},
       .footer =
           "Exit codes: 0 identified, or no payload; 1 doubtful or not identified; 2 bad input or usage; 3 "
           "numerical failure."},
      argc, argv, [&] { return payload(to); });
}

}  // namespace rivid::apps
