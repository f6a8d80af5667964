#pragma once

#include <optional>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/rows.hpp"

namespace rivid::detail {

// out.physical of an estimate with all its statistics, where it is asked for; else a warning where the data leave much
// open that it would settle.
//
// root  of the information on out.chi: rootᵀ root = C_χχ⁻¹, or a singular one where the rank is not full
void add_physical(const Robot& robot, const std::optional<Physical>& options, const RowFactors& data,
                  const Matrix& root, Identification& out);

}  // namespace rivid::detail
