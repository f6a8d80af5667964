#include "experiment/column_reader.hpp"

#include <algorithm>
#include <cmath>

#include "rivid/data/log.hpp"

namespace rivid::detail {

using Path = std::filesystem::path;

namespace {

// A column by its name, or by its number counted from 1.
std::string column_name(const TomlReader& keys, const toml::node& node, std::string_view key) {
  if (node.is_integer()) {
    const std::int64_t column = keys.as_integer(node, key);
    if (column < 1) {
      keys.fail(node, key, "is column " + std::to_string(column) + "; columns count from 1");
    }
    return "#" + std::to_string(column);
  }
  return keys.as_text(node, key);
}

std::optional<double> unit_factor(TomlReader& keys, std::string_view key) {
  const auto word = keys.text(key);
  if (!word) {
    return std::nullopt;
  }
  if (const auto complaint = unit_complaint(*word)) {
    keys.fail(*keys.find(key), std::string(key) + ":", *complaint);
  }
  return unit_scale(*word);
}

}  // namespace

Path file_at(const TomlReader& keys, const toml::node& node, std::string_view key, const Path& folder) {
  const std::string name = keys.as_text(node, key);
  if (name.empty()) {
    keys.fail(node, key, "must name a file");
  }
  return folder / Path(name);
}

std::optional<Path> file_named(TomlReader& keys, std::string_view key, const Path& folder) {
  const toml::node* const node = keys.find(key);
  return node == nullptr ? std::nullopt : std::optional(file_at(keys, *node, key, folder));
}

Column read_column(const TomlReader& keys, const toml::node& node, std::string_view key, double unit) {
  if (!node.is_table()) {
    return {column_name(keys, node, key), unit, 0.0};
  }
  TomlReader inner(*node.as_table(), keys.file(), keys.path() + "." + std::string(key));
  const toml::node* const column = inner.find("column");
  if (column == nullptr) {
    inner.look_for_mistyped({"column"});
    inner.fail("must say which column: { column = \"q1\", unit = \"deg\", sign = -1 }");
  }
  Column out{column_name(inner, *column, "column"), unit, inner.number("offset").value_or(0.0)};
  out.scale = unit_factor(inner, "unit").value_or(unit);
  out.scale *= inner.number("scale").value_or(1.0);
  if (const auto sign = inner.number("sign")) {
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

std::vector<Column> read_columns(TomlReader& keys, std::string_view key, double unit,
                                 const std::vector<Column>& otherwise, Index n) {
  const toml::node* const node = keys.find(key);
  if (node == nullptr) {
    return otherwise;
  }
  std::vector<Column> out;
  if (const toml::array* const list = node->as_array()) {
    for (const toml::node& item : *list) {
      out.push_back(read_column(keys, item, key, unit));
    }
  } else {
    out.push_back(read_column(keys, *node, key, unit));
  }
  if (static_cast<Index>(out.size()) != n) {
    keys.fail(*node, key,
              "names " + counted(std::ssize(out), "column") + ", must name one for each of the " +
                  std::to_string(n) + " joints");
  }
  return out;
}

std::vector<Column> read_columns(TomlReader& keys, std::string_view key, Units& units,
                                 const std::vector<Column>& otherwise, Index n) {
  const bool listed = keys.find(key) != nullptr;
  return read_columns(keys, key, listed ? units(key) : 1.0, otherwise, n);
}

LogOptions read_reference_columns(TomlReader& keys, LogOptions columns, Index n, bool velocity) {
  Units units(keys);
  const auto listed = [&](std::string_view key, std::vector<Column>& out) {
    if (keys.find(key) != nullptr) {
      out = read_columns(keys, key, units, {}, n);
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
  columns.rate_hz = keys.number("rate_hz");
  return columns;
}

Vector read_per_joint(TomlReader& keys, std::string_view key, Index n) {
  const auto values = keys.numbers(key);
  if (!values) {
    return {};
  }
  const toml::node& node = *keys.find(key);
  if (!node.is_array()) {
    return Vector::Constant(n, values->front());
  }
  if (std::ssize(*values) != n) {
    keys.fail(node, key,
              "has " + counted(std::ssize(*values), "entry") + ", must have one for each of the " +
                  counted(n, "joint") + ", or be a single value for all");
  }
  return Eigen::Map<const Vector>(values->data(), n);
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
      out(static_cast<Index>(i), static_cast<Index>(j)) = keys.as_number(*row->get(j), key);
    }
  }
  return out;
}

}  // namespace rivid::detail
