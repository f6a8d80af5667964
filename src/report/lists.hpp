#pragma once

#include <limits>
#include <ranges>

#include "report/document.hpp"

// Tables whose rows are places in several lists.
namespace rivid::detail {

// What one record of a list says, by its place in the list.
using Indexed = ColumnOf<std::size_t>;

[[nodiscard]] inline auto places(std::size_t count) { return std::views::iota(std::size_t{0}, count); }

// Not a number behind the end.
[[nodiscard]] inline double at(const Vector& values, std::size_t i) {
  const auto k = static_cast<Index>(i);
  return k < values.size() ? values[k] : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace rivid::detail
