#pragma once

#include "identify/estimate/estimate.hpp"

namespace rivid::detail {

// By what an estimate moves with the relative errors of the drive gains, dχ̂/dε of torques (1 + ε_j) y_j, (b
// × n).
//
// Least squares on the rows stand for instruments and for a loss, and the fitted torques for the measured
// ones there: both differ by noise alone. Zero where the rows do not determine all parameters.
[[nodiscard]] Matrix gain_slopes(const EstimationProblem& problem, const Estimate& estimate);

}  // namespace rivid::detail
