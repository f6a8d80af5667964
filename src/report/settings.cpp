#include "joined.hpp"
#include "report/documents.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid::detail {

namespace {

std::string cutoff(double hz, int order) {
  return hz > 0.0 ? number(hz, 4) + " Hz, order " + std::to_string(order) + ", forward and backward" : "none";
}

std::string decimation(const std::vector<int>& factors) {
  const auto digits = [](int n_d) { return std::to_string(n_d); };
  return factors.empty() ? "none" : "by " + joined(factors, ", then by ", digits);
}

std::string thresholds(const SignalOptions& signal) {
  const std::string speeds =
      joined(signal.velocity_threshold, ", ", [](double speed) { return number(speed, 4); });
  return speeds.empty() ? std::string(signal.exact_rows() ? "about reversals and standstill" : "none")
                        : "below " + speeds + " rad/s or m/s, joint by joint";
}

}  // namespace

Settings row_settings(const SignalOptions& signal) {
  Settings out = {{"Rows", std::string(name(signal.exact_rows() ? RowScheme::exact : RowScheme::paper)) +
                               (signal.convention == Convention::matlab ? ", convention matlab" : "") +
                               (signal.held() ? ", torques held between samples" : "")},
                  {"Filter of the positions", cutoff(signal.cutoff_hz, signal.order)},
                  {"Filter of the torques", cutoff(signal.torque_cutoff_hz, signal.torque_order)},
                  {"Decimation", decimation(signal.decimation)},
                  {"Left out", thresholds(signal)}};
  if (signal.trim) {
    out.emplace_back("Trimmed at either end", std::to_string((*signal.trim)[0]) + " and " +
                                                  std::to_string((*signal.trim)[1]) + " samples");
  }
  if (signal.window) {
    out.emplace_back("Window", number((*signal.window)[0]) + " to " + number((*signal.window)[1]) + " s");
  }
  return out;
}

Table run_table(const Provenance& provenance, const Settings& settings) {
  Table out{{{""}, {""}}};
  const auto add = [&](const std::string& what, const std::string& value) {
    out.rows.push_back({{what, value}});
  };
  add("Program", provenance.program + ", rivid " + std::string(version));
  add("Run", run_id(provenance));
  for (const auto& [what, value] : settings) {
    add(what, value);
  }
  for (const auto& [flag, value] : provenance.overrides) {
    add("Flag --" + flag, value);
  }
  return out;
}

Table inputs_table(const Provenance& provenance) {
  Table out{{{"input"}, {"SHA-256"}}};
  for (const InputFile& file : provenance.inputs) {
    out.rows.push_back({{file.path, file.sha256}});
  }
  return out;
}

}  // namespace rivid::detail
