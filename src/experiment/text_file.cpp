#include "experiment/text_file.hpp"

#include <optional>
#include <sstream>

#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> out(1);
  for (const char c : line) {
    if (c == ',' || c == ';') {
      out.emplace_back();
    } else if (c != ' ' && c != '\t' && c != '\r' && c != '"') {
      out.back() += c;
    }
  }
  return out;
}

}  // namespace

std::string file_text(const std::filesystem::path& path, std::string_view what) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    throw InputError(path.string() + ": " + std::string(what) +
                     " can not be read: " + (error ? error.message() : "there is no such file"));
  }
  return std::string(read_input(path).bytes());
}

std::string description_text(const std::filesystem::path& path, std::string_view what, std::uintmax_t most) {
  refuse_larger(path, most);
  return file_text(path, what);
}

std::string from_folder(const std::filesystem::path& path, const std::filesystem::path& folder) {
  std::error_code error;
  const std::string relative =
      std::filesystem::proximate(path, folder.empty() ? std::filesystem::path(".") : folder, error)
          .generic_string();
  return error || relative.starts_with("../../") ? std::filesystem::absolute(path).generic_string()
                                                 : relative;
}

TextTable read_text_table(const std::filesystem::path& path, std::string_view what) {
  return parsed_text_table(description_text(path, what, result_limit), path.string());
}

TextTable parsed_text_table(const std::string& text, const std::string& source) {
  TextTable out{.file = source, .header = {}, .rows = {}};
  std::istringstream in(text);
  std::string line;
  for (int count = 1; std::getline(in, line); ++count) {
    if (count == 1 && line.starts_with(byte_order_mark)) {
      line.erase(0, byte_order_mark.size());
    }
    TextTable::Row row{.place = out.file + ":" + std::to_string(count), .cells = cells(line)};
    if ((row.cells.size() == 1 && row.cells[0].empty()) || row.cells[0].starts_with('#')) {
      continue;
    }
    if (out.header.cells.empty()) {
      out.header = std::move(row);
      continue;
    }
    if (row.cells.size() != out.header.cells.size()) {
      throw InputError(row.place + ": " + std::to_string(row.cells.size()) + " fields, the header has " +
                       std::to_string(out.header.cells.size()));
    }
    out.rows.push_back(std::move(row));
  }
  return out;
}

double cell_number(const TextTable::Row& row, std::size_t column, std::string_view title) {
  const std::string& cell = row.cells[column];
  const std::optional<double> value = finite_number(cell);
  if (!value) {
    throw InputError(row.place + ": column \"" + std::string(title) + "\" holds \"" + cell +
                     "\"; must be a finite number");
  }
  return *value;
}

}  // namespace rivid::detail
