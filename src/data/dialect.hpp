#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/data/table.hpp"

namespace rivid::detail {

/// How a file writes its table, found from its first lines.
struct Dialect {
  char separator = ',';  ///< ' ' stands for any run of spaces and tabs
  bool header = false;
  std::vector<std::string> names;  ///< one a field
  bool trailing = false;           ///< every row ends in a separator
  std::size_t begin = 0;           ///< offset of the first line of data
  std::size_t line = 1;            ///< its number, from 1
};

/// @throws InputError  where the text holds no row of data or can not be understood
[[nodiscard]] Dialect dialect(std::string_view text, const std::string& source, const TableOptions& options);

/// Cells of one line, without the blanks and quotes around them, into `cells`.
void split(std::string_view line, char separator, std::vector<std::string_view>& cells);

/// Whether a line holds no row: blank or a comment.
[[nodiscard]] bool is_skipped(std::string_view line);

/// "#3", the name of a field without one.
[[nodiscard]] std::string field_name(std::size_t number);

/// How a cell reads.
enum class CellReading { number, not_finite, out_of_range, empty, words };

/// Reads a whole cell as a number; `value` is written where it is one.
[[nodiscard]] CellReading read_cell(std::string_view cell, char mark, double& value);

}  // namespace rivid::detail
