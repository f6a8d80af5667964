#include "rivid/data/table.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "data/iso_time.hpp"
#include "dialect.hpp"
#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

using detail::CellReading;
using detail::Dialect;

constexpr std::size_t progress_step = std::size_t{8} << 20U;  // bytes

// "#3" → 3; 0 where the text is no such number.
std::size_t field_number(std::string_view name) {
  std::size_t number = 0;
  if (!name.starts_with('#')) {
    return 0;
  }
  const char* const last = name.data() + name.size();
  const auto [end, error] = std::from_chars(name.data() + 1, last, number);
  return error == std::errc() && end == last ? number : 0;
}

// Fields by their names: the first two of each.
class FieldIndex {
 public:
  explicit FieldIndex(const std::vector<std::string>& names) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto [at, is_new] = fields_.try_emplace(names[i], i, i);
      if (!is_new && at->second.first == at->second.second) {
        at->second.second = i;
      }
    }
  }

  // Both the same where one field alone has the name.
  [[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> find(std::string_view name) const {
    const auto at = fields_.find(name);
    return at == fields_.end() ? std::nullopt : std::optional(at->second);
  }

 private:
  std::unordered_map<std::string_view, std::pair<std::size_t, std::size_t>> fields_;
};

std::size_t chosen_field(const std::string& name, const Dialect& dialect, const FieldIndex& index,
                         const std::string& source) {
  const std::vector<std::string>& names = dialect.names;
  if (const auto found = index.find(name)) {
    if (found->first != found->second) {
      throw InputError(source + ": the column name " + in_quotes(name) + " stands more than once; ask for " +
                       detail::field_name(found->first + 1) + " or " + detail::field_name(found->second + 1));
    }
    return found->first;
  }
  const std::size_t number = field_number(name);
  if (number >= 1 && number <= names.size()) {
    return number - 1;
  }
  if (number > 0) {
    throw InputError(source + ": there is no column " + name + "; the lines have " +
                     std::to_string(names.size()) + " fields");
  }
  if (!dialect.header) {
    throw InputError(source + ": there is no column " + in_quotes(name) +
                     ", as no line names the columns; ask for them by number, #1 to #" +
                     std::to_string(names.size()));
  }
  throw InputError(source + ": there is no column " + in_quotes(name) + "; the columns are " + listed(names) +
                   did_you_mean(name, names));
}

enum class Row { read, skipped, comma_found };

// One pass over the rows. The lines that a fast loop can not take whole are read again with care, which also
// finds the words for what is wrong with them.
class Reader {
 public:
  Reader(const Dialect& dialect, const std::string& source, const TableOptions& options)
      : dialect_(dialect), source_(source), options_(options), targets_(dialect.names.size(), nullptr) {}

  // False where the numbers turned out to have a decimal comma and `mark` is a point: read again with a
  // comma.
  bool read(InputText& input, char mark, const std::vector<std::size_t>& fields, Matrix& values,
            LineNumbers& lines) {
    const std::string_view text = input.bytes();
    mark_ = mark;
    input_ = &input;
    total_ = text.size();
    const std::string_view data = text.substr(dialect_.begin);
    values.resize(most_rows(data, fields.size()), static_cast<Index>(fields.size()));
    for (std::size_t k = 0; k < fields.size(); ++k) {
      targets_[fields[k]] = values.col(static_cast<Index>(k)).data();
    }
    row_ = 0;
    line_ = dialect_.line;
    lines.runs.assign(1, {0, line_});
    lines_ = &lines;
    next_progress_ = dialect_.begin + progress_step;

    // The last lines go through a copy that ends in a line end and in bytes that may be read past it.
    const std::size_t kept = std::min(data.size(), detail::number_padding);
    const std::size_t last = data.substr(0, data.size() - kept).rfind('\n');
    const std::size_t main = last == std::string_view::npos ? 0 : last + 1;
    std::string tail(data.substr(main));
    tail += '\n';
    const std::size_t tail_size = tail.size();
    tail.append(detail::number_padding, '\n');
    if (!read_lines(data.substr(0, main), dialect_.begin) ||
        !read_lines(std::string_view(tail).substr(0, tail_size), dialect_.begin + main)) {
      return false;
    }
    values.conservativeResize(row_, Eigen::NoChange);
    if (lines.runs.back().row == row_) {
      lines.runs.pop_back();  // of comments behind the last row
    }
    if (options_.progress) {
      options_.progress(1.0);
    }
    return true;
  }

 private:
  // The number of lines, and no more than the bytes allow for: a file of blank lines must not claim memory.
  static Index most_rows(std::string_view data, std::size_t wanted) {
    std::size_t count = data.ends_with('\n') ? 0 : 1;
    const char* p = data.data();
    const char* const end = p + data.size();
    while (const void* const found = std::memchr(p, '\n', static_cast<std::size_t>(end - p))) {
      ++count;
      p = static_cast<const char*>(found) + 1;
    }
    const std::size_t least_bytes = 2 * std::max<std::size_t>(wanted, 1);
    return static_cast<Index>(std::min(count, (data.size() + 1) / least_bytes + 1));
  }

  bool read_lines(std::string_view text, std::size_t offset) {
    switch (dialect_.separator) {
      case ',':
        return read_lines<',', '.'>(text, offset);
      case ';':
        return mark_ == '.' ? read_lines<';', '.'>(text, offset) : read_lines<';', ','>(text, offset);
      case '\t':
        return mark_ == '.' ? read_lines<'\t', '.'>(text, offset) : read_lines<'\t', ','>(text, offset);
      default:
        return mark_ == '.' ? read_lines<' ', '.'>(text, offset) : read_lines<' ', ','>(text, offset);
    }
  }

  template <char Separator, char Mark>
  bool read_lines(std::string_view text, std::size_t offset) {
    const char* p = text.data();
    const char* const end = p + text.size();
    while (p < end) {
      const char* next = fast_row<Separator, Mark>(p);
      if (next != nullptr) {
        ++row_;
      } else {
        const char* const line_end =
            static_cast<const char*>(std::memchr(p, '\n', static_cast<std::size_t>(end - p)));
        next = line_end + 1;
        switch (careful_row({p, static_cast<std::size_t>(line_end - p)})) {
          case Row::comma_found:
            return false;
          case Row::skipped:
            if (lines_->runs.back().row == row_) {
              lines_->runs.back().line = line_ + 1;
            } else {
              lines_->runs.push_back({row_, line_ + 1});
            }
            break;
          case Row::read:
            ++row_;
        }
      }
      p = next;
      ++line_;
      report_progress(offset + static_cast<std::size_t>(p - text.data()));
    }
    return true;
  }

  void report_progress(std::size_t done) {
    if (done >= next_progress_) {
      next_progress_ = done + progress_step;
      if (!may_switch()) {
        input_->forget(done);
      }
      if (options_.progress) {
        options_.progress(std::min(1.0, static_cast<double>(done) / static_cast<double>(total_)));
      }
    }
  }

  template <char Separator>
  static bool separates(char c) {
    return c == Separator || (Separator == ' ' && c == '\t');
  }

  template <char Separator>
  static const char* skipped_blanks(const char* p) {
    while (*p == ' ' || (Separator == ' ' && *p == '\t')) {
      ++p;
    }
    return p;
  }

  // Reads one plain row and returns where the next line starts; nullptr where there is anything to think
  // about.
  template <char Separator, char Mark>
  const char* fast_row(const char* p) const {
    const std::size_t fields = targets_.size();
    double* const* const targets = targets_.data();
    for (std::size_t field = 0; field < fields; ++field) {
      if (field > 0) {
        if (!separates<Separator>(*p)) {
          return nullptr;
        }
        ++p;
      }
      p = skipped_blanks<Separator>(p);
      const char* const cell = p;
      if (targets[field] != nullptr) {
        p = detail::parsed_number<Mark>(cell, targets[field][row_]);
      } else {
        if (field == 0 && (*p == '#' || *p == '%')) {
          return nullptr;
        }
        while (!separates<Separator>(*p) && *p != '\n' && *p != '"') {
          ++p;
        }
        if (*p == '"') {
          return nullptr;
        }
      }
      if (p == cell && (targets[field] != nullptr || Separator == ' ')) {
        return nullptr;
      }
    }
    if (dialect_.trailing) {
      if (*p != Separator) {
        return nullptr;
      }
      ++p;
    }
    p = skipped_blanks<Separator>(p);
    if (*p == '\r') {
      ++p;
    }
    return *p == '\n' ? p + 1 : nullptr;
  }

  // Whether a comma in a number makes all be read again.
  [[nodiscard]] bool may_switch() const {
    return mark_ == '.' && options_.decimal == Decimal::automatic && dialect_.separator != ',';
  }

  [[nodiscard]] std::string place() const { return source_ + ":" + std::to_string(line_); }

  Row careful_row(std::string_view line) {
    if (detail::is_skipped(line)) {
      return Row::skipped;
    }
    detail::split(line, dialect_.separator, cells_);
    const std::size_t required = targets_.size() + static_cast<std::size_t>(dialect_.trailing);
    if (cells_.size() != required || (dialect_.trailing && !cells_.back().empty())) {
      refuse_count();
    }
    for (std::size_t field = 0; field < targets_.size(); ++field) {
      if (targets_[field] == nullptr) {
        continue;
      }
      const std::string_view cell = cells_[field];
      const CellReading reading = detail::read_cell(cell, mark_, targets_[field][row_]);
      if (reading == CellReading::number) {
        continue;
      }
      if (const auto instant = detail::iso_time(cell)) {
        first_day_ = first_day_.value_or(instant->day);
        targets_[field][row_] = 86400.0 * static_cast<double>(instant->day - *first_day_) + instant->seconds;
        continue;
      }
      double value = 0.0;
      if (may_switch() && detail::read_cell(cell, ',', value) == CellReading::number) {
        comma_line_ = line_;
        return Row::comma_found;
      }
      refuse_cell(field, cell, reading);
    }
    return Row::read;
  }

  [[noreturn]] void refuse_count() const {
    const std::size_t required = targets_.size();
    std::size_t got = cells_.size();
    std::string why;
    if (dialect_.trailing && !cells_.empty()) {
      got -= static_cast<std::size_t>(cells_.back().empty());
      if (got == required) {
        why = " and, as in the rows before, a separator at its end";
      }
    }
    throw InputError(place() + ": the line has " + counted(static_cast<std::ptrdiff_t>(got), "field") + ", " +
                     std::to_string(required) + (required == 1 ? " is" : " are") + " required" + why);
  }

  [[noreturn]] void refuse_cell(std::size_t field, std::string_view cell, CellReading reading) const {
    const std::string& name = dialect_.names[field];
    const bool named = dialect_.header && !name.empty();
    const std::string column = place() + ":" + std::to_string(field + 1) + ": column " +
                               (named ? in_quotes(name) : detail::field_name(field + 1));
    const std::string content = " holds " + in_quotes(cell);
    double value = 0.0;
    switch (reading) {
      case CellReading::empty:
        throw InputError(
            column +
            " is empty; a number is required (rivid convert fills in the empty cells of merged topics)");
      case CellReading::not_finite:
        throw InputError(column + content + "; values must be finite");
      case CellReading::out_of_range:
        throw InputError(column + content + ", which is outside the range of a double");
      default:
        break;
    }
    if (mark_ == ',' && detail::read_cell(cell, '.', value) == CellReading::number) {
      throw InputError(column + content + ", but the decimal mark is a comma" +
                       (comma_line_ > 0 ? " in line " + std::to_string(comma_line_) : "") +
                       "; one file must use one mark");
    }
    if (mark_ == '.' && detail::read_cell(cell, ',', value) == CellReading::number) {
      throw InputError(column + content + "; the decimal mark must be a point, or say that it is a comma");
    }
    throw InputError(column + content + ", which is not a number");
  }

  const Dialect& dialect_;
  const std::string& source_;
  const TableOptions& options_;
  std::vector<double*> targets_;  // one a field: where its column starts, nullptr where it is not asked for
  std::vector<std::string_view> cells_;
  char mark_ = '.';
  InputText* input_ = nullptr;
  std::size_t total_ = 0;
  std::size_t next_progress_ = 0;
  std::size_t line_ = 0;
  std::size_t comma_line_ = 0;
  Index row_ = 0;
  LineNumbers* lines_ = nullptr;
  std::optional<std::int64_t> first_day_;  // of dates, which count in seconds from its midnight
};

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

Table detail::parsed_table(InputText& text, const std::string& source, const TableOptions& options) {
  check(options);
  Table table;
  table.source = source;
  const Dialect dialect = detail::dialect(text.bytes(), table.source, options);
  const FieldIndex index(dialect.names);
  if (options.columns.empty()) {
    for (std::size_t field = 0; field < dialect.names.size(); ++field) {
      table.fields.push_back(field);
    }
  }
  for (const std::string& name : options.columns) {
    table.fields.push_back(chosen_field(name, dialect, index, table.source));
  }
  // A field that is asked for twice is read once.
  std::vector<std::size_t> distinct = table.fields;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  const bool repeats = distinct.size() < table.fields.size();
  const std::vector<std::size_t>& read_fields = repeats ? distinct : table.fields;

  Reader reader(dialect, table.source, options);
  const char mark = options.decimal == Decimal::comma ? ',' : '.';
  if (!reader.read(text, mark, read_fields, table.values, table.lines)) {
    reader.read(text, ',', read_fields, table.values, table.lines);
  }
  if (repeats) {
    Matrix values(table.values.rows(), static_cast<Index>(table.fields.size()));
    for (Index k = 0; k < values.cols(); ++k) {
      const auto from =
          std::lower_bound(distinct.begin(), distinct.end(), table.fields[static_cast<std::size_t>(k)]);
      values.col(k) = table.values.col(from - distinct.begin());
    }
    table.values = std::move(values);
  }
  for (std::size_t& field : table.fields) {
    table.names.push_back(dialect.names[field]);
    ++field;
  }
  return table;
}

Table read_table(const std::filesystem::path& path, const TableOptions& options) {
  check(options);
  InputText text = read_input(path, true);
  return detail::parsed_table(text, path.string(), options);
}

std::vector<std::string> column_names(const std::filesystem::path& path, const TableOptions& options) {
  check(options);
  return detail::dialect(read_input(path, true).bytes(), path.string(), options).names;
}

}  // namespace rivid
