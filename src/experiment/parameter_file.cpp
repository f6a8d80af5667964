#include "experiment/parameter_file.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "experiment/json_node.hpp"
#include "experiment/text_file.hpp"
#include "experiment/toml_reader.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using Path = std::filesystem::path;
using detail::NamedValues;

constexpr std::string_view what = "the parameter file";

void read_json(NamedValues& out, const Path& path) {
  nlohmann::json file = detail::parsed_json(path, what, {});
  const nlohmann::json& list = file.is_object() && file.contains("parameters") ? file["parameters"] : file;
  if (list.is_object()) {
    for (const auto& [name, node] : list.items()) {
      out.add(name, node);
    }
    return;
  }
  if (!list.is_array()) {
    throw InputError(path.string() + ": must hold an object or a list \"parameters\"");
  }
  for (const nlohmann::json& item : list) {
    if (!item.is_object() || !item.contains("name") || !item["name"].is_string() || !item.contains("value")) {
      throw InputError(path.string() + ": each of \"parameters\" must have a name and a value");
    }
    out.add(item["name"].get<std::string>(), item);
  }
}

void read_toml(NamedValues& out, const Path& path) {
  const toml::table table = detail::parsed_toml(path, what);
  detail::TomlReader top(table, path.string(), "");
  auto section = top.section("parameters");
  if (section) {
    top.finish();
  }
  const detail::TomlReader& keys = section ? *section : top;
  for (const auto& [name, node] : keys.table()) {
    out.add(std::string(name.str()), keys.as<double>(node, name.str()));
  }
}

void read_csv(NamedValues& out, const Path& path) {
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

}  // namespace

Vector read_parameters(const Path& path, const BaseParameters& base) {
  NamedValues values(path.string());
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
  return values.standard(base);
}

}  // namespace rivid
