#include "rivid/report/payload.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "experiment/json_fields.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::Json;
using detail::json_of;

std::string right_aligned(const std::string& text, std::size_t width) {
  return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

std::string payload_interval(const std::array<double, 2>& interval) {
  return "[" + number(interval[0], 4) + ", " + number(interval[1], 4) + "]";
}

std::string payload_line(const std::string& name, double value, double sigma,
                         const std::array<double, 2>& interval, const std::string& rest) {
  std::string out = "  " + name;
  out.resize(std::max<std::size_t>(out.size(), 26), ' ');
  return out + right_aligned(number(value, 5), 12) + right_aligned(number(sigma, 3), 12) + "   " +
         payload_interval(interval) + "  " + rest + '\n';
}

Json json_of_value(double value, double sigma, const std::array<double, 2>& interval) {
  return {{"value", value}, {"sigma", sigma}, {"interval_95", interval}};
}

}  // namespace

std::string in_words(const Payload& payload) {
  std::string out = payload.identified ? "identified" : "NOT IDENTIFIED";
  out += ": " +
         std::string(payload.model == PayloadModel::body ? "ten parameters" : "mass and centre of mass") +
         ", " + counted(payload.rows, "row") + ", relative error " +
         number(100.0 * payload.relative_error, 3) + " %\n";
  if (!payload.reason.empty()) {
    out += payload.reason + '\n';
  }
  if (payload.values.empty()) {
    return out;
  }
  out += "\n  in the flange frame              value       sigma   95 % interval\n";
  for (const PayloadValue& v : payload.values) {
    out += payload_line(v.name, v.value, v.sigma, v.interval_95, v.unit);
  }
  if (!payload.gains.empty()) {
    out += "\n  drive gain                       value       sigma   95 % interval\n";
    for (const GainEstimate& g : payload.gains) {
      out += payload_line(g.joint, g.value, g.sigma, g.interval_95,
                          "nominal " + number(g.nominal, 5) + (g.identifiable ? "" : ", not identifiable"));
    }
  }
  return out + '\n' + urscript_line(payload) + '\n' + libfranka_line(payload) + '\n';
}

std::string to_json(const Payload& payload, const PayloadOptions& options) {
  Json values = Json::object();
  for (const PayloadValue& v : payload.values) {
    Json& member = values[v.name] = json_of_value(v.value, v.sigma, v.interval_95);
    member["unit"] = v.unit;
  }
  Json gains = Json::array();
  for (const GainEstimate& g : payload.gains) {
    Json member = {{"joint", g.joint}, {"nominal", g.nominal}};
    member.update(json_of_value(g.value, g.sigma, g.interval_95));
    member["identifiable"] = g.identifiable;
    gains.push_back(std::move(member));
  }
  const Json out = {{"status", payload.identified ? "identified" : "not_identified"},
                    {"reason", payload.reason},
                    {"model", name(payload.model)},
                    {"rows", payload.rows},
                    {"relative_error", payload.relative_error},
                    {"iterations", payload.iterations},
                    {"covariance", json_of(payload.covariance)},
                    {"flange", {{"R", json_of(options.R)}, {"p", json_of(options.p)}}},
                    {"payload", std::move(values)},
                    {"gains", std::move(gains)},
                    {"Fl", json_of(payload.Fl)},
                    {"chi", json_of(payload.chi)},
                    {"urscript", urscript_line(payload)},
                    {"libfranka", libfranka_line(payload)}};
  return out.dump(2) + "\n";
}

}  // namespace rivid
