#include <algorithm>
#include <array>
#include <map>

#include "experiment/sections.hpp"

namespace rivid::detail {

// Bounds of the masses of single links, `masses`, and what a given weight means.
void read_more(TomlReader& keys, Physical& out) {
  if (keys.find("weight") != nullptr && keys.find("weight_may_fall") == nullptr) {
    out.weight_may_fall = false;
  }
  std::map<std::string, std::array<double, 2>> masses;
  keys.set(masses, {.key = "masses", .details = {.must_be = "[least, most] in kg"}});
  for (const auto& [link, bounds] : masses) {
    out.masses.push_back({.link = link, .least = bounds[0], .most = bounds[1]});
  }
}

namespace {

// `robust`, the name of a loss or "off", and how.
std::optional<Robust> read_robust(TomlReader& keys) {
  Robust out;
  keys.read(out);
  const toml::node* const loss = keys.find("robust");
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
std::optional<GainOptions> read_gains(TomlReader& keys, Experiment& out) {
  const toml::node* const node = keys.find("gains");
  if (node == nullptr || !node->is_table()) {
    constexpr auto words = std::to_array<std::string_view>({"known", "estimate"});
    const auto word = keys.word("gains", words);
    return word && *word == 1 ? std::optional(GainOptions{}) : std::nullopt;
  }
  TomlReader options = keys.section(*node, "gains");
  GainOptions gains;
  options.read(gains);
  out.loaded = out.log;
  out.loaded.files.clear();
  options.set(out.loaded.files, {.key = "loaded"});
  options.finish();
  options.refuse(gains.complaint(out.robot));
  if (gains.mass.has_value() == out.loaded.files.empty()) {
    options.fail("mass and loaded belong together: the logs with a payload, and its mass");
  }
  return gains;
}

}  // namespace

SignalOptions read_signal(TomlReader keys) {
  SignalOptions out;
  keys.read(out);
  if (keys.find("torque_order") == nullptr) {
    out.torque_order = out.order;
  }
  const toml::node* const threshold = keys.find("velocity_threshold");
  if (threshold != nullptr && !threshold->is_array()) {
    out.velocity_threshold.resize(static_cast<std::size_t>(keys.joints()), out.velocity_threshold.front());
  }
  keys.finish();
  keys.refuse(out.complaint(keys.joints()));
  if (!out.velocity_threshold.empty()) {
    const auto of_base = static_cast<std::size_t>(keys.robot().base_joints);
    out.velocity_threshold.insert(out.velocity_threshold.begin(), of_base, 0.0);
  }
  return out;
}

void read_method(TomlReader keys, Experiment& out) {
  const auto method = keys.word("name", method_names);
  Estimation& estimation = out.estimation;
  keys.read(estimation.covariance);
  estimation.physical.reset();
  keys.set(estimation.physical, {.key = "physical"});
  estimation.essential.reset();
  keys.set(estimation.essential, {.key = "essential"});
  estimation.robust = read_robust(keys);
  out.loaded = {};
  out.gains = read_gains(keys, out);
  keys.read(out.iv);
  read_prefilter(keys, out.iv);
  if (auto simulation = keys.section("simulation")) {
    simulation->read(SimulationOptions::integration(), out.iv.simulation);
    simulation->finish();
    simulation->refuse(out.iv.simulation.complaint(keys.joints()));
  }
  keys.finish();
  out.take_method(method ? method_names[*method] : name(estimation.method));
}

}  // namespace rivid::detail
