#pragma once

#include "identify/estimate/estimate.hpp"

namespace rivid::detail {

// What Robot::tolerance adds to the covariance of an estimate, (b × b): Σ s sᵀ, where s is the step of the
// estimate with a length or an angle of the description by its standard deviation. Empty where that is
// exact, or the rows do not determine all parameters.
//
// Some instants of each log stand for all: a deviation needs no more.
[[nodiscard]] Matrix geometry_covariance(const EstimationProblem& problem, const Estimate& estimate);

}  // namespace rivid::detail
