#include "rivid/experiment/parameter_file.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "experiment/text_file.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using Path = std::filesystem::path;
using Json = nlohmann::json;

constexpr std::string_view what = "the parameter file";

// Names and values as the file tells them, each once.
class Values {
 public:
  explicit Values(std::string where) : where_(std::move(where)) {}

  void add(const std::string& name, double value) {
    if (!std::isfinite(value)) {
      throw InputError(where_ + ": " + in_quotes(name) + " is " + number(value) + ", must be finite");
    }
    if (!values_.emplace(name, value).second) {
      throw InputError(where_ + ": " + in_quotes(name) + " is there twice");
    }
  }

  [[nodiscard]] const std::string& where() const { return where_; }
  [[nodiscard]] const std::map<std::string, double>& all() const { return values_; }

  // Those of `names` that are not there.
  [[nodiscard]] std::vector<std::string> missing(const std::vector<std::string>& names) const {
    std::vector<std::string> out;
    std::ranges::copy_if(names, std::back_inserter(out),
                         [&](const std::string& name) { return !values_.contains(name); });
    return out;
  }

  // In the order of `names`, which are all there.
  [[nodiscard]] Vector in_order(const std::vector<std::string>& names) const {
    Vector out(static_cast<Index>(names.size()));
    for (std::size_t i = 0; i < names.size(); ++i) {
      out[static_cast<Index>(i)] = values_.at(names[i]);
    }
    return out;
  }

 private:
  std::string where_;
  std::map<std::string, double> values_;
};

void add_json(Values& out, const std::string& name, const Json& node) {
  const Json& value = node.is_object() && node.contains("value") ? node["value"] : node;
  if (!value.is_number()) {
    throw InputError(out.where() + ": the value of " + in_quotes(name) + " is " + value.dump() +
                     ", must be a number" + (value.is_null() ? "; null is a parameter not determined" : ""));
  }
  out.add(name, value.get<double>());
}

void read_json(Values& out, const Path& path) {
  Json file;
  try {
    file = Json::parse(detail::file_text(path, what));
  } catch (const Json::exception& e) {
    throw InputError(path.string() + ": " + e.what());
  }
  const Json& list = file.is_object() && file.contains("parameters") ? file["parameters"] : file;
  if (list.is_object()) {
    for (const auto& [name, node] : list.items()) {
      add_json(out, name, node);
    }
    return;
  }
  if (!list.is_array()) {
    throw InputError(path.string() + ": must hold an object or a list \"parameters\"");
  }
  for (const Json& item : list) {
    if (!item.is_object() || !item.contains("name") || !item["name"].is_string() || !item.contains("value")) {
      throw InputError(path.string() + ": each of \"parameters\" must have a name and a value");
    }
    add_json(out, item["name"].get<std::string>(), item);
  }
}

void read_toml(Values& out, const Path& path) {
  const toml::table table = detail::parsed_toml(path, what);
  detail::TomlReader top(table, path.string(), "");
  auto section = top.section("parameters");
  if (section) {
    top.finish();
  }
  const detail::TomlReader& keys = section ? *section : top;
  for (const auto& [name, node] : keys.table()) {
    out.add(std::string(name.str()), keys.as_number(node, name.str()));
  }
}

void read_csv(Values& out, const Path& path) {
  const detail::TextTable table = detail::read_text_table(path, what);
  const std::vector<std::string>& titles = table.header.cells;
  const auto place = [&](std::string_view title) {
    const auto at = std::ranges::find(titles, title);
    if (at == titles.end()) {
      throw InputError(path.string() + ": the header has no column \"" + std::string(title) +
                       "\"; a parameter file has name and value");
    }
    return static_cast<std::size_t>(at - titles.begin());
  };
  const std::size_t name = place("name");
  const std::size_t value = place("value");
  for (const detail::TextTable::Row& row : table.rows) {
    out.add(row.cells[name], detail::cell_number(row, value, "value"));
  }
}

// The names of a kind of parameters, against those of a file.
struct Kind {
  std::string_view title;
  std::vector<std::string> names;
  std::vector<std::string> missing;
  std::vector<std::string> unknown;

  Kind(std::string_view kind, std::vector<std::string> all, const Values& values)
      : title(kind), names(std::move(all)), missing(values.missing(names)) {
    for (const auto& [name, value] : values.all()) {
      if (std::ranges::find(names, name) == names.end()) {
        unknown.push_back(name);
      }
    }
  }

  [[nodiscard]] std::size_t differences() const { return missing.size() + unknown.size(); }
};

}  // namespace

Vector read_parameters(const Path& path, const BaseParameters& base) {
  Values values(path.string());
  const std::string form = path.extension().string();
  if (form == ".json") {
    read_json(values, path);
  } else if (form == ".toml") {
    read_toml(values, path);
  } else if (form == ".csv") {
    read_csv(values, path);
  } else {
    throw InputError(path.string() + ": a parameter file is called .json, .toml or .csv");
  }

  std::vector<std::string> base_names;
  std::vector<std::string> standard_names;
  base_names.reserve(base.parameters.size());
  standard_names.reserve(base.standard.size());
  for (const BaseParameter& p : base.parameters) {
    base_names.push_back(p.name);
  }
  for (const StandardParameter& p : base.standard) {
    standard_names.push_back(p.name());
  }
  const Kind of_base("base", std::move(base_names), values);
  const Kind of_standard("standard", std::move(standard_names), values);
  const bool is_base = of_base.differences() <= of_standard.differences();
  const Kind& kind = is_base ? of_base : of_standard;
  if (!kind.unknown.empty()) {
    const std::string& name = kind.unknown.front();
    throw InputError(path.string() + ": " + in_quotes(name) + " is none of the robot's " +
                     std::to_string(kind.names.size()) + " " + std::string(kind.title) + " parameters, " +
                     listed(kind.names) + did_you_mean(name, kind.names));
  }
  if (!kind.missing.empty()) {
    throw InputError(
        path.string() + ": " + listed(kind.missing) + (kind.missing.size() == 1 ? " is" : " are") +
        " missing; a parameter file names all of the robot's " + std::to_string(of_base.names.size()) +
        " base or all of its " + std::to_string(of_standard.names.size()) + " standard parameters");
  }
  const Vector chosen = values.in_order(kind.names);
  return is_base ? base.to_standard(chosen) : chosen;
}

}  // namespace rivid
