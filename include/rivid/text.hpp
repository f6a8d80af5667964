#pragma once

#include <span>
#include <string>
#include <string_view>

namespace rivid {

/// A number as messages and tables print it.
///
/// @param digits  significant ones
[[nodiscard]] std::string number(double value, int digits = 6);

/// "a", "b" and "c": names in quotes, for messages.
[[nodiscard]] std::string quoted_list(std::span<const std::string> names);

/// `; did you mean "torque"?` with the candidate nearest to a mistyped word, or nothing where none is near.
[[nodiscard]] std::string did_you_mean(std::string_view word, std::span<const std::string> candidates);

/// Width of a UTF-8 text on a terminal, one column a character.
[[nodiscard]] std::size_t display_width(std::string_view utf8);

}  // namespace rivid
