#include "rivid/experiment/factors_file.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <unordered_map>

#include "experiment/byte_parts.hpp"
#include "experiment/from_program.hpp"
#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::Json;
using detail::json_list;
using Settings = std::vector<std::pair<std::string, std::string>>;

// The chain's numbers to the last bit: whatever description they come from, and whatever its inertial
// parameters are.
std::string geometry(const Robot& robot) {
  std::string bits;
  const auto add = [&](const auto& numbers) {
    for (const auto x : numbers.reshaped()) {
      const auto word = std::bit_cast<std::uint64_t>(static_cast<double>(x));
      for (int shift = 0; shift < 64; shift += 8) {
        bits += static_cast<char>(static_cast<unsigned char>(word >> shift));
      }
    }
  };
  for (const Chain::Link& link : robot.chain.links) {
    bits += link.type == JointType::revolute ? 'R' : 'P';
    add(link.R);
    add(link.p);
    add(Eigen::Map<const Eigen::Vector3i>(link.axes.data()));
    add(Eigen::Map<const Eigen::Vector3i>(link.signs.data()));
  }
  add(Eigen::Map<const Eigen::VectorXi>(robot.chain.parents.data(), std::ssize(robot.chain.parents)));
  for (const Chain::Dependent& dependent : robot.chain.dependents) {
    const std::vector<double> numbers = dependent.numbers();
    add(Vector::Map(numbers.data(), std::ssize(numbers)));
  }
  add(robot.chain.gravity);
  add(robot.gear_matrix);
  return sha256(bits);
}

// What decides about the rows of a log.
Settings decisive(const Experiment& experiment) {
  Settings out = {{"robot.geometry", geometry(experiment.robot)}};
  for (const Setting& setting : settings(experiment)) {
    const auto is = [&](std::string_view section) { return setting.key.starts_with(section); };
    const bool of_file =
        setting.key == "robot.urdf" || setting.key == "robot.mdh" || setting.key == "log.files";
    if ((is("robot.") || is("log.") || is("signal.")) && !of_file) {
      out.emplace_back(setting.key, setting.value);
    }
  }
  return out;
}

// throws InputError naming the first setting that differs
void expect_same(const Settings& of, std::string_view source, const Settings& wanted,
                 std::string_view others) {
  const auto value = [](const Settings& in, const std::string& key) {
    const auto at = std::ranges::find(in, key, &Settings::value_type::first);
    return at == in.end() ? std::string("not set") : at->second;
  };
  for (const auto* const side : {&wanted, &of}) {
    for (const auto& [key, _] : *side) {
      if (const std::string own = value(of, key), other = value(wanted, key); own != other) {
        throw InputError(std::string(source) +
                         (key == "robot.geometry"
                              ? ": is of another robot than " + std::string(others)
                              : ": " + key + " is " + own + ", but " + other + " in " + std::string(others)) +
                         "; factors are merged where robot and rows are the same");
      }
    }
  }
}

constexpr std::string_view factors_magic = "rivid-LF";
constexpr std::uint32_t factors_version = 1;  // of the format

Json description_of(const FactorsFile& file) {
  const LogFactors& factors = file.factors;
  const Json logs = json_list(file.logs, [](const FactoredLog& log) { return Json{log.path, log.sha256}; });
  const Json columns = json_list(factors.rows.groups, [](const RowGroup& group) { return group.columns; });
  Json out = {{"experiment", file.experiment.string()},
              {"settings", file.settings},
              {"made_with", file.made_with},
              {"files", logs},
              {"logs", factors.logs},
              {"columns", columns},
              {"undecimated", !factors.rows.undecimated.empty()},
              {"blocks", factors.blocks.size()},
              {"left_out", factors.rows.left_out},
              {"thresholds", factors.rows.thresholds},
              {"squared_velocities", detail::json_of(factors.velocities.sums)},
              {"velocities", factors.velocities.count}};
  if (!file.run.empty()) {
    out["run"] = file.run;
  }
  return out;
}

void require_known_gains(const Experiment& experiment) {
  if (experiment.gains) {
    throw InputError(experiment.file.string() +
                     ": [method] gains = \"estimate\" needs the logs themselves, not their factors; "
                     "estimate the gains from some logs with rivid identify and write them into drive_gain");
  }
}

FactorsFile described(const Json& from) {
  FactorsFile out;
  out.experiment = from.at("experiment").get<std::string>();
  out.settings = from.at("settings").get<std::vector<std::string>>();
  out.made_with = from.at("made_with").get<Settings>();
  out.run = from.value("run", std::string());
  for (const Json& log : from.at("files")) {
    out.logs.push_back({log.at(0).get<std::string>(), log.at(1).get<std::string>()});
  }
  LogFactors& factors = out.factors;
  factors.logs = from.at("logs").get<Index>();
  factors.rows.left_out = from.at("left_out").get<std::vector<Index>>();
  factors.rows.thresholds = from.at("thresholds").get<std::vector<double>>();
  const auto squares = from.at("squared_velocities").get<std::vector<double>>();
  factors.velocities = {.sums = Eigen::Map<const Vector>(squares.data(), std::ssize(squares)),
                        .count = from.at("velocities").get<double>()};
  return out;
}

}  // namespace

