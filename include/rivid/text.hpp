#pragma once

#include <array>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace rivid {

/// A number as messages and tables print it.
///
/// @param digits  significant ones
[[nodiscard]] inline std::string number(double value, int digits = 9) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
  return text.data();
}

/// The shortest text that reads back as the same number, whatever the locale; no negative zero.
[[nodiscard]] std::string exact(double value);

/// The finite number that a text is as a whole, whatever the locale.
[[nodiscard]] std::optional<double> finite_number(std::string_view text);

/// A number with so many decimals.
[[nodiscard]] std::string fixed(double value, int decimals);

/// Percent or standard deviations beyond which a figure says nothing but that what it is measured by is next
/// to nothing.
inline constexpr double most_said = 1e6;

/// number(), or "more than a million" beyond that.
[[nodiscard]] inline std::string number_that_says(double value, int digits) {
  return value > most_said ? "more than a million" : number(value, digits);
}

/// `content` with control characters, line ends among them, as '?'.
[[nodiscard]] std::string on_one_line(std::string_view content);

/// `content` in quotes for a message: at most 40 characters, control characters as '?'.
[[nodiscard]] std::string in_quotes(std::string_view content);

/// "1 row", "2 rows", "3 entries".
[[nodiscard]] inline std::string counted(std::ptrdiff_t count, std::string_view noun) {
  std::string out = std::to_string(count) + " " + std::string(noun);
  if (count == 1) {
    return out;
  }
  if (out.ends_with("ry")) {
    out.replace(out.size() - 1, 1, "ie");
  }
  return out + "s";
}

/// `t, q1, q2`, each name like in_quotes() shows it, and how many more where the list is long.
[[nodiscard]] std::string listed(std::span<const std::string> names);

/// `"a", "b" and "c"`, and how many more where the list is long.
[[nodiscard]] std::string quoted_list(std::span<const std::string> names);

/// `; did you mean "torque"?` with the name most like a mistyped word, or nothing where none is like it.
[[nodiscard]] std::string did_you_mean(std::string_view word, std::span<const std::string> names);

/// Width of a UTF-8 text on a terminal, one column a character.
[[nodiscard]] std::size_t display_width(std::string_view utf8);

}  // namespace rivid
