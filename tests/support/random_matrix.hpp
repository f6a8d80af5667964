#pragma once

#include <cstdint>
#include <random>

#include "rivid/types.hpp"
#include "support/normal.hpp"

namespace rivid::test {

/// Independent normal deviates.
inline Matrix random_matrix(Index rows, Index columns, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Normal normal;
  return Matrix::NullaryExpr(rows, columns, [&] { return normal(random); });
}

}  // namespace rivid::test
