#pragma once

#include "rivid/signal/filter.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Rows first, first + step, … of the series filtered forwards and backwards; `function` speaks in the error.
[[nodiscard]] Matrix forward_backward(const char* function, const Eigen::Ref<const Matrix>& x,
                                      const Filter& filter, Convention convention, Index first, Index step);

}  // namespace rivid::detail
