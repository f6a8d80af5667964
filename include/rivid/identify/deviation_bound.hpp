#pragma once

#include "rivid/data/log.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// Standard deviations that weighted least squares would have from regressors without noise, on all samples where joints
/// move: sqrt diag (Σ_j W_jᵀ W_j / σ_j²)⁻¹. No method can do much better.
///
/// @param log    of the motion, without noise
/// @param sigma  standard deviation of each joint's torque errors, white from sample to sample, (n) [N·m | N]
/// @return       (b), SI, in the order of base_parameters()
/// @throws InputError  where robot and log do not fit together
[[nodiscard]] Vector deviation_bound(const Robot& robot, const Log& log, const Vector& sigma);

}  // namespace rivid
