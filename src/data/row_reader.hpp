#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dialect.hpp"
#include "rivid/data/table.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// How the rows of one file are read.
struct RowFormat {
  const Dialect& dialect;
  const std::string& source;   ///< the file, for messages
  char mark = '.';             ///< before the fraction of a number
  bool may_switch = false;     ///< whether a decimal comma in a number means that all numbers have one
  std::size_t comma_line = 0;  ///< where such a number stood
  /// One a field: where its column starts, nullptr where it is not asked for.
  std::vector<double*> targets;
  /// Of dates, which count in seconds from the midnight of this day (since 1970).
  std::optional<std::int64_t> first_day = {};
};

/// Reads rows, stretch after stretch of whole lines. Lines that a fast loop can not take whole are read again
/// with care, which also finds the words for what is wrong with them.
class RowReader {
 public:
  enum class End {
    complete,
    comma_found,  ///< numbers have a decimal comma, and the mark is a point: read all again with a comma
    date_found    ///< there is a date, and no first day
  };

  /// The format is referred to, not copied.
  ///
  /// @param begins_days  whether the first date says which is the first day
  RowReader(const RowFormat& format, bool begins_days)
      : format_(format), first_day_(format.first_day), begins_days_(begins_days) {}

  /// Reads lines into the columns.
  ///
  /// @param text  ends in a line end, with `number_padding` readable bytes behind it
  /// @param row   of the first line that holds one
  /// @param line  number of the first line
  /// @throws InputError  where a line can not be read
  End read(std::string_view text, Index row, std::size_t line);

  /// Row behind the last one that was read.
  [[nodiscard]] Index row() const { return row_; }
  /// Lines of the rows that read() read last; ends in a run without rows where the last lines held none.
  [[nodiscard]] const LineNumbers& lines() const { return lines_; }
  /// Line at which read() ended.
  [[nodiscard]] std::size_t line() const { return line_; }
  [[nodiscard]] std::optional<std::int64_t> first_day() const { return first_day_; }

 private:
  enum class Row { read, skipped, comma_found, date_found };

  template <char Separator, char Mark>
  End read_lines(std::string_view text);
  template <char Separator, char Mark>
  const char* fast_row(const char* p) const;
  Row careful_row(std::string_view line);
  void skip_line();
  [[nodiscard]] std::string place() const;
  [[noreturn]] void refuse_count() const;
  [[noreturn]] void refuse_cell(std::size_t field, std::string_view cell, CellReading reading) const;

  const RowFormat& format_;
  std::optional<std::int64_t> first_day_;
  bool begins_days_;
  std::vector<std::string_view> cells_;
  Index row_ = 0;
  std::size_t line_ = 0;
  LineNumbers lines_;
};

}  // namespace rivid::detail
