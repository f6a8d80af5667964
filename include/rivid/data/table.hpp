#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Line of the file that each row of a table was read from. Comments and blank lines count, so the number is
/// the one an editor shows.
struct LineNumbers {
  struct Run {
    Index row = 0;         ///< first row of the run
    std::size_t line = 0;  ///< its line, from 1
  };
  std::vector<Run> runs;  ///< each a stretch of rows on consecutive lines, ascending

  [[nodiscard]] bool empty() const { return runs.empty(); }

  /// Line of a row, from 1; 0 where nothing is known.
  [[nodiscard]] std::size_t operator[](Index row) const;
};

/// Columns of numbers read from a text file.
struct Table {
  std::string source;               ///< the file, as messages name it
  std::vector<std::string> names;   ///< one a column; "#3" for the third field of a file without a header
  Matrix values;                    ///< (rows × columns), all finite
  LineNumbers lines;                ///< of the rows
  std::vector<std::size_t> fields;  ///< one a column: which field of the file's lines it is, from 1

  [[nodiscard]] Index rows() const { return values.rows(); }
  [[nodiscard]] Index columns() const { return values.cols(); }

  /// Index of the column of that name, from 0.
  ///
  /// @throws InputError  where there is none, with the names there are, or more than one
  [[nodiscard]] Index column(std::string_view name) const;
};

enum class Separator {
  automatic,  ///< the one that makes most cells of the first lines numbers
  comma,
  semicolon,
  tab,
  spaces  ///< any run of spaces and tabs
};
template <>
inline constexpr std::array names_of<Separator> =
    std::to_array<std::string_view>({"auto", ",", ";", "tab", "space"});

enum class Header {
  automatic,  ///< the first line holds the names if none of its cells is a number
  present,
  absent
};

enum class Decimal {
  automatic,  ///< a comma where the separator is none and the numbers look like 1,5
  point,
  comma
};
template <>
inline constexpr std::array names_of<Decimal> = std::to_array<std::string_view>({"auto", ".", ","});

/// How to read a table.
struct TableOptions {
  /// Columns to read, by name or as "#3" by the number of the field from 1, in this order; empty: all. A
  /// column that is not asked for may hold text.
  std::vector<std::string> columns = {};
  Separator separator = Separator::automatic;
  Header header = Header::automatic;
  Decimal decimal = Decimal::automatic;
  /// Called with the fraction read so far, every few megabytes and at the end; may be empty.
  std::function<void(double)> progress = {};

  template <typename T = TableOptions>
  static constexpr auto fields() {
    return std::tuple(Field{"separator", &T::separator,
                            "`\"auto\"`, `\",\"`, `\";\"`, `\"tab\"`, `\"space\"` (any run of blanks)"},
                      Field{"decimal", &T::decimal, "`\"auto\"`, `\".\"`, `\",\"`"},
                      Field{"header",
                            [](const T& t) {
                              return t.header == Header::automatic ? std::optional<bool>()
                                                                   : t.header == Header::present;
                            },
                            "whether the first line holds names",
                            {.otherwise = "by the file"}});
  }

  /// The first fault found, nothing if the options can be used.
  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// Reads a table of numbers from a text file.
///
/// Lines that start with # or % are comments, but names where the right one stands above the first row of a
/// file without a header and has one for each field; blank lines, a UTF-8 byte order mark, CRLF line ends,
/// quoted cells, spaces around cells and a last line without its end are accepted, and so is a separator at
/// the end of the lines if every row has it. All rows have the same number of fields. Numbers are rounded
/// correctly: what was printed with %.17g comes back bit by bit.
///
/// @return  the columns asked for; memory beside them is a few bytes for each comment or blank line among the
///          rows
/// @throws InputError  where the file can not be read, a column is missing (with the names there are), or a
///                     cell that is asked for holds no finite number: "run1.csv:1842:3: column "q2" holds
///                     "nan"; …", that is file, line and field
[[nodiscard]] Table read_table(const std::filesystem::path& path, const TableOptions& options = {});

/// Names of all columns of a file; "#1", "#2", … where it has no header.
///
/// @param options  its `columns` are not looked at
/// @throws InputError  where the file can not be read
[[nodiscard]] std::vector<std::string> column_names(const std::filesystem::path& path,
                                                    const TableOptions& options = {});

}  // namespace rivid
