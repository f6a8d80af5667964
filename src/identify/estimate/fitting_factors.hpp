#pragma once

#include <span>
#include <vector>

#include "rivid/identify/log_factors.hpp"
#include "rivid/identify/loop_factors.hpp"

namespace rivid::detail {

// Whether all parts are of joints with these columns.
[[nodiscard]] bool fit(const LogFactors& factors, std::span<const std::vector<Index>> columns);

// The same of rows with instruments; parts that are not there fit.
[[nodiscard]] bool fit(const LoopFactors& factors, std::span<const std::vector<Index>> columns);

}  // namespace rivid::detail
