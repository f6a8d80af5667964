#include "rivid/report/payload.hpp"

#include <array>
#include <functional>
#include <type_traits>

#include "experiment/json_fields.hpp"
#include "report/document.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::Json;
using detail::json_of;

std::string payload_interval(const std::array<double, 2>& interval) {
  return "[" + number(interval[0], 4) + ", " + number(interval[1], 4) + "]";
}

// Values with their deviations and intervals; what else there is of them stands last.
template <typename Value>
detail::Table interval_table(const std::vector<Value>& values, const std::string& heading,
                             std::string Value::* name,
                             const std::type_identity_t<std::function<detail::Cell(const Value&)>>& rest) {
  using V = Value;
  return detail::table_of<std::vector<V>>(
      values, {{{heading}, [=](const V& v) { return v.*name; }},
               {{"value", detail::format::significant(5)}, [](const V& v) { return v.value; }},
               {{"sigma", detail::format::significant(3)}, [](const V& v) { return v.sigma; }},
               {{"95 % interval"}, [](const V& v) { return payload_interval(v.interval_95); }},
               {{""}, rest}});
}

detail::Document payload_document(const Payload& payload) {
  detail::Document out;
  out.line = (payload.identified ? "identified: " : "NOT IDENTIFIED: ") +
             std::string(payload.model == PayloadModel::body ? "ten parameters" : "mass and centre of mass") +
             ", " + counted(payload.rows, "row") + ", relative error " +
             number(100.0 * payload.relative_error, 3) + " %";
  if (!payload.reason.empty()) {
    out.opening.push_back({detail::Sentence{payload.reason}});
  }
  if (!payload.values.empty()) {
    out.sections.push_back(
        {.heading = "Payload",
         .blocks = {{interval_table(payload.values, "in the flange frame", &PayloadValue::name,
                                    [](const PayloadValue& v) { return v.unit; })}}});
  }
  if (!payload.gains.empty()) {
    out.sections.push_back({.heading = "Drive gains",
                            .blocks = {{interval_table(payload.gains, "drive gain", &GainEstimate::joint,
                                                       [](const GainEstimate& g) {
                                                         return "nominal " + number(g.nominal, 5) +
                                                                (g.identifiable ? "" : ", not identifiable");
                                                       })}}});
  }
  return out;
}

Json json_of_value(double value, double sigma, const std::array<double, 2>& interval) {
  return {{"value", value}, {"sigma", sigma}, {"interval_95", interval}};
}

}  // namespace

std::string in_words(const Payload& payload, std::size_t screen) {
  const std::string lines =
      payload.values.empty() ? "" : '\n' + urscript_line(payload) + '\n' + libfranka_line(payload) + '\n';
  return detail::text_of(payload_document(payload), screen) + lines;
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
  return detail::json_text(out);
}

}  // namespace rivid
