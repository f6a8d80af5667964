#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/fields.hpp"

// The lists of keys in docs/experiment.md, of members in docs/result.md and the table of limits in
// docs/reliability.md, made from the fields.
namespace rivid::detail {

/// What can stand for a key of an experiment file.
enum class ValueKind {
  boolean,
  integer,
  number,
  word,
  string,
  file,
  list,
  two_numbers,
  three_numbers,
  lists,
  table,
  tables,
  column,
  columns
};

}  // namespace rivid::detail

namespace rivid {

template <>
inline constexpr std::array names_of<detail::ValueKind> = std::to_array<std::string_view>(
    {"boolean", "integer", "number", "word", "string", "file", "list", "two numbers", "three numbers",
     "list of lists", "table", "list of tables", "column", "columns"});

}  // namespace rivid

namespace rivid::detail {

/// One key of an experiment file, in the words of the page.
struct KeyRow {
  std::string key;
  std::vector<ValueKind> kinds = {};  ///< any of these, or one of `words`
  std::string type = {};              ///< the same in words
  std::string otherwise;              ///< the default
  std::string unit;
  std::string meaning;
  std::vector<std::string> words = {};  ///< that it may be, where it is a word
  Range range = {};                     ///< of a number
};

/// Rows of the tables of keys by the names of the tables: "signal", "method.iv".
[[nodiscard]] std::map<std::string, std::vector<KeyRow>> key_rows();

/// Markdown lists and tables by their names: "signal", "result.fit".
[[nodiscard]] std::map<std::string, std::string> page_tables();

/// A page with each table that follows a line "<!-- table: NAME -->" as it must be.
///
/// @throws InputError  where a name is unknown
[[nodiscard]] std::string with_tables(const std::string& page);

/// JSON Schema of experiment files, from which editors complete and check keys: docs/experiment.schema.json.
[[nodiscard]] std::string experiment_schema();

/// Words that keys of an experiment file can be set to.
[[nodiscard]] std::vector<std::string> words_of_keys();

}  // namespace rivid::detail
