#pragma once

#include <string>
#include <string_view>

namespace rivid {

/// What changed between two texts, line by line, in the unified format that `patch -p0` takes: three lines of context,
/// the fewest lines removed and added (Myers 1986). Empty where nothing changed.
///
/// @param before_name, after_name  what follows "---" and "+++"
[[nodiscard]] std::string unified_diff(std::string_view before, std::string_view after,
                                       std::string_view before_name, std::string_view after_name);

}  // namespace rivid
