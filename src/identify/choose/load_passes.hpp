#pragma once

#include <span>

#include "rivid/identify/identification.hpp"

namespace rivid::detail {

// The identification of a robot whose friction follows the load, which is not linear in all parameters: steps of
// Gauss-Newton from the estimate without that friction on, each of them a whole estimate on the rows of the tangent. The last one is
// inferred from, so that covariances know that the load is an estimate.
[[nodiscard]] Identification identified_under_load(const Robot& robot, std::span<const Log> logs,
                                                   const Estimation& estimation);

}  // namespace rivid::detail
