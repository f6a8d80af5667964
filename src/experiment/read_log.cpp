#include <algorithm>
#include <array>
#include <cmath>

#include "experiment/sections.hpp"
#include "rivid/data/log.hpp"

namespace rivid::detail {

namespace {

using Path = std::filesystem::path;

// A column by its name, or by its number counted from 1.
std::string column_name(const TomlReader& keys, const toml::node& node, std::string_view key) {
  if (node.is_integer()) {
    const std::int64_t column = keys.as<std::int64_t>(node, key);
    if (column < 1) {
      keys.fail(node, key, "is column " + std::to_string(column) + "; columns count from 1");
    }
    return "#" + std::to_string(column);
  }
  return keys.as<std::string>(node, key);
}

std::optional<double> unit_factor(TomlReader& keys, std::string_view key) {
  const auto word = keys.get<std::string>(key);
  if (!word) {
    return std::nullopt;
  }
  if (const auto complaint = unit_complaint(*word)) {
    keys.fail(*keys.find(key), std::string(key) + ":", *complaint);
  }
  return unit_scale(*word);
}

Column read_column(const TomlReader& keys, const toml::node& node, std::string_view key, double unit) {
  if (!node.is_table()) {
    return {column_name(keys, node, key), unit, 0.0};
  }
  TomlReader inner = keys.section(node, key);
  const toml::node* const column = inner.find("column");
  if (column == nullptr) {
    inner.look_for_mistyped({"column"});
    inner.fail("must say which column: { column = \"q1\", unit = \"deg\", sign = -1 }");
  }
  Column out{column_name(inner, *column, "column"), unit, inner.get<double>("offset").value_or(0.0)};
  out.scale = unit_factor(inner, "unit").value_or(unit);
  out.scale *= inner.get<double>("scale").value_or(1.0);
  if (const auto sign = inner.get<double>("sign")) {
    if (std::abs(*sign) != 1.0) {
      inner.fail(*inner.find("sign"), "sign", "is " + number(*sign) + ", must be 1 or -1");
    }
    out.scale *= *sign;
  }
  inner.finish();
  if (out.scale == 0.0) {
    inner.fail("has scale 0");
  }
  return out;
}

// Factors to SI, one for each quantity: units = { position = "deg", torque = "mNm" }.
class Units {
 public:
  explicit Units(TomlReader& keys);

  [[nodiscard]] double operator()(std::string_view quantity);

  // A unit without the columns that it is of would be passed over in silence.
  void finish(TomlReader& keys) const;

 private:
  static constexpr std::array<std::string_view, 7> quantities = {
      "position", "velocity", "torque", "control", "reference", "reference_velocity", "time"};

  std::set<std::string> idle_;  // quantities whose unit is given and was not asked for
  std::array<double, quantities.size()> scales_ = {1, 1, 1, 1, 1, 1, 1};
};

Units::Units(TomlReader& keys) {
  auto section = keys.section("units");
  if (!section) {
    return;
  }
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    if (const auto factor = unit_factor(*section, quantities[i])) {
      scales_[i] = *factor;
      idle_.emplace(quantities[i]);
    }
  }
  section->finish();
}

double Units::operator()(std::string_view quantity) {
  idle_.erase(std::string(quantity));
  return scales_[static_cast<std::size_t>(std::ranges::find(quantities, quantity) - quantities.begin())];
}

void Units::finish(TomlReader& keys) const {
  if (!idle_.empty()) {
    keys.fail(*keys.find("units"), "units",
              "names " + in_quotes(*idle_.begin()) + ", whose columns are not listed beside it; list them");
  }
}

LogOptions read_log_columns(TomlReader& keys, LogOptions out, Index n) {
  Units units(keys);
  std::apply(
      [&](const auto&... field) {
        const auto read = [&](const auto& one) {
          if constexpr (std::is_same_v<std::decay_t<decltype(one.member)>,
                                       std::vector<Column> LogOptions::*>) {
            if (keys.find(one.key) != nullptr) {
              out.*one.member = read_columns(keys, one.key, units(one.key), {}, n);
            }
          }
        };
        (read(field), ...);
      },
      LogOptions::fields());
  if (const toml::node* const time = keys.find("time")) {
    out.time = read_column(keys, *time, "time", units("time"));
  }
  units.finish(keys);
  keys.read(out);
  keys.read(out.table);
  if (const auto header = keys.get<bool>("header")) {
    out.table.header = *header ? Header::present : Header::absent;
  }
  return out;
}

LogSource::Reference read_reference_file(TomlReader keys, const Path& folder, const LogOptions& columns,
                                         Index n) {
  LogSource::Reference out;
  const auto file = file_named(keys, "file", folder);
  if (!file) {
    keys.look_for_mistyped({"file"});
    keys.fail("must name its file");
  }
  out.file = *file;
  out.columns.reference = columns.reference;
  out.columns.reference_velocity = columns.reference_velocity;
  out.columns.table = columns.table;
  out.columns = read_reference_columns(keys, std::move(out.columns), n, true);
  keys.read(out);
  keys.finish();
  return out;
}

std::vector<LogSource::Subtraction> read_subtractions(TomlReader& keys, const Path& folder,
                                                      const Robot& robot) {
  std::vector<LogSource::Subtraction> out;
  const toml::node* const node = keys.find("subtract");
  if (node == nullptr) {
    return out;
  }
  if (!node->is_array()) {
    keys.fail(*node, "subtract",
              "must be a list of tables: [{ joint = \"joint_2\", table = \"counterbalance.csv\" }]");
  }
  for (const toml::node* const item : TomlReader::items(*node)) {
    TomlReader inner = keys.section(*item, "subtract");
    LogSource::Subtraction s;
    const auto joint = inner.get<std::string>("joint");
    const auto table = file_named(inner, "table", folder);
    if (!joint || !table) {
      inner.look_for_mistyped({"joint", "table"});
      inner.fail("must name joint and table");
    }
    s.joint = joint_index(inner, *inner.find("joint"), "joint", *joint, robot);
    s.table = *table;
    inner.read(s);
    inner.finish();
    out.push_back(std::move(s));
  }
  return out;
}

}  // namespace

