#include "rivid/report/payload.hpp"

#include <algorithm>
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
               {{"value", detail::format::significant(5)}, &V::value},
               {{"sigma", detail::format::significant(3)}, &V::sigma},
               {{"95 % interval"}, [](const V& v) { return payload_interval(v.interval_95); }},
               {{""}, rest}});
}

// One payload, or what one has more than another.
detail::Section payload_section(const Payload& payload, const std::string& heading) {
  detail::Section out{.heading = heading, .blocks = {}};
  if (!payload.reason.empty()) {
    out.blocks.push_back({detail::Sentence{payload.reason}});
  }
  out.blocks.push_back({interval_table(payload.values, payload.name + ", in the flange frame",
                                       &PayloadValue::name, &PayloadValue::unit)});
  return out;
}

detail::Document payload_document(const PayloadReport& found) {
  detail::Document out;
  const auto present = std::ranges::count(found.payloads, false, &Payload::none);
  out.line =
      std::string(found.identified ? "identified: "
                  : found.doubtful ? "DOUBTFUL: "
                                   : "NOT IDENTIFIED: ") +
      (present > 0 || found.payloads.empty() ? counted(present, "payload") : found.payloads.front().reason) +
      ", " + counted(found.rows, "row") + ", relative error " + number(100.0 * found.relative_error, 3) +
      " %";
  // The reasons of a doubtful result are findings, which say what to do as well.
  if (!found.doubtful && !found.reason.empty()) {
    out.opening.push_back({detail::Sentence{found.reason}});
  }
  // Warnings are those of the arm, which its identification tells.
  detail::FindingList errors{found.warnings};
  std::erase_if(errors.findings, [](const Finding& f) { return severity(f) != Severity::error; });
  out.opening.push_back({std::move(errors)});
  for (const Payload& payload : found.payloads) {
    const char* shape = payload.none()                        ? ": mass"
                        : payload.model == PayloadModel::body ? ": ten parameters"
                                                              : ": mass and centre of mass";
    out.sections.push_back(payload_section(payload, payload.name + shape));
  }
  for (const Payload& difference : found.differences) {
    out.sections.push_back(payload_section(difference, "Difference " + difference.name));
  }
  if (!found.gains.empty()) {
    out.sections.push_back({.heading = "Drive gains",
                            .blocks = {{interval_table(found.gains, "drive gain", &GainEstimate::joint,
                                                       [](const GainEstimate& g) {
                                                         return "nominal " + number(g.nominal, 5) +
                                                                (g.identifiable ? "" : ", not identifiable");
                                                       })}}});
  }
  return out;
}

Json json_of_body(const Payload& payload) {
  Json values = Json::object();
  for (const PayloadValue& v : payload.values) {
    values[v.name] = {
        {"value", v.value}, {"sigma", v.sigma}, {"interval_95", v.interval_95}, {"unit", v.unit}};
  }
  return {{"name", payload.name},
          {"reason", payload.reason},
          {"model", name(payload.model)},
          {"values", std::move(values)}};
}

std::string libfranka_or_why(const Payload& payload) {
  return payload.model == PayloadModel::body
             ? libfranka_line(payload)
             : "no line for libfranka: setLoad() must be told the inertia, which the motion does not show";
}

}  // namespace

std::string in_words(const PayloadReport& found, std::size_t screen) {
  std::string out = detail::text_of(payload_document(found), screen);
  for (const Payload& payload : found.payloads) {
    const std::string who = found.payloads.size() > 1 ? payload.name + ":\n" : "";
    const std::string untold = untold_reason(found, payload);
    out += '\n' + who +
           (untold.empty() ? urscript_line(payload) + '\n' + libfranka_or_why(payload)
                           : "no line for a controller: " + untold) +
           '\n';
  }
  return out;
}

std::string to_json(const PayloadReport& found, const PayloadOptions& options) {
  const auto with_lines = [&](const Payload& payload) {
    Json out = json_of_body(payload);
    const std::string untold = untold_reason(found, payload);
    out["least_mass"] = payload.least_mass;
    out["urscript"] = untold.empty() ? Json(urscript_line(payload)) : Json();
    out["libfranka"] =
        untold.empty() && payload.model == PayloadModel::body ? Json(libfranka_line(payload)) : Json();
    out["untold"] = untold;
    return out;
  };
  const Json out = {{"program", "rivid_identify payload"},
                    {"status", found.identified ? "identified"
                               : found.doubtful ? "doubtful"
                                                : "not_identified"},
                    {"reason", found.reason},
                    {"warnings", detail::warnings_of(found.warnings)},
                    {"rows", found.rows},
                    {"relative_error", found.relative_error},
                    {"iterations", found.iterations},
                    {"covariance", json_of(found.covariance)},
                    {"flange", {{"R", json_of(options.R)}, {"p", json_of(options.p)}}},
                    {"payloads", detail::json_list(found.payloads, with_lines)},
                    {"differences", detail::json_list(found.differences, json_of_body)},
                    {"gains", json_of(found.gains)},
                    {"Fl", json_of(found.Fl)},
                    {"chi", json_of(found.chi)}};
  return detail::json_text(out);
}

}  // namespace rivid