std::vector<std::string> row_settings(const SignalOptions& signal) {
  std::vector<std::string> out = {"signal.decimation=" + Json(signal.decimation).dump(),
                                  std::string("signal.torque_held=") + (signal.held() ? "true" : "false")};
  if (!signal.velocity_threshold.empty()) {
    out.push_back("signal.velocity_threshold=" + Json(signal.velocity_threshold).dump());
  }
  return out;
}

FactorsFile factors_of(const Experiment& experiment, std::span<const Log> logs,
                       std::span<const FactoredLog> files, int blocks) {
  if (logs.empty()) {
    throw InputError("factors: no log is given");
  }
  require_known_gains(experiment);
  FactorsFile out;
  for (const Log& log : logs) {
    LogFactors one = log_factors(experiment.robot, log, experiment.estimation.signal, blocks,
                                 experiment.estimation.threads);
    if (out.factors.logs == 0) {
      out.factors = std::move(one);
    } else {
      merge(out.factors, one);
    }
  }
  out.logs.assign(files.begin(), files.end());
  out.made_with = decisive(experiment);
  return out;
}

void merge(FactorsFile& into, const FactorsFile& other, std::string_view source) {
  expect_same(other.made_with, source, into.made_with, "the factors before it");
  std::unordered_map<std::string_view, const FactoredLog*> theirs;
  for (const FactoredLog& log : other.logs) {
    theirs.emplace(log.sha256, &log);
  }
  for (const FactoredLog& own : into.logs) {
    if (const auto same = theirs.find(own.sha256); same != theirs.end()) {
      const std::string& path = same->second->path;
      throw InputError(std::string(source) + ": holds " + path + ", which the factors before it hold" +
                       (path == own.path ? "" : " as " + own.path) +
                       "; a log that counts twice would make intervals too short");
    }
  }
  merge(into.factors, other.factors);
  into.run.clear();
  into.logs.insert(into.logs.end(), other.logs.begin(), other.logs.end());
}

Identification identify_factors(const Experiment& experiment, const FactorsFile& file,
                                std::string_view source, const LoopAsk& ask) {
  require_known_gains(experiment);
  expect_same(file.made_with, source, decisive(experiment), "the experiment");
  const Estimation estimation = detail::estimation_of(experiment);
  const bool loops = ask && std::holds_alternative<Iv>(estimation.method);
  Identification out = loops ? identify(experiment.robot, file.factors, estimation, ask)
                             : identify(experiment.robot, file.factors, estimation);
  out.notes.push_back("from factors of " + counted(file.factors.logs, "log") +
                      ": residuals were not looked at, see docs/scale.md; rivid check looks at the "
                      "logs one by one");
  for (const Log& log : read_logs(experiment.validation, experiment.robot)) {
    out.validation.push_back(validate(experiment.robot, out, log, experiment.estimation.threads));
  }
  return out;
}

std::string encoded(const FactorsFile& file) {
  detail::PartWriter out(factors_magic, factors_version, description_of(file));
  out.put(file.factors.rows.groups);
  out.put(file.factors.rows.undecimated);
  for (const std::vector<RowGroup>& block : file.factors.blocks) {
    out.put(block);
  }
  return std::move(out).content();
}

FactorsFile decoded_factors(std::string_view content, std::string_view source) {
  detail::PartReader reader(content, factors_magic, factors_version,
                            "holds no factors of logs; it must start with \"" + std::string(factors_magic) +
                                "\", as rivid factors writes it",
                            source);
  try {
    const Json& description = reader.description();
    FactorsFile out = described(description);
    const auto columns = reader.columns();
    const auto next_groups = [&] {
      return reader.groups<RowGroup>(columns, [](Index /*own*/) { return Index{1}; });
    };
    RowFactors& rows = out.factors.rows;
    rows.groups = next_groups();
    if (description.at("undecimated").get<bool>()) {
      rows.undecimated = next_groups();
    }
    for (Index g = reader.count("blocks", LogFactors::most_blocks); g > 0; --g) {
      out.factors.blocks.push_back(next_groups());
    }
    reader.expect_end();
    if (rows.left_out.size() != columns.size() || rows.thresholds.size() != columns.size() ||
        out.factors.velocities.sums.size() != std::ssize(columns)) {
      throw reader.fault("is damaged: its parts do not fit together");
    }
    return out;
  } catch (const Json::exception& e) {
    throw reader.fault(std::string("is damaged: ") + e.what());
  }
}

FactorsFile read_factors(const std::filesystem::path& path) {
  return decoded_factors(read_input(path).bytes(), path.string());
}

}  // namespace rivid
