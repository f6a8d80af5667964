#include "rivid/data/table.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "column_reader.hpp"
#include "dialect.hpp"
#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

void check(const TableOptions& options) {
  if (const auto fault = options.complaint()) {
    throw InputError("TableOptions: " + *fault);
  }
}

}  // namespace

std::size_t LineNumbers::operator[](Index row) const {
  const auto after =
      std::upper_bound(runs.begin(), runs.end(), row, [](Index r, const Run& run) { return r < run.row; });
  if (after == runs.begin()) {
    return 0;
  }
  return (after - 1)->line + static_cast<std::size_t>(row - (after - 1)->row);
}

Index Table::column(std::string_view name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    throw InputError(source + ": there is no column " + in_quotes(name) + "; the columns are " +
                     listed(names) + did_you_mean(name, names));
  }
  if (std::find(found + 1, names.end(), name) != names.end()) {
    throw InputError(source + ": the column name " + in_quotes(name) + " stands more than once");
  }
  return found - names.begin();
}

std::optional<std::string> TableOptions::complaint() const {
  if (separator == Separator::comma && decimal == Decimal::comma) {
    return "the separator and the decimal mark are both a comma";
  }
  if (std::find(columns.begin(), columns.end(), "") != columns.end()) {
    return "columns holds an empty name; a column without a name is asked for as \"#3\"";
  }
  return std::nullopt;
}

Table read_table(const std::filesystem::path& path, const TableOptions& options) {
  check(options);
  InputText text = read_input(path, true);
  Table table;
  table.source = path.string();
  const auto room = [&](std::size_t columns, Index rows) {
    table.values.resize(rows, static_cast<Index>(columns));
    std::vector<double*> out;
    for (auto column : table.values.colwise()) {
      out.push_back(column.data());
    }
    return out;
  };
  detail::ReadColumns read = detail::read_columns(text, table.source, options, room);
  table.values.conservativeResize(read.rows, Eigen::NoChange);
  table.names = std::move(read.names);
  table.fields = std::move(read.fields);
  table.lines = std::move(read.lines);
  return table;
}

std::vector<std::string> column_names(const std::filesystem::path& path, const TableOptions& options) {
  check(options);
  return detail::dialect(read_input(path, true).bytes(), path.string(), options).names;
}

}  // namespace rivid
