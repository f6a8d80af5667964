#pragma once

#include <vector>

#include "rivid/types.hpp"

namespace rivid::detail {

// The columns of a factor brought to norm 1, so that units do not decide about rank.
struct ColumnScaled {
  Matrix R;
  Vector norms;  // 1 where a column is zero
};
[[nodiscard]] ColumnScaled column_scaled(const Eigen::Ref<const Matrix>& R);

// A pivot is noise when it lies below the rounding errors that the factorisation of all rows leaves.
[[nodiscard]] double rank_tolerance(Index rows, Index columns);

// Sets of columns that a null space ties together, as a null vector with several entries says.
[[nodiscard]] std::vector<std::vector<Index>> tied_columns(const Matrix& null_space);

// Ratio of the extreme singular values, infinite where the least is zero.
[[nodiscard]] double condition_number(const Matrix& R);

}  // namespace rivid::detail
