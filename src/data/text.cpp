#include "text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdio>
#include <numeric>

namespace rivid::detail {

namespace {

constexpr std::size_t longest_quote = 40;
constexpr std::size_t longest_list = 60;

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// Levenshtein distance that does not count upper and lower case apart.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (lower(a[i]) == lower(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string text(double value) {
  std::array<char, 32> buffer{};
  const int length = std::snprintf(buffer.data(), buffer.size(), "%.9g", value);
  return {buffer.data(), static_cast<std::size_t>(length)};
}

std::string counted(std::ptrdiff_t count, std::string_view noun) {
  std::string out = std::to_string(count) + ' ';
  out += noun;
  return count == 1 ? out : out + 's';
}

std::string quoted(std::string_view content) {
  const bool cut = content.size() > longest_quote;
  std::size_t length = cut ? longest_quote : content.size();
  while (cut && length > 0 && (static_cast<unsigned char>(content[length]) & 0xC0U) == 0x80U) {
    --length;  // not in the middle of a UTF-8 character
  }
  std::string out = "\"";
  for (const char c : content.substr(0, length)) {
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x20U || byte == 0x7FU ? '?' : c;
  }
  return out + (cut ? "…\"" : "\"");
}

std::string field_name(std::size_t number) {
  std::string out = "#";
  out += std::to_string(number);  // "#" + … draws a false -Wrestrict from GCC 12
  return out;
}

std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (std::size_t i = 0; i < std::min(names.size(), longest_list); ++i) {
    out += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > longest_list) {
    out += " and " + std::to_string(names.size() - longest_list) + " more";
  }
  return out;
}

std::string suggestion(std::string_view wanted, const std::vector<std::string>& names) {
  const std::string* nearest = nullptr;
  std::size_t least = 1 + std::max<std::size_t>(1, wanted.size() / 3);
  for (const std::string& name : names) {
    const std::size_t d = distance(wanted, name);
    if (d < least && d < std::max(wanted.size(), name.size())) {
      least = d;
      nearest = &name;
    }
  }
  return nearest == nullptr ? "" : "; did you mean " + quoted(*nearest) + "?";
}

}  // namespace rivid::detail
