#include "rivid/data/csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <set>
#include <string_view>
#include <system_error>

#include "column_reader.hpp"
#include "csv_columns.hpp"
#include "data/log_columns.hpp"
#include "dialect.hpp"
#include "rivid/data/time_stamps.hpp"
#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::log_columns;
using Quantity = detail::LogColumns;

using Columns = std::array<std::vector<Column>, log_columns.size()>;

constexpr std::size_t position = 0;      // place in log_columns
constexpr std::size_t reference = 4;     // place in log_columns
constexpr double rate_tolerance = 0.01;  // relative; a choice: clocks of controllers differ by far less

std::optional<std::string> column_complaint(std::string_view who, const Column& column) {
  const std::string name(who);
  if (column.name.empty()) {
    return name + " has a column without a name";
  }
  if (!std::isfinite(column.scale) || column.scale == 0.0) {
    return name + ": the scale of column " + in_quotes(column.name) + " is " + number(column.scale) +
           ", must be finite and not zero";
  }
  if (!std::isfinite(column.offset)) {
    return name + ": the offset of column " + in_quotes(column.name) + " is " + number(column.offset) +
           ", must be finite";
  }
  return std::nullopt;
}

// 12 for "tau12" and the prefix "tau"; 0 for what is no such name.
std::size_t joint_number(std::string_view name, std::string_view prefix) {
  if (!name.starts_with(prefix) || name.size() == prefix.size() || name[prefix.size()] == '0') {
    return 0;
  }
  std::size_t number = 0;
  const char* const last = name.data() + name.size();
  const auto [end, error] = std::from_chars(name.data() + prefix.size(), last, number);
  return error == std::errc() && end == last ? number : 0;
}

// Default names of a quantity that the file has; nothing may be missing among them.
std::vector<Column> by_default(const Quantity& quantity, const std::vector<std::string>& names,
                               const std::string& source) {
  std::vector<std::size_t> numbers;
  for (const std::string& name : names) {
    const std::size_t number = joint_number(name, quantity.prefix);
    if (number > 0) {
      numbers.push_back(number);
    }
  }
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  std::vector<Column> columns;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::string prefix(quantity.prefix);
    const auto named = [&](std::size_t number) { return prefix + std::to_string(number); };
    if (numbers[i] != i + 1) {
      throw InputError(source + ": there is a column " + in_quotes(named(numbers[i])) + " but no " +
                       in_quotes(named(i + 1)) + "; list the columns of " + std::string(quantity.key));
    }
    columns.push_back({named(i + 1)});
  }
  return columns;
}

std::string names_of(const std::vector<Column>& columns) {
  const std::string& first = columns.front().name;
  return columns.size() == 1 ? first : first + " to " + columns.back().name;
}

std::string count_complaint(const Quantity& quantity, const std::vector<Column>& columns, bool listed,
                            const Quantity& required, std::size_t n) {
  return std::string(quantity.key) + " has " + counted(std::ssize(columns), "column") + " (" +
         names_of(columns) + (listed ? "" : ", found by name") + "), " + std::string(required.key) + " has " +
         std::to_string(n) + "; one for each joint is required";
}

// Columns of every quantity, all of the size of the required one.
Columns resolved(const LogOptions& options, std::size_t required, const std::vector<std::string>& names,
                 const std::string& source, std::vector<std::string>& notes) {
  Columns columns;
  const auto resolve = [&](std::size_t i) {
    columns[i] = options.*log_columns[i].listed;
    if (columns[i].empty() && options.default_names) {
      columns[i] = by_default(log_columns[i], names, source);
    }
  };
  resolve(required);
  if (columns[required].empty()) {
    const std::string words(log_columns[required].key);
    const std::string prefix(log_columns[required].prefix);
    const std::string defaults =
        in_quotes(prefix + "1") + ", " + in_quotes(prefix + "2") + ", … and none are listed";
    throw InputError(source + ": there are no " + words + " columns " +
                     (options.default_names ? defaults : "listed") +
                     "; say which columns hold them; the columns are " + listed(names));
  }
  const std::size_t n = columns[required].size();
  const bool required_listed = !(options.*log_columns[required].listed).empty();
  for (std::size_t i = 0; i < log_columns.size(); ++i) {
    if (i != required) {
      resolve(i);
    }
    if (columns[i].empty()) {
      continue;
    }
    const std::string words(log_columns[i].key);
    const bool listed = !(options.*log_columns[i].listed).empty();
    if (columns[i].size() != n) {
      throw InputError(source + ": " +
                       count_complaint(log_columns[i], columns[i], listed, log_columns[required], n));
    }
    if (required_listed && !listed) {
      notes.push_back(words + " not listed, taken from " + names_of(columns[i]));
    }
  }
  return columns;
}

