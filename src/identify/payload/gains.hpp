#pragma once

#include <vector>

#include "identify/payload/payload_model.hpp"
#include "rivid/identify/gains.hpp"

namespace rivid::detail {

// The gains of a fit that has them as unknowns; else none.
[[nodiscard]] std::vector<GainEstimate> gain_estimates(const Robot& robot, const PayloadFit& fit,
                                                       const Uncertainty& uncertainty);

}  // namespace rivid::detail
