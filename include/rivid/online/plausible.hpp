#pragma once

#include "rivid/types.hpp"

namespace rivid::detail {

// Whether all values of a tick are numbers that a robot may have.
template <typename Values>
[[nodiscard]] bool plausible(const Values& values, double largest) noexcept {
  using Scalar = typename Values::Scalar;
  const auto limit = static_cast<Scalar>(largest);
  for (Index j = 0; j < values.size(); ++j) {
    if (!(values[j] <= limit && values[j] >= -limit)) {  // a NaN, too
      return false;
    }
  }
  return true;
}

}  // namespace rivid::detail
