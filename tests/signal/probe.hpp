#pragma once

#include <cmath>
#include <cstdint>

#include "rivid/types.hpp"

namespace rivid::probe {

/// The series of oracle.py: an offset, four tones and a sawtooth that hops like noise. Starts at sample
/// `start`.
inline Vector series(Index n_m, Index start = 0) {
  Vector x(n_m);
  for (Index i = 0; i < n_m; ++i) {
    const std::int64_t k = start + i;
    const auto t = static_cast<double>(k);
    x[i] = 0.4 + 0.8 * std::sin(0.004 * t) + 0.5 * std::sin(0.05 * t) + 0.3 * std::cos(0.31 * t) +
           0.2 * std::sin(1.7 * t) + 0.1 * static_cast<double>((k * 7919) % 101) / 101.0;
  }
  return x;
}

/// Columns of that series, each begun elsewhere.
inline Matrix columns(Index n_m, Index count) {
  Matrix x(n_m, count);
  for (Index c = 0; c < count; ++c) {
    x.col(c) = series(n_m, 37 * c);
  }
  return x;
}

}  // namespace rivid::probe
