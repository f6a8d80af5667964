#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace rivid::detail {

/// A number as messages show it: up to nine significant digits.
[[nodiscard]] std::string text(double value);

/// "1 row", "2 rows".
[[nodiscard]] std::string counted(std::ptrdiff_t count, std::string_view noun);

/// `content` in quotes for a message: at most 40 characters, control characters as '?'.
[[nodiscard]] std::string quoted(std::string_view content);

/// "#3", the name of a field without one.
[[nodiscard]] std::string field_name(std::size_t number);

/// "t, q1, q2", and how many more where the list is long.
[[nodiscard]] std::string listed(const std::vector<std::string>& names);

/// `; did you mean "q1"?` where one of the names is close to `wanted`, else nothing.
[[nodiscard]] std::string suggestion(std::string_view wanted, const std::vector<std::string>& names);

}  // namespace rivid::detail
