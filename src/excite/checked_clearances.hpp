#pragma once

#include <vector>

#include "rivid/excite/limits.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// Smallest distance of every pair along a motion, the nearest first and those that are left out last: by
/// code that shares nothing with Clearances, which designs it. Frames are KDL's, distances those of a search
/// along the line of a body.
///
/// @param kept  Clearances::kept() of the same robot and space
/// @param q     (samples × n)
/// @param f_m   rate of the samples [Hz]
[[nodiscard]] std::vector<ClearanceUse> checked_clearances(const Robot& robot, const Space& space,
                                                           const std::vector<bool>& kept, const Matrix& q,
                                                           double f_m);

}  // namespace rivid::detail
