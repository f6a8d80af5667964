#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace rivid::detail {

/// What `item` makes of each of some things, one behind the other: "a, b, c".
template <typename Range, typename Item = std::identity>
[[nodiscard]] std::string joined(const Range& range, std::string_view separator = ", ",
                                 const Item& item = {}) {
  std::string out;
  for (const auto& each : range) {
    out.append(out.empty() ? "" : separator).append(std::invoke(item, each));
  }
  return out;
}

}  // namespace rivid::detail