Path file_at(const TomlReader& keys, const toml::node& node, std::string_view key, const Path& folder) {
  const std::string name = keys.as<std::string>(node, key);
  if (name.empty()) {
    keys.fail(node, key, "must name a file");
  }
  return folder / Path(name);
}

std::optional<Path> file_named(TomlReader& keys, std::string_view key, const Path& folder) {
  const toml::node* const node = keys.find(key);
  return node == nullptr ? std::nullopt : std::optional(file_at(keys, *node, key, folder));
}

std::vector<Column> read_columns(TomlReader& keys, std::string_view key, double unit,
                                 const std::vector<Column>& otherwise, Index n) {
  const toml::node* const node = keys.find(key);
  if (node == nullptr) {
    return otherwise;
  }
  std::vector<Column> out;
  for (const toml::node* const item : TomlReader::items(*node)) {
    out.push_back(read_column(keys, *item, key, unit));
  }
  if (static_cast<Index>(out.size()) != n) {
    keys.fail(*node, key,
              "names " + counted(std::ssize(out), "column") + ", must name one for each of the " +
                  std::to_string(n) + " joints");
  }
  return out;
}

LogOptions read_reference_columns(TomlReader& keys, LogOptions columns, Index n, bool velocity) {
  Units units(keys);
  const auto listed = [&](std::string_view key, std::vector<Column>& out) {
    if (keys.find(key) != nullptr) {
      out = read_columns(keys, key, units(key), {}, n);
    }
  };
  listed("position", columns.reference);
  if (velocity) {
    listed("velocity", columns.reference_velocity);
  }
  if (const toml::node* const time = keys.find("time")) {
    columns.time = read_column(keys, *time, "time", units("time"));
  }
  units.finish(keys);
  columns.rate_hz = keys.get<double>("rate_hz", rate_range, "Hz");
  return columns;
}

std::optional<Matrix> read_matrix(TomlReader& keys, std::string_view key, Index rows, Index columns,
                                  const std::string& required) {
  const toml::node* const node = keys.find(key);
  if (node == nullptr) {
    return std::nullopt;
  }
  const toml::array* const lists = node->as_array();
  if (lists == nullptr || lists->empty() || (rows >= 0 && std::ssize(*lists) != rows)) {
    keys.fail(*node, key, "must be " + required);
  }
  Matrix out;
  for (std::size_t i = 0; i < lists->size(); ++i) {
    const toml::node& item = *lists->get(i);
    const toml::array* const row = item.as_array();
    const Index width = columns >= 0 || i == 0 ? columns : out.cols();
    if (row == nullptr || row->empty() || (width >= 0 && std::ssize(*row) != width)) {
      keys.fail(item, key, "must be " + required);
    }
    out.conservativeResize(static_cast<Index>(i) + 1, std::ssize(*row));
    for (std::size_t j = 0; j < row->size(); ++j) {
      out(static_cast<Index>(i), static_cast<Index>(j)) = keys.as<double>(*row->get(j), key);
    }
  }
  return out;
}

LogSource read_log_source(TomlReader keys, LogSource out, const Path& folder, const Robot& robot) {
  out.files.clear();
  const toml::node* const files = keys.find("files");
  if (files == nullptr) {
    keys.look_for_mistyped({"files"});
    keys.fail("must name at least one file in files");
  }
  for (const toml::node* const file : TomlReader::items(*files)) {
    out.files.push_back(file_at(keys, *file, "files", folder));
  }
  if (out.files.empty()) {
    keys.fail(*files, "files", "must name at least one file");
  }
  out.columns = read_log_columns(keys, std::move(out.columns), robot.size());
  // What the file names is read, not what else happens to be in the log under a default name.
  if (!out.columns.torque.empty() || !out.columns.control.empty()) {
    out.columns.default_names = false;
  }
  keys.read(out);
  keys.read(out.resample);
  if (keys.find("resample_hz") != nullptr) {
    out.irregular = Irregular::resample;
  }
  if (keys.find("subtract") != nullptr) {
    out.subtract = read_subtractions(keys, folder, robot);
  }
  if (auto reference = keys.section("reference_file")) {
    out.reference = read_reference_file(*reference, folder, out.columns, robot.size());
  }
  keys.finish();
  keys.refuse(out.columns.complaint());
  keys.refuse(out.resample.complaint());
  return out;
}

}  // namespace rivid::detail
