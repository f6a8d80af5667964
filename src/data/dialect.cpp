#include "dialect.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

#include "foreign_format.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr std::size_t sampled_lines = 32;  // that decide the dialect; a choice
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

struct Line {
  std::string_view text;
  std::size_t begin = 0;
  std::size_t number = 0;
};

// The first lines that hold rows or the header.
std::vector<Line> first_lines(std::string_view text, std::size_t begin) {
  std::vector<Line> lines;
  std::size_t number = 1;
  while (begin < text.size() && lines.size() < sampled_lines) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    if (!is_skipped(line)) {
      lines.push_back({line, begin, number});
    }
    begin = end + 1;
    ++number;
  }
  return lines;
}

bool is_number(std::string_view cell, char separator, Decimal decimal) {
  double value = 0.0;
  const auto reads = [&](char mark) {
    const CellReading reading = read_cell(cell, mark, value);
    return reading != CellReading::words && reading != CellReading::empty;
  };
  return (decimal != Decimal::comma && reads('.')) ||
         (decimal != Decimal::point && separator != ',' && reads(','));
}

// The most frequent of some counts, the smallest of several.
std::size_t mode(std::vector<std::size_t> counts) {
  std::sort(counts.begin(), counts.end());
  std::size_t best = 0;
  std::size_t most = 0;
  for (auto first = counts.begin(); first != counts.end();) {
    const auto last = std::upper_bound(first, counts.end(), *first);
    if (static_cast<std::size_t>(last - first) > most) {
      most = static_cast<std::size_t>(last - first);
      best = *first;
    }
    first = last;
  }
  return best;
}

// The separator that makes the largest share of the cells numbers. One that most lines do not have explains
// nothing; the names in the first line would blur the comparison.
char found_separator(const std::vector<Line>& lines, Decimal decimal) {
  char best = ',';
  double best_share = -1.0;
  std::vector<std::string_view> cells;
  for (const char candidate : {'\t', ';', ',', ' '}) {
    std::size_t filled = 0;
    std::size_t numbers = 0;
    std::vector<std::size_t> counts;
    for (std::size_t i = lines.size() > 1 ? 1 : 0; i < lines.size(); ++i) {
      split(lines[i].text, candidate, cells);
      counts.push_back(cells.size());
      for (const std::string_view cell : cells) {
        filled += static_cast<std::size_t>(!cell.empty());
        numbers += static_cast<std::size_t>(is_number(cell, candidate, decimal));
      }
    }
    const double share = static_cast<double>(numbers) / static_cast<double>(std::max<std::size_t>(filled, 1));
    const bool separates = mode(std::move(counts)) > 1;
    if (separates && share > best_share && (candidate != ',' || decimal != Decimal::comma)) {
      best = candidate;
      best_share = share;
    }
  }
  return best_share < 0.0 && decimal == Decimal::comma ? ';' : best;
}

char chosen_separator(const std::vector<Line>& lines, const TableOptions& options) {
  switch (options.separator) {
    case Separator::comma:
      return ',';
    case Separator::semicolon:
      return ';';
    case Separator::tab:
      return '\t';
    case Separator::spaces:
      return ' ';
    default:
      return found_separator(lines, options.decimal);
  }
}

bool has_header(const std::vector<Line>& lines, char separator, const TableOptions& options,
                const std::string& source) {
  if (options.header != Header::automatic) {
    return options.header == Header::present;
  }
  std::vector<std::string_view> first;
  split(lines[0].text, separator, first);
  const auto number = [&](std::string_view cell) { return is_number(cell, separator, options.decimal); };
  if (std::none_of(first.begin(), first.end(), number)) {
    return true;
  }
  if (lines.size() > 1) {
    std::vector<std::string_view> second;
    split(lines[1].text, separator, second);
    for (std::size_t i = 0; i < std::min(first.size(), second.size()); ++i) {
      if (!first[i].empty() && !number(first[i]) && number(second[i])) {
        throw InputError(source + ":" + std::to_string(lines[0].number) + ":" + std::to_string(i + 1) +
                         ": holds " + in_quotes(first[i]) +
                         " among numbers; if this line names the columns, say that a header is present, "
                         "else that it is absent");
      }
    }
  }
  return false;
}

// Names in a comment right above the first row, where numpy.savetxt() and rostopic write them; empty if they
// are not one name for each field.
std::vector<std::string> names_above(std::string_view text, const Line& row, char separator, Decimal decimal,
                                     std::size_t fields) {
  std::vector<std::string_view> cells;
  if (row.begin > 0) {
    const std::size_t end = row.begin - 1;  // of the line above
    const std::size_t before = end == 0 ? std::string_view::npos : text.rfind('\n', end - 1);
    const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
    const std::string_view line = text.substr(begin, end - begin);
    const std::size_t mark = line.find_first_of("#%");
    if (mark != std::string_view::npos) {
      split(line.substr(std::min(line.find_first_not_of("#%", mark), line.size())), separator, cells);
    }
  }
  const auto names_nothing = [&](std::string_view cell) {
    return cell.empty() || is_number(cell, separator, decimal);
  };
  if (cells.size() == fields + 1 && cells.back().empty()) {
    cells.pop_back();
  }
  if (cells.size() != fields || std::ranges::any_of(cells, names_nothing)) {
    return {};
  }
  return {cells.begin(), cells.end()};
}

