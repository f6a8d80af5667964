#pragma once

#include <cstdint>

#include "rivid/model/robot.hpp"

namespace rivid::detail {

/// A robot that the description may well stand for: rotors and friction are scaled by up to 1 ± spread, and
/// the pseudo-inertias P of its bodies become s A P Aᵀ with a factor s and a matrix A that scale and stretch
/// them by as much, so that they stay physically consistent.
///
/// @param spread  from 0 to below 1
/// @param seed    equal seeds give equal robots on every platform
[[nodiscard]] Robot drawn_about(Robot described, double spread, std::uint64_t seed);

}  // namespace rivid::detail
