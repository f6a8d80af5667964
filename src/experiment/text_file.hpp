#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

// Small text files, read as a whole.
namespace rivid::detail {

/// Lists and tables within each other, and parts of a key, that a file may have: they are destroyed and
/// copied on the stack.
inline constexpr int deepest_nesting = 64;

/// @param what  the file as messages name it: "the experiment file"
/// @throws InputError  where it can not be read
[[nodiscard]] std::string file_text(const std::filesystem::path& path, std::string_view what);

/// The same of a file of at most so many bytes.
[[nodiscard]] std::string description_text(const std::filesystem::path& path, std::string_view what,
                                           std::uintmax_t most);

/// A path as it is written in a file of that folder: relative where both may move together.
[[nodiscard]] std::string from_folder(const std::filesystem::path& path, const std::filesystem::path& folder);

/// A table whose cells may hold words: separated by commas or semicolons, with a header, blank lines and
/// lines that start with # left out.
struct TextTable {
  struct Row {
    std::string place;  ///< "file:line"
    std::vector<std::string> cells;
  };

  std::string file;
  Row header;
  std::vector<Row> rows;  ///< each as long as the header
};

/// @throws InputError  where the file can not be read or a row has not as many fields as the header
[[nodiscard]] TextTable read_text_table(const std::filesystem::path& path, std::string_view what);

/// The same of a text that was read already, which `source` names in messages.
[[nodiscard]] TextTable parsed_text_table(const std::string& text, const std::string& source);

/// The number that a cell holds.
///
/// @throws InputError  where it is none or not finite
[[nodiscard]] double cell_number(const TextTable::Row& row, std::size_t column, std::string_view title);

}  // namespace rivid::detail
