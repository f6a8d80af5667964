#pragma once

#include <span>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/batch.hpp"

namespace rivid {

/// The rows V of the instruments of IDIM-IV beside the rows W that rows() has of the same logs: the loops of
/// the logs, simulated with the estimate. So Vᵀ Ω⁻¹ (Y − W χ̂) is zero as far as the iteration has settled.
///
/// Prefiltered estimates have instruments of whitened rows, and friction that follows the load has rows of a
/// tangent: of these there is nothing.
///
/// @return  one a log, (rows_j × own columns) for each joint; empty where the result has no such instruments,
///          or no loop can be simulated with the estimate
/// @throws InputError  where robot and logs are not those of the result
[[nodiscard]] std::vector<Observation> instrument_rows(const Robot& robot, const Identification& result,
                                                       std::span<const Log> logs);

}  // namespace rivid
