#include <algorithm>
#include <cmath>
#include <set>

#include "experiment/json_fields.hpp"
#include "experiment/sections.hpp"
#include "report/page_lists.hpp"
#include "report/page_tables.hpp"

namespace rivid::detail {

namespace {

Json object_of(Json properties) {
  return {{"type", "object"}, {"additionalProperties", false}, {"properties", std::move(properties)}};
}
Json list_of(Json items) { return {{"type", "array"}, {"items", std::move(items)}}; }
Json reference_to(const std::string& place) { return {{"$ref", "#/" + place}}; }

// Keys of [robot] that are not those of a joint.
const std::set<std::string>& keys_of_robot() {
  static const std::set<std::string> out = std::apply(
      [](const auto&... field) { return std::set<std::string>{std::string(field.key)...}; }, robot_keys);
  return out;
}

// The tables of the page as a JSON Schema, each with the keys that may stand in it.
class Schema {
 public:
  [[nodiscard]] Json section(const std::string& name) const {
    std::vector<std::string> names = {name};
    if (name == "method") {
      names.emplace_back("method.iv");
    } else if (name == "control" || name == "reference") {
      for (const std::string& choice : choices_of(name)) {
        names.push_back(name + "." + choice);
      }
    }
    return table(name, names);
  }

  // A table with the keys of some tables of the page; `at` is its place in the file.
  [[nodiscard]] Json table(const std::string& at, const std::vector<std::string>& names) const {
    Json properties = Json::object();
    for (const std::string& name : names) {
      for (const KeyRow& row : rows_.at(name)) {
        if (at == "robot.joints" && keys_of_robot().contains(row.key)) {
          continue;
        }
        Json& key = properties[row.key];
        Json own = property(at + "." + row.key, row);
        // Laws and motions share keys.
        key = key.is_null() || key == own ? std::move(own) : Json{{"anyOf", {key, own}}};
      }
    }
    return object_of(std::move(properties));
  }

 private:
  // Laws of [control], motions of [reference].
  [[nodiscard]] std::vector<std::string> choices_of(const std::string& section) const {
    std::vector<std::string> out;
    for (const auto& [name, rows] : rows_) {
      if (name.starts_with(section + ".")) {
        out.push_back(name.substr(section.size() + 1));
      }
    }
    return out;
  }

  // What stands behind a key that is a table, or a list of them.
  [[nodiscard]] Json nested(const std::string& at) const {
    const std::string key = at.substr(at.rfind('.') + 1);
    if (key == "signal" || key == "control" || key == "simulation") {
      return reference_to("properties/" + key);
    }
    if (key == "joints") {
      return {{"type", "object"}, {"additionalProperties", table(at, {"robot", "robot.joints"})}};
    }
    if (key == "trial") {
      return table(at, {"montecarlo.trial", "method", "method.iv"});
    }
    if (rows_.contains(at)) {
      return table(at, {at});
    }
    for (const auto& [list, one] : {std::pair("half_spaces", "half_space"), std::pair("boxes", "box"),
                                    std::pair("capsules", "capsule"), std::pair("ignored", "link_pair")}) {
      if (key == list) {
        return table(at, {std::string("excitation.") + one});
      }
    }
    return {{"type", "object"}};
  }

  // One of the kinds that may stand for a key.
  [[nodiscard]] Json kind(const std::string& at, ValueKind value, const KeyRow& row) const {
    switch (value) {
      case ValueKind::boolean:
        return {{"type", "boolean"}};
      case ValueKind::integer:
      case ValueKind::number: {
        Json out = {{"type", value == ValueKind::integer ? "integer" : "number"}};
        if (std::isfinite(row.range.least)) {
          out[row.range.open ? "exclusiveMinimum" : "minimum"] = row.range.least;
        }
        if (std::isfinite(row.range.most)) {
          out[row.range.open && !row.range.budget ? "exclusiveMaximum" : "maximum"] = row.range.most;
        }
        return out;
      }
      case ValueKind::word:
      case ValueKind::string:
      case ValueKind::file:
        return {{"type", "string"}};
      case ValueKind::list:
        return {{"type", "array"}};
      case ValueKind::two_numbers:
      case ValueKind::three_numbers: {
        const int size = value == ValueKind::two_numbers ? 2 : 3;
        return {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", size}, {"maxItems", size}};
      }
      case ValueKind::lists:
        return list_of({{"type", "array"}});
      case ValueKind::table:
        return nested(at);
      case ValueKind::tables:
        return list_of(nested(at));
      case ValueKind::column:
        return reference_to("definitions/column");
      case ValueKind::columns:
        return {{"anyOf", {reference_to("definitions/column"), list_of(reference_to("definitions/column"))}}};
    }
    return {};
  }

  // Words that may stand for a key.
  [[nodiscard]] std::vector<std::string> words(const std::string& at, const KeyRow& row) const {
    if (at.ends_with(".name") && row.kinds.front() == ValueKind::word) {
      return {method_names.begin(), method_names.end()};
    }
    return at == "control.law" || at == "reference.type" ? choices_of(at.substr(0, at.find('.'))) : row.words;
  }

  [[nodiscard]] Json property(const std::string& at, const KeyRow& row) const {
    Json choices = Json::array();
    const std::vector<std::string> named = words(at, row);
    if (!named.empty()) {
      choices.push_back({{"enum", std::set<std::string>(named.begin(), named.end())}});
    }
    for (const ValueKind value : row.kinds) {
      if (value != ValueKind::word || named.empty()) {
        choices.push_back(kind(at, value, row));
      }
    }
    if (at == "robot." + row.key && !keys_of_robot().contains(row.key)) {
      choices.push_back({{"type", "array"}});  // one each
    }
    Json out =
        choices.size() == 1 && !choices.front().contains("$ref") ? choices.front() : Json{{"anyOf", choices}};
    const std::string otherwise =
        row.otherwise.empty() || row.otherwise == "–" ? "" : ". Default: " + row.otherwise;
    out["description"] = row.meaning + (row.unit.empty() ? "" : " [" + row.unit + "]") + otherwise;
    return out;
  }

  std::map<std::string, std::vector<KeyRow>> rows_ = key_rows();
};

}  // namespace

std::string experiment_schema() {
  const Schema schema;
  Json sections = {{"validation", reference_to("properties/log")}};
  for (const char* const name : {"robot", "log", "signal", "method", "control", "reference", "simulation",
                                 "excitation", "montecarlo"}) {
    sections[name] = schema.section(name);
  }
  const Json column = {
      {"anyOf", {{{"type", {"string", "integer"}}}, schema.table("column", {"log.column"})}}};
  Json out = object_of(std::move(sections));
  out["$schema"] = "http://json-schema.org/draft-07/schema#";
  out["title"] = "Experiment file of rivid, docs/experiment.md";
  out["definitions"]["column"] = column;
  return json_text(out);
}

}  // namespace rivid::detail
