#pragma once

#include <functional>

#include "rivid/excite/excitation.hpp"

namespace rivid::detail {

/// A motion of as few seconds as reach the options' target.
///
/// @param once  design of one period, for given harmonics and duration
/// @throws InputError  where the target can not be reached; the message says what keeps from it
[[nodiscard]] Excitation designed_for_target(const Robot& robot, const ExcitationOptions& options,
                                             const std::function<Excitation(const ExcitationOptions&)>& once);

}  // namespace rivid::detail
