#include "rivid/text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iomanip>
#include <numeric>
#include <sstream>
#include <utility>
#include <vector>

#include "read_number.hpp"

namespace rivid {

namespace {

constexpr std::size_t longest_quote = 40;  // bytes of UTF-8; a choice: fits a line of a message
constexpr std::size_t longest_list = 60;   // names; a choice: further ones are counted

bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

// Bytes of the UTF-8 character that a text, not empty, begins with; 0 for a control character and for what is
// none: RFC 3629.
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(0);
  constexpr unsigned del = 0x7F;  // ASCII's last control character
  if (first < 0x80U) {
    return first < ' ' || first == del ? 0 : 1;
  }
  const std::size_t length = first >= 0xC2U && first < 0xE0U   ? 2
                             : first >= 0xE0U && first < 0xF0U ? 3
                             : first >= 0xF0U && first < 0xF5U ? 4
                                                               : 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) {
      return 0;
    }
  }
  // C1 controls, forms longer than need be, surrogates and what is beyond the last character.
  const unsigned second = byte(1);
  const bool refused = (first == 0xC2U && second < 0xA0U) || (first == 0xE0U && second < 0xA0U) ||
                       (first == 0xEDU && second >= 0xA0U) || (first == 0xF0U && second < 0x90U) ||
                       (first == 0xF4U && second >= 0x90U);
  return refused ? 0 : length;
}

// Levenshtein's distance; upper and lower case count as the same.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  const auto same = [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  };
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (same(a[i], b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

// User text with control characters escaped and cut to a length that fits an error message.
std::string shown(std::string_view content) {
  const bool cut = content.size() > longest_quote;
  std::size_t length = cut ? longest_quote : content.size();
  while (cut && length > 0 && continues_character(content[length])) {
    --length;
  }
  return on_one_line(content.substr(0, length)) + (cut ? "…" : "");
}

std::string cut_short(std::string list, std::size_t length) {
  if (length > longest_list) {
    list += " and " + std::to_string(length - longest_list) + " more";
  }
  return list;
}

}  // namespace

std::string exact(double value) {
  std::array<char, 32> buffer{};
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value + 0.0).ptr};
}

std::optional<double> finite_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = detail::read_number(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string fixed(double value, int decimals) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(decimals) << value;
  return out.str();
}

std::string on_one_line(std::string_view content) {
  std::string out;
  while (!content.empty()) {
    const std::size_t length = character_length(content);
    out += length == 0 ? "?" : content.substr(0, length);
    content.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

std::string in_quotes(std::string_view content) { return "\"" + shown(content) + "\""; }

std::string listed(std::span<const std::string> names) {
  std::string out;
  for (std::size_t i = 0; i < std::min(names.size(), longest_list); ++i) {
    out += (i == 0 ? "" : ", ") + shown(names[i]);
  }
  return cut_short(std::move(out), names.size());
}

std::string quoted_list(std::span<const std::string> names) {
  std::string out;
  for (std::size_t i = 0; i < std::min(names.size(), longest_list); ++i) {
    out += i == 0 ? "" : i + 1 == names.size() ? " and " : ", ";
    out += in_quotes(names[i]);
  }
  return cut_short(std::move(out), names.size());
}

namespace {

// What other programs call what rivid has, and its name here.
constexpr auto other_words =
    std::to_array<std::pair<std::string_view, std::string_view>>({{"filter_hz", "cutoff_hz"},
                                                                  {"lowpass_hz", "cutoff_hz"},
                                                                  {"current", "control"},
                                                                  {"effort", "torque"},
                                                                  {"downsample", "decimation"},
                                                                  {"gazebo", "sdf"},
                                                                  {"mujoco", "mjcf"},
                                                                  {"--plot", "--report"},
                                                                  {"--plots", "--report"},
                                                                  {"--html", "--report"}});

}  // namespace

std::string did_you_mean(std::string_view word, std::span<const std::string> names) {
  for (const auto& [other, name] : other_words) {
    if (other == word && std::ranges::find(names, name) != names.end()) {
      return "; did you mean " + in_quotes(name) + "?";
    }
  }
  const std::string* nearest = nullptr;
  std::size_t least = 1 + std::max<std::size_t>(1, word.size() / 3);
  for (const std::string& name : names) {
    const std::size_t d = edit_distance(word, name);
    if (d < least && d < std::max(word.size(), name.size())) {
      least = d;
      nearest = &name;
    }
  }
  return nearest == nullptr ? "" : "; did you mean " + in_quotes(*nearest) + "?";
}

std::size_t display_width(std::string_view utf8) {
  return utf8.size() - static_cast<std::size_t>(std::ranges::count_if(utf8, continues_character));
}

}  // namespace rivid
