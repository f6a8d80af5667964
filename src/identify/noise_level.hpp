#pragma once

#include "rivid/types.hpp"

namespace rivid::detail {

// Standard deviation of white noise on a series, from fourth differences, which leave little of a motion.
[[nodiscard]] double noise_level(const Eigen::Ref<const Vector>& x);

}  // namespace rivid::detail