std::optional<Column> time_column(const LogOptions& options, const std::vector<std::string>& names,
                                  std::vector<std::string>& notes) {
  if (options.time) {
    return options.time;
  }
  if (!options.default_names && options.rate_hz) {
    return std::nullopt;
  }
  const auto has = [&](std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (has("t")) {
    if (has("time")) {
      notes.emplace_back("time taken from column \"t\"; there is a column \"time\" as well");
    }
    return Column{"t"};
  }
  return has("time") ? std::optional(Column{"time"}) : std::nullopt;
}

// Sets the clock of the log from its recorded stamps, if there are any, and the stated rate.
void set_clock(Log& log, Index samples, const std::optional<Vector>& stamps, std::optional<double> rate_hz) {
  if (stamps) {
    log.t = *stamps;
    const TimeReport report = inspect_time(log.t);
    if (!report.regular) {
      log.notes.push_back("time stamps are irregular: " + report.summary() +
                          (rate_hz ? "; the stated rate of " + number(*rate_hz) + " Hz is used" : ""));
    } else if (rate_hz && std::abs(report.rate_hz - *rate_hz) > rate_tolerance * *rate_hz) {
      log.warnings.push_back(Finding{"stated_rate", log.source,
                                     "the time stamps give " + number(report.rate_hz) +
                                         " Hz; the stated rate of " + number(*rate_hz) + " Hz is used"});
    }
    if (!rate_hz && report.rate_hz <= 0.0) {
      throw InputError(log.source + ": the time stamps do not go forward; state the rate");
    }
    log.f_m = report.rate_hz;
  }
  if (rate_hz) {
    const double start = stamps ? (*stamps)[0] : 0.0;
    log.f_m = *rate_hz;
    log.t = start + Vector::LinSpaced(samples, 0.0, static_cast<double>(samples - 1)).array() / *rate_hz;
  }
}

// Which columns of a table are what.
struct Choice {
  Columns columns;
  std::optional<Column> time;
  std::optional<std::string> nanoseconds;  // beside a time of whole seconds

  // In the order of log_columns, time and its nanoseconds last.
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const std::vector<Column>& list : columns) {
      for (const Column& column : list) {
        out.push_back(column.name);
      }
    }
    if (time) {
      out.push_back(time->name);
    }
    if (nanoseconds) {
      out.push_back(*nanoseconds);
    }
    return out;
  }
};

Choice chosen(const LogOptions& options, std::size_t required, const std::vector<std::string>& names,
              Log& log) {
  Choice out = {.columns = resolved(options, required, names, log.source, log.notes),
                .time = time_column(options, names, log.notes),
                .nanoseconds = {}};
  if (out.time) {
    out.nanoseconds = detail::nanoseconds_of(out.time->name, names);
  }
  if (!out.time && !options.rate_hz) {
    throw InputError(
        log.source +
        ": there is no time column \"t\" or \"time\"; say which column it is, or state the rate");
  }
  return out;
}

// The columns of a choice, straight in a log.
class LogRoom {
 public:
  LogRoom(Log& log, const Choice& choice) : log_(log), choice_(choice) {}

  // Room for so many rows: where each column of choice.names() begins.
  std::vector<double*> columns(Index rows) {
    std::vector<double*> out;
    for (std::size_t i = 0; i < log_columns.size(); ++i) {
      if (choice_.columns[i].empty()) {
        continue;
      }
      Matrix& values = log_.*log_columns[i].member;
      values.resize(rows, std::ssize(choice_.columns[i]));
      for (auto column : values.colwise()) {
        out.push_back(column.data());
      }
    }
    if (choice_.time) {
      recorded_.resize(rows);
      out.push_back(recorded_.data());
    }
    if (choice_.nanoseconds) {
      nanoseconds_.resize(rows);
      out.push_back(nanoseconds_.data());
    }
    return out;
  }

  // Once `rows` rows are there: units and time.
  void finish(Index rows, const LogOptions& options) {
    if (rows < 2) {
      throw InputError(log_.source + ": the log has one sample, at least 2 are required");
    }
    for (std::size_t i = 0; i < log_columns.size(); ++i) {
      Matrix& values = log_.*log_columns[i].member;
      if (choice_.columns[i].empty()) {
        continue;
      }
      values.conservativeResize(rows, Eigen::NoChange);
      for (Index j = 0; j < values.cols(); ++j) {
        const Column& column = choice_.columns[i][static_cast<std::size_t>(j)];
        if (column.scale != 1.0 || column.offset != 0.0) {
          values.col(j) = column.scale * values.col(j).array() + column.offset;
        }
      }
    }
    std::optional<Vector> stamps;
    if (choice_.time) {
      if (choice_.nanoseconds) {
        recorded_ = detail::stamps_of(recorded_.head(rows), nanoseconds_.head(rows));
      }
      stamps = choice_.time->scale * recorded_.head(rows).array() + choice_.time->offset;
    }
    set_clock(log_, rows, stamps, options.rate_hz);
  }

 private:
  Log& log_;
  const Choice& choice_;
  Vector recorded_;
  Vector nanoseconds_;
};

