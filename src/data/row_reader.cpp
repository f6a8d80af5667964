#include "row_reader.hpp"

#include <cstring>

#include "data/iso_time.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

template <char Separator>
bool separates(char c) {
  return c == Separator || (Separator == ' ' && c == '\t');
}

template <char Separator>
const char* skipped_blanks(const char* p) {
  while (*p == ' ' || (Separator == ' ' && *p == '\t')) {
    ++p;
  }
  return p;
}

}  // namespace

RowReader::End RowReader::read(std::string_view text, Index row, std::size_t line) {
  row_ = row;
  line_ = line;
  lines_.runs.assign(1, {row, line});
  const bool point = format_.mark == '.';
  switch (format_.dialect.separator) {
    case ',':
      return read_lines<',', '.'>(text);
    case ';':
      return point ? read_lines<';', '.'>(text) : read_lines<';', ','>(text);
    case '\t':
      return point ? read_lines<'\t', '.'>(text) : read_lines<'\t', ','>(text);
    default:
      return point ? read_lines<' ', '.'>(text) : read_lines<' ', ','>(text);
  }
}

template <char Separator, char Mark>
RowReader::End RowReader::read_lines(std::string_view text) {
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
          return End::comma_found;
        case Row::date_found:
          return End::date_found;
        case Row::skipped:
          skip_line();
          break;
        case Row::read:
          ++row_;
      }
    }
    p = next;
    ++line_;
  }
  return End::complete;
}

void RowReader::skip_line() {
  if (lines_.runs.back().row == row_) {
    lines_.runs.back().line = line_ + 1;
  } else {
    lines_.runs.push_back({row_, line_ + 1});
  }
}

// Reads one plain row and returns where the next line starts; nullptr where there is anything to think about.
template <char Separator, char Mark>
const char* RowReader::fast_row(const char* p) const {
  const std::size_t fields = format_.targets.size();
  double* const* const targets = format_.targets.data();
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
      p = parsed_number<Mark>(cell, targets[field][row_]);
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
  if (format_.dialect.trailing) {
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

RowReader::Row RowReader::careful_row(std::string_view line) {
  if (is_skipped(line)) {
    return Row::skipped;
  }
  split(line, format_.dialect.separator, cells_);
  const std::size_t fields = format_.targets.size();
  const bool trailing = format_.dialect.trailing;
  if (cells_.size() != fields + static_cast<std::size_t>(trailing) || (trailing && !cells_.back().empty())) {
    refuse_count();
  }
  for (std::size_t field = 0; field < fields; ++field) {
    double* const target = format_.targets[field];
    if (target == nullptr) {
      continue;
    }
    const std::string_view cell = cells_[field];
    const CellReading reading = read_cell(cell, format_.mark, target[row_]);
    if (reading == CellReading::number) {
      continue;
    }
    if (const auto instant = iso_time(cell)) {
      if (!first_day_ && !begins_days_) {
        return Row::date_found;
      }
      first_day_ = first_day_.value_or(instant->day);
      target[row_] = 86400.0 * static_cast<double>(instant->day - *first_day_) + instant->seconds;
      continue;
    }
    double value = 0.0;
    if (format_.may_switch && read_cell(cell, ',', value) == CellReading::number) {
      return Row::comma_found;
    }
    refuse_cell(field, cell, reading);
  }
  return Row::read;
}

std::string RowReader::place() const { return format_.source + ":" + std::to_string(line_); }

void RowReader::refuse_count() const {
  const std::size_t required = format_.targets.size();
  std::size_t got = cells_.size();
  std::string why;
  if (format_.dialect.trailing && !cells_.empty()) {
    got -= static_cast<std::size_t>(cells_.back().empty());
    if (got == required) {
      why = " and, as in the rows before, a separator at its end";
    }
  }
  throw InputError(place() + ": the line has " + counted(static_cast<std::ptrdiff_t>(got), "field") + ", " +
                   std::to_string(required) + (required == 1 ? " is" : " are") + " required" + why);
}

void RowReader::refuse_cell(std::size_t field, std::string_view cell, CellReading reading) const {
  const std::string& name = format_.dialect.names[field];
  const bool named = format_.dialect.header && !name.empty();
  const std::string column = place() + ":" + std::to_string(field + 1) + ": column " +
                             (named ? in_quotes(name) : field_name(field + 1));
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
  if (format_.mark == ',' && read_cell(cell, '.', value) == CellReading::number) {
    throw InputError(column + content + ", but the decimal mark is a comma" +
                     (format_.comma_line > 0 ? " in line " + std::to_string(format_.comma_line) : "") +
                     "; one file must use one mark");
  }
  if (format_.mark == '.' && read_cell(cell, ',', value) == CellReading::number) {
    throw InputError(column + content + "; the decimal mark must be a point, or say that it is a comma");
  }
  throw InputError(column + content + ", which is not a number");
}

}  // namespace rivid::detail
