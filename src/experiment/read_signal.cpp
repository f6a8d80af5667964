#include <array>

#include "experiment/identification_sections.hpp"

namespace rivid::detail {

namespace {

// A frequency, or "off" for no filter.
std::optional<double> cutoff(TomlReader& keys, std::string_view key) {
  const toml::node* const node = keys.find(key);
  if (node == nullptr) {
    return std::nullopt;
  }
  if (node->is_string() && keys.as_text(*node, key) == "off") {
    return 0.0;
  }
  const double value = node->is_string() ? -1.0 : keys.as_number(*node, key);
  if (value <= 0.0) {
    keys.fail(*node, key, "must be a frequency in Hz, or \"off\" for no filter");
  }
  return value;
}

}  // namespace

SignalOptions read_signal(TomlReader keys, Index n) {
  SignalOptions out;
  const auto cutoff_hz = cutoff(keys, "cutoff_hz");
  if (!cutoff_hz) {
    keys.look_for_mistyped({"cutoff_hz"});
    keys.fail(
        "must say cutoff_hz, the cut-off of the position filter in Hz: some ten times the highest frequency "
        "of the motion, or \"off\" for no filter");
  }
  out.rows = keys.choice("rows",
                         std::array<std::pair<std::string_view, RowScheme>, 2>{
                             {{"paper", RowScheme::paper}, {"exact", RowScheme::exact}}})
                 .value_or(out.rows);
  out.torque_held = keys.boolean("torque_held").value_or(out.torque_held);
  out.cutoff_hz = *cutoff_hz;
  out.torque_cutoff_hz = cutoff(keys, "torque_cutoff_hz").value_or(0.0);
  out.order = keys.count("order").value_or(out.order);
  out.torque_order = keys.count("torque_order").value_or(out.order);
  out.decimation = keys.counts("decimation").value_or(std::vector<int>{});
  const toml::node* const trim = keys.find("trim");
  if (trim != nullptr && !(trim->is_string() && keys.as_text(*trim, "trim") == "auto")) {
    const auto ends = keys.integers("trim").value_or(std::vector<std::int64_t>{});
    if (ends.empty() || ends.size() > 2) {
      keys.fail(*trim, "trim", "must be one number of samples for both ends, [begin, end], or \"auto\"");
    }
    out.trim = {ends.front(), ends.back()};
  }
  if (const auto threshold = keys.numbers("velocity_threshold")) {
    const bool for_all = !keys.find("velocity_threshold")->is_array();
    out.velocity_threshold =
        for_all ? std::vector<double>(static_cast<std::size_t>(n), threshold->front()) : *threshold;
  }
  if (const auto window = keys.numbers("window")) {
    if (window->size() != 2) {
      keys.fail(*keys.find("window"), "window", "must be [begin, end] in seconds");
    }
    out.window = {(*window)[0], (*window)[1]};
  }
  out.convention = keys.choice("convention",
                               std::array<std::pair<std::string_view, Convention>, 2>{
                                   {{"standard", Convention::standard}, {"matlab", Convention::matlab}}})
                       .value_or(out.convention);
  keys.finish();
  if (const auto complaint = out.complaint(n)) {
    keys.fail(*complaint);
  }
  return out;
}

}  // namespace rivid::detail
