#pragma once

#include <optional>
#include <span>

#include "identify/fit.hpp"

namespace rivid::detail {

// out.essential, where it is wanted: the parameters that the estimate can not do without, and their fit.
//
// data     rows of the identification
// root     square root of the estimate's information for independent errors
// freedom  rows without parameters
void add_essential(const Robot& robot, const std::optional<Essential>& options, std::span<const Log> logs,
                   const RowFactors& data, const Matrix& root, double freedom, Identification& out);

}  // namespace rivid::detail
