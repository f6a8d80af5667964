#pragma once

#include <vector>

#include "rivid/excite/limits.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// Smallest distance of every pair along a motion, the nearest first and those that are left out last. Frames
/// are Eigen's, and each distance is proven by a direction that separates all points of the two bodies: what
/// Clearances, which designs the motion, may have wrong in either does not hide what is near.
///
/// @param kept  Clearances::kept() of the same robot and space
/// @param q     (samples × n)
/// @param f_m   rate of the samples [Hz]
[[nodiscard]] std::vector<ClearanceUse> checked_clearances(const Robot& robot, const Space& space,
                                                           const std::vector<bool>& kept, const Matrix& q,
                                                           double f_m);

}  // namespace rivid::detail
