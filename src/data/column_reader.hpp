#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "rivid/data/table.hpp"
#include "rivid/input.hpp"

namespace rivid::detail {

/// What read_columns() has read.
struct ReadColumns {
  Index rows = 0;
  LineNumbers lines;                ///< of the rows
  std::vector<std::string> names;   ///< one a column
  std::vector<std::size_t> fields;  ///< one a column, from 1
};

/// Memory for columns of so many rows: where each of them begins, in their order. What it gave before is not
/// used any more.
using ColumnRoom = std::function<std::vector<double*>(std::size_t columns, Index rows)>;

/// Reads columns of a file that is in memory, straight to where they shall be. Room is asked for as many rows
/// as there are lines; the first `rows` of it are filled.
///
/// Files of more than a few megabytes are read by all processors, in stretches that are handed out in their
/// order. Neither numbers nor messages show it: of several lines that can not be read the first one counts.
/// Memory of stretches that are read is given back where nobody else needs it.
///
/// @throws InputError  as read_table() does
[[nodiscard]] ReadColumns read_columns(InputText& text, const std::string& source,
                                       const TableOptions& options, const ColumnRoom& room);

}  // namespace rivid::detail
