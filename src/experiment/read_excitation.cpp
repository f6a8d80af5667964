#include "experiment/read_excitation.hpp"

#include "experiment/sections.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/log_factors.hpp"
#include "rivid/identify/rows.hpp"

namespace rivid {

namespace detail {

namespace {

// Three numbers that must be there.
Eigen::Vector3d point(TomlReader& keys, std::string_view key) {
  const auto values = keys.get<std::vector<double>>(key);
  if (!values || values->size() != 3) {
    keys.fail(std::string(key) + " must be three numbers");
  }
  return Eigen::Vector3d((*values)[0], (*values)[1], (*values)[2]);
}

double required(TomlReader& keys, std::string_view key) {
  const auto value = keys.get<double>(key);
  if (!value) {
    keys.fail(std::string(key) + " must be there");
  }
  return *value;
}

// The tables of a list, one after the other.
template <typename Read>
void read_tables(TomlReader& keys, std::string_view key, const Read& read) {
  const toml::node* const node = keys.find(key);
  if (node == nullptr) {
    return;
  }
  std::size_t count = 0;
  for (const toml::node* const item : TomlReader::items(*node)) {
    TomlReader table = keys.section(*item, key);
    read(table, table.get<std::string>("name").value_or(std::string(key) + " " + std::to_string(++count)));
    table.finish();
  }
}

Space read_space(TomlReader keys, const Robot& robot) {
  Space out;
  keys.read(out);
  if (const auto floor = keys.get<double>("floor")) {
    out.half_spaces.push_back({.name = "floor", .normal = Eigen::Vector3d::UnitZ(), .offset = *floor});
  }
  read_tables(keys, "half_spaces", [&](TomlReader& table, std::string name) {
    out.half_spaces.push_back(
        {.name = std::move(name), .normal = point(table, "normal"), .offset = required(table, "offset")});
  });
  read_tables(keys, "boxes", [&](TomlReader& table, std::string name) {
    out.boxes.push_back({.name = std::move(name), .min = point(table, "min"), .max = point(table, "max")});
  });
  read_tables(keys, "capsules", [&](TomlReader& table, const std::string& /*name*/) {
    out.capsules.push_back({.link = table.get<std::string>("link").value_or(""),
                            .from = point(table, "from"),
                            .to = point(table, "to"),
                            .radius = required(table, "radius")});
  });
  keys.finish();
  keys.refuse(out.complaint(robot));
  return out;
}

}  // namespace

ExcitationOptions read_excitation_options(TomlReader keys, const std::filesystem::path& folder,
                                          const Robot& robot, std::vector<std::filesystem::path>& known) {
  const Index n = robot.size();
  ExcitationOptions out;
  keys.read(out, n);
  keys.read(out.noise, n);
  if (const toml::node* const node = keys.find("known")) {
    for (const toml::node* const item : TomlReader::items(*node)) {
      known.push_back(file_at(keys, *item, "known", folder));
    }
  }
  if (auto limits = keys.section("limits")) {
    limits->read(out.limits, n);
    limits->finish();
    limits->refuse(out.limits.complaint(n));
  }
  if (const auto space = keys.section("space")) {
    out.space = read_space(*space, robot);
  }
  keys.finish();
  keys.refuse(out.complaint(robot));
  return out;
}

}  // namespace detail

std::vector<std::filesystem::path> ExcitationPlan::inputs() const {
  std::vector<std::filesystem::path> out = {experiment.file, experiment.robot_file};
  out.insert(out.end(), known.begin(), known.end());
  return out;
}

Matrix known_information(const ExcitationPlan& plan) {
  if (plan.known.empty()) {
    return {};
  }
  const Robot& robot = plan.experiment.robot;
  const Vector& sigma = plan.options.noise.sigma;
  if (sigma.size() == 0) {
    throw InputError(plan.experiment.file.string() +
                     ": [excitation] noise is required with known: it says what earlier logs are worth");
  }
  LogSource source = plan.experiment.log;
  source.files = plan.known;
  const BaseParameters base = base_parameters(robot);
  const double noise_hz =
      plan.options.noise.rate_hz > 0.0 ? plan.options.noise.rate_hz : plan.options.rate_hz;
  Matrix out = Matrix::Zero(base.size(), base.size());
  for (const Log& log : read_logs(source, robot)) {
    SignalOptions signal = plan.experiment.estimation.signal;
    if (signal.automatic()) {
      signal = chosen_signal(robot, std::span(&log, 1), {.method = Wls{}, .signal = signal});
    }
    const Rows rows_of_log = rows(robot, base, log, signal);
    double n_d = 1.0;
    for (const int factor : signal.decimation) {
      n_d *= factor;
    }
    // A row stands for its part of the time.
    const double worth = noise_hz * n_d / log.f_m;
    for (std::size_t j = 0; j < rows_of_log.W.joints.size(); ++j) {
      const JointRows& joint = rows_of_log.W.joints[j];
      const double deviation = sigma[static_cast<Index>(j)];
      out(joint.columns, joint.columns) += worth / (deviation * deviation) * joint.W.transpose() * joint.W;
    }
  }
  return out;
}

}  // namespace rivid
