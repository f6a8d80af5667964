#include <algorithm>
#include <array>

#include "experiment/sections.hpp"

namespace rivid::detail {

namespace {

// Bounds of the masses of single links, `masses`, and what a given weight means.
void read_physical(TomlReader& keys, Physical& out) {
  if (keys.find("weight") != nullptr && keys.find("weight_may_fall") == nullptr) {
    out.weight_may_fall = false;
  }
  auto masses = keys.section("masses");
  if (!masses) {
    return;
  }
  for (const auto& [link, node] : masses->table()) {
    const auto bounds =
        masses->as<std::array<double, 2>>(node, {.key = link.str(), .must_be = "[least, most] in kg"});
    out.masses.push_back({.link = std::string(link.str()), .least = bounds[0], .most = bounds[1]});
  }
}

// `robust`, the name of a loss or "off", and how.
std::optional<Robust> read_robust(TomlReader& keys) {
  const toml::node* const loss = keys.find("robust");
  Robust out;
  if (loss != nullptr && loss->value_exact<std::string_view>() != "off") {
    constexpr auto losses = std::to_array<std::string_view>({"huber", "bisquare", "off"});
    out.kind = static_cast<RobustKind>(keys.word(*loss, "robust", losses));
  }
  keys.read(Robust::options(), out);
  if (loss == nullptr && out.tuning) {
    keys.fail(*keys.find("robust_tuning"), "robust_tuning", "needs robust = \"huber\" or \"bisquare\"");
  }
  return loss == nullptr || loss->value_exact<std::string_view>() == "off" ? std::nullopt
                                                                           : std::optional(out);
}

// `prefilter`, a switch or the order of the noise models.
void read_prefilter(TomlReader& keys, Iv& iv) {
  const toml::node* const node = keys.find("prefilter");
  if (node == nullptr) {
    return;
  }
  if (node->is_boolean()) {
    iv.prefilter = node->as_boolean()->get();
    return;
  }
  const auto order = node->value_exact<std::int64_t>();
  if (!order || *order < 1 || *order > Iv::most_prefilter_order) {
    keys.fail(*node, "prefilter",
              (order ? "is " + std::to_string(*order) + ", " : "") +
                  "must be true, false or an order from 1 to " + std::to_string(Iv::most_prefilter_order));
  }
  iv.prefilter = true;
  iv.prefilter_order = static_cast<int>(*order);
}

// `gains`: "known", "estimate", or what is known of them.
std::optional<GainOptions> read_gains(TomlReader& keys, const std::filesystem::path& folder,
                                      Experiment& out) {
  const toml::node* const node = keys.find("gains");
  if (node == nullptr || !node->is_table()) {
    constexpr auto words = std::to_array<std::string_view>({"known", "estimate"});
    const auto word = keys.word("gains", words);
    return word && *word == 1 ? std::optional(GainOptions{}) : std::nullopt;
  }
  TomlReader options = keys.section(*node, "gains");
  GainOptions gains;
  options.read(gains);
  if (auto known = options.section("known")) {
    for (const auto& [joint, sigma] : known->table()) {
      gains.known[std::string(joint.str())] =
          known->as<double>(sigma, Wanted{.key = joint.str(), .range = gain_sigma_range});
    }
  }
  if (const toml::node* const files = options.find("loaded")) {
    out.loaded = out.log;
    out.loaded.files.clear();
    for (const toml::node* const file : TomlReader::items(*files)) {
      out.loaded.files.push_back(file_at(options, *file, "loaded", folder));
    }
  }
  options.finish();
  options.refuse(gains.complaint(out.robot));
  if (gains.mass.has_value() == out.loaded.files.empty()) {
    options.fail("mass and loaded belong together: the logs with a payload, and its mass");
  }
  return gains;
}

}  // namespace

SignalOptions read_signal(TomlReader keys, Index n) {
  SignalOptions out;
  keys.read(out, n);
  if (keys.find("torque_order") == nullptr) {
    out.torque_order = out.order;
  }
  const toml::node* const threshold = keys.find("velocity_threshold");
  if (threshold != nullptr && !threshold->is_array()) {
    out.velocity_threshold.resize(static_cast<std::size_t>(n), out.velocity_threshold.front());
  }
  keys.finish();
  keys.refuse(out.complaint(n));
  return out;
}

void read_method(TomlReader keys, Experiment& out) {
  const auto method = keys.word("name", method_names);
  Estimation& estimation = out.estimation;
  keys.read(estimation.covariance);
  estimation.physical = keys.switched<Physical>("physical", [&](TomlReader& options, Physical& physical) {
    read_physical(options, physical);
    options.finish();
    options.refuse(physical.complaint(out.robot));
  });
  estimation.essential = keys.switched<Essential>(
      "essential", [](const TomlReader& options, const Essential&) { options.finish(); });
  estimation.robust = read_robust(keys);
  out.loaded = {};
  out.gains = read_gains(keys, out.file.parent_path(), out);
  keys.read(out.iv);
  read_prefilter(keys, out.iv);
  if (auto simulation = keys.section("simulation")) {
    simulation->read(SimulationOptions::integration(), out.iv.simulation, out.robot.size());
    simulation->finish();
    simulation->refuse(out.iv.simulation.complaint(out.robot.size()));
  }
  keys.finish();
  out.take_method(method ? method_names[*method] : name(estimation.method));
}

}  // namespace rivid::detail