void refuse_other_formats(std::string_view text, const std::string& source) {
  struct Format {
    std::string_view start;
    std::string_view words;
  };
  using namespace std::string_view_literals;
  static constexpr std::array formats = {Format{"\xFF\xFE"sv, "is UTF-16 text; save it as UTF-8"},
                                         Format{"\xFE\xFF"sv, "is UTF-16 text; save it as UTF-8"},
                                         Format{"\x1F\x8B"sv, "is compressed by gzip; unpack it first"}};
  for (const Format& format : formats) {
    if (text.starts_with(format.start)) {
      throw InputError(source + ": " + std::string(format.words));
    }
  }
  if (const auto complaint = foreign_format(text, source)) {
    throw InputError(source + ": " + *complaint);
  }
}

}  // namespace

bool is_skipped(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == std::string_view::npos || line[first] == '#' || line[first] == '%';
}

void split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  const bool spaces = separator == ' ';
  const auto is_separator = [&](char c) { return c == separator || (spaces && c == '\t'); };
  const auto is_blank = [&](char c) { return c == ' ' || c == '\r' || (c == '\t' && separator != '\t'); };
  std::size_t i = 0;
  while (true) {
    while (i < line.size() && is_blank(line[i])) {
      ++i;
    }
    if (spaces && i == line.size()) {
      return;
    }
    std::size_t begin = i;
    std::size_t end = 0;
    const std::size_t closing =
        i < line.size() && line[i] == '"' ? line.find('"', i + 1) : std::string_view::npos;
    if (closing != std::string_view::npos) {
      begin = i + 1;
      end = closing;
      i = closing + 1;
      while (i < line.size() && line[i] == '"') {  // a doubled quote stands for one and stays doubled here
        end = std::min(line.find('"', i + 1), line.size());
        i = std::min(end + 1, line.size());
      }
      while (i < line.size() && !is_separator(line[i])) {
        end = is_blank(line[i]) ? end : i + 1;
        ++i;
      }
    } else {
      while (i < line.size() && !is_separator(line[i])) {
        ++i;
      }
      end = i;
      while (end > begin && is_blank(line[end - 1])) {
        --end;
      }
    }
    cells.push_back(line.substr(begin, end - begin));
    if (i >= line.size()) {
      return;
    }
    ++i;
  }
}

CellReading read_cell(std::string_view cell, char mark, double& value) {
  if (cell.empty()) {
    return CellReading::empty;
  }
  const std::string_view digits = cell.substr(cell.front() == '+' ? 1 : 0);
  std::optional<std::string> with_point;
  std::string_view text = digits;
  if (mark != '.') {
    if (digits.find('.') != std::string_view::npos) {
      return CellReading::words;
    }
    with_point.emplace(digits);
    std::replace(with_point->begin(), with_point->end(), mark, '.');
    text = *with_point;
  }
  const char* const first = text.empty() ? cell.data() : &text.front();
  const char* const last = first + text.size();
  double read = 0.0;
  const auto [end, error] = read_number(first, last, read);
  if (end != last || error == std::errc::invalid_argument || (cell.front() == '+' && text.starts_with('-'))) {
    return CellReading::words;
  }
  if (error == std::errc::result_out_of_range) {
    return CellReading::out_of_range;
  }
  if (!std::isfinite(read)) {
    return CellReading::not_finite;
  }
  value = read;
  return CellReading::number;
}

Dialect dialect(std::string_view text, const std::string& source, const TableOptions& options) {
  refuse_other_formats(text, source);
  if (text.empty()) {
    throw InputError(source + ": the file is empty");
  }
  const std::vector<Line> lines = first_lines(text, text.starts_with(byte_order_mark) ? 3 : 0);
  if (lines.empty()) {
    throw InputError(source + ": the file holds no data, only comments and blank lines");
  }
  Dialect out;
  out.separator = chosen_separator(lines, options);
  out.header = has_header(lines, out.separator, options, source);
  if (out.header && lines.size() == 1) {
    throw InputError(source + ": the file holds a header but no data");
  }
  const Line& row = lines[out.header ? 1 : 0];
  out.begin = row.begin;
  out.line = row.number;

  std::vector<std::string_view> cells;
  split(row.text, out.separator, cells);
  const bool row_ends_empty = cells.size() > 1 && cells.back().empty();
  if (!out.header) {
    out.trailing = row_ends_empty;
    if (options.header == Header::automatic) {
      out.names =
          names_above(text, row, out.separator, options.decimal, cells.size() - (out.trailing ? 1U : 0U));
    }
    for (std::size_t i = out.names.size() + 1; i + static_cast<std::size_t>(out.trailing) <= cells.size();
         ++i) {
      out.names.push_back(field_name(i));
    }
    return out;
  }
  const std::size_t row_fields = cells.size();
  split(lines[0].text, out.separator, cells);
  const bool header_ends_empty = cells.size() > 1 && cells.back().empty();
  // A separator at the end of the header, of the rows or of both ends no further column.
  if (header_ends_empty &&
      (row_fields + 1 == cells.size() || (row_fields == cells.size() && row_ends_empty))) {
    out.trailing = row_fields == cells.size();
    cells.pop_back();
  } else {
    out.trailing = row_ends_empty && row_fields == cells.size() + 1;
  }
  out.names.assign(cells.begin(), cells.end());
  return out;
}

std::string field_name(std::size_t number) { return "#" + std::to_string(number); }

}  // namespace rivid::detail
