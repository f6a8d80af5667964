#pragma once

#include <vector>

#include "identify/estimate/estimate.hpp"
#include "identify/infer/scores.hpp"
#include "rivid/identify/log_factors.hpp"

namespace rivid::detail {

// Sums over blocks of time from their factors: some ten of all logs together, and of more logs one each as
// far as there are so many.
[[nodiscard]] std::vector<BlockSums> block_sums(const LogFactors& factors, const Estimate& estimate);

}  // namespace rivid::detail