Log read(std::string_view who, const std::filesystem::path& path, const LogOptions& options,
         std::size_t required) {
  if (const auto fault = options.complaint()) {
    throw InputError(std::string(who) + ": " + *fault);
  }
  Log log;
  log.source = path.string();
  InputText text = read_input(path, true);
  const std::vector<std::string> names = detail::dialect(text.bytes(), log.source, options.table).names;
  const Choice choice = chosen(options, required, names, log);
  TableOptions table_options = options.table;
  table_options.columns = choice.names();
  LogRoom room(log, choice);
  detail::ReadColumns read =
      detail::read_columns(text, log.source, table_options,
                           [&](std::size_t /*columns*/, Index rows) { return room.columns(rows); });
  log.lines = std::move(read.lines);
  room.finish(read.rows, options);
  return log;
}

}  // namespace

std::optional<std::string> LogOptions::complaint() const {
  for (const Quantity& quantity : log_columns) {
    std::set<std::string_view> seen;
    for (const Column& column : this->*quantity.listed) {
      if (auto fault = column_complaint(quantity.key, column)) {
        return fault;
      }
      if (!seen.insert(column.name).second) {
        return std::string(quantity.key) + " lists column " + in_quotes(column.name) + " twice";
      }
    }
  }
  std::set<std::string_view> positions;
  for (const Column& column : this->position) {
    positions.insert(column.name);
  }
  for (const Quantity& quantity : log_columns) {
    const bool effort = quantity.key == "torque" || quantity.key == "control";
    for (const Column& column : this->*quantity.listed) {
      if (effort && positions.contains(column.name)) {
        return std::string(quantity.key) + " lists column " + in_quotes(column.name) +
               ", which is listed as a position";
      }
    }
  }
  if (time) {
    if (auto fault = column_complaint("time", *time)) {
      return fault;
    }
    if (time->scale < 0.0) {
      return "time: the scale is " + number(time->scale) + ", must be positive";
    }
  }
  if (rate_hz && (!std::isfinite(*rate_hz) || *rate_hz <= 0.0)) {
    return "rate_hz is " + number(*rate_hz) + " Hz, must be positive";
  }
  if (!table.columns.empty()) {
    return "table.columns must be empty; the lists of columns stand beside it";
  }
  return table.complaint();
}

std::optional<std::string> detail::nanoseconds_of(std::string_view seconds,
                                                  std::span<const std::string> names) {
  for (const std::string_view ending : {"seconds", "secs", "sec"}) {
    if (!seconds.ends_with(ending)) {
      continue;
    }
    const std::string stem(seconds.substr(0, seconds.size() - ending.size()));
    for (const char* const word : {"nanosec", "nanosecs", "nsec", "nsecs", "nanoseconds"}) {
      if (const auto found = std::ranges::find(names, stem + word); found != names.end()) {
        return *found;
      }
    }
  }
  return std::nullopt;
}

std::map<std::string, std::vector<std::string>> detail::default_columns(std::span<const std::string> names) {
  const auto has = [&](const std::string& name) { return std::ranges::find(names, name) != names.end(); };
  std::map<std::string, std::vector<std::string>> out;
  for (const Quantity& quantity : log_columns) {
    const std::string prefix(quantity.prefix);
    for (int joint = 1; has(prefix + std::to_string(joint)) && !has(prefix + "0"); ++joint) {
      out[std::string(quantity.key)].push_back(prefix + std::to_string(joint));
    }
  }
  for (const char* const time : {"t", "time"}) {
    if (has(time) && !out.contains("time")) {
      out["time"] = {time};
    }
  }
  return out;
}

Vector detail::stamps_of(const Eigen::Ref<const Vector>& seconds,
                         const Eigen::Ref<const Vector>& nanoseconds) {
  constexpr double day = 86400.0;  // [s]
  const double midnight = day * std::floor(seconds[0] / day);
  return (seconds.array() - midnight) + 1e-9 * nanoseconds.array();
}

Log read_csv(const std::filesystem::path& path, const LogOptions& options) {
  return read("read_csv", path, options, position);
}

Log read_reference(const std::filesystem::path& path, const LogOptions& options) {
  return read("read_reference", path, options, reference);
}

Log detail::log_of(const Table& table, const LogOptions& options) {
  if (const auto fault = options.complaint()) {
    throw InputError(table.source + ": " + *fault);
  }
  Log log;
  log.source = table.source;
  const Choice choice = chosen(options, position, table.names, log);
  const std::vector<std::string> wanted = choice.names();
  LogRoom room(log, choice);
  const std::vector<double*> columns = room.columns(table.rows());
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    std::copy_n(table.values.col(table.column(wanted[k])).data(), table.rows(), columns[k]);
  }
  room.finish(table.rows(), options);
  return log;
}

std::string to_csv(const Log& log) {
  detail::require_even("to_csv", log);
  detail::CsvColumns out(log.samples());
  out.add("t", log.t.data());
  for (const Quantity& quantity : log_columns) {
    out.add_each(std::string(quantity.prefix), log.*quantity.member);
  }
  return out.text();
}

}  // namespace rivid
