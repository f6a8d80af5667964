#pragma once

#include <span>

#include "rivid/identify/identification.hpp"

namespace rivid::detail {

// Everything in `out` that follows from IDIM-IV.
void instrumental_fit(const Robot& robot, std::span<const Log> logs, const Estimation& method,
                      Identification& out);

}  // namespace rivid::detail
