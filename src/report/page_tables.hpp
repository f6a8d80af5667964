#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/fields.hpp"

// The keys of experiment files as their fields say them, for pages, schema and Python.
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

}  // namespace rivid::detail
