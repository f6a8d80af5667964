#pragma once

#include <span>
#include <string>
#include <string_view>

namespace rivid::detail {

/// `; did you mean "link_1"?` for the name most like `wanted`, nothing where none is like it.
[[nodiscard]] std::string did_you_mean(std::string_view wanted, std::span<const std::string> names);

/// `"a", "b" and "c"`, cut short after a few dozen.
[[nodiscard]] std::string listed(std::span<const std::string> names);

}  // namespace rivid::detail
