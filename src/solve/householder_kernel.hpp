#pragma once

// The hot path of StreamingQr: Householder elimination of a block of rows under a triangle.
// householder_kernel_impl.hpp is compiled once an instruction set, see instruction_sets.hpp.

#include <cstddef>

#include "instruction_sets.hpp"

namespace rivid::detail {

/// Rows that one elimination takes: the panel of eight columns of that length stays in the first-level cache,
/// the block in the second. (256 rows pay more for the scalar work between columns, 1024 fall out of the
/// cache.)
inline constexpr std::ptrdiff_t block_rows = 512;
/// Doubles from one column of a block to the next: no multiple of 4096 bytes, or all columns would share the
/// same few lines of the cache. A constant, so that addresses cost no registers.
inline constexpr std::ptrdiff_t block_stride = block_rows + 8;
/// Reflectors applied together. The rows of the triangle are padded to a multiple of it.
inline constexpr std::ptrdiff_t panel_columns = 8;

/// A triangle and a block of rows under it, column-major: [R; block] is brought to [R'; 0] on the eliminated
/// columns, and the carried columns on their right are taken along.
struct HouseholderBlock {
  std::ptrdiff_t columns = 0;  ///< eliminated
  std::ptrdiff_t carried = 0;
  double* R = nullptr;             ///< (R_stride × (columns + carried)), zero below the diagonal
  std::ptrdiff_t R_stride = 0;     ///< `columns` rounded up to a multiple of panel_columns
  double* rows = nullptr;          ///< (block_stride × (columns + carried)), destroyed
  std::ptrdiff_t row_count = 0;    ///< at most block_rows; a multiple of 8, to which zero rows are appended
  double* sums = nullptr;          ///< (columns + carried): the sums of the columns of the block are added
  double* rest_squares = nullptr;  ///< (carried): set to the squared norms of what is left of the block
};

struct HouseholderKernel {
  int lanes;  ///< doubles in a vector register
  void (*eliminate)(const HouseholderBlock& block);
  /// Copies, and returns whether the magnitude of every value is at most `limit`; it is not for a nan. As
  /// many values at `next` are asked for meanwhile: columns of a large matrix lie too far apart for the
  /// machine to foresee.
  bool (*copy_within)(const double* from, std::ptrdiff_t count, double limit, double* to, const double* next);
  /// Whether the magnitude of every value is at most `limit`.
  bool (*all_within)(const double* values, std::ptrdiff_t count, double limit);
};

}  // namespace rivid::detail
