#pragma once

#include <string_view>

#include "excite/problem.hpp"
#include "rivid/excite/excitation.hpp"

namespace rivid::detail {

/// What forecast() and design() have in common: base parameters, a-priori values, limits, noise.
///
/// @param rate_hz   of the motion
/// @param findings  what was taken for granted is added to these
/// @throws InputError  in the name of `who`
[[nodiscard]] Task task_of(std::string_view who, const Robot& robot, const ExcitationOptions& options,
                           double rate_hz, std::vector<Finding>& findings);

[[nodiscard]] std::string_view name(Limited quantity);

}  // namespace rivid::detail
