#pragma once

#include <Eigen/Core>

// Users of rivid::rivid have RIVID_LIBRARY defined: the headers declare what its archive holds, which
// src/simulate/headers.cpp fills. Users of rivid::headers have not: the headers define what they declare.
#ifndef RIVID_LIBRARY
#define RIVID_DEFINITIONS
#define RIVID_INLINE inline
#else
#define RIVID_INLINE
#endif

namespace rivid {

using Index = Eigen::Index;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

#ifdef RIVID_LIBRARY
namespace detail {

/// Defined for the one way in which the library takes its memory.
template <int AlignBytes, bool IsMalloc>
struct EigenHeap {
  static const char caller_and_librivid_must_use_the_same_simd_flags_and_EIGEN_MALLOC_ALREADY_ALIGNED;
};
constexpr bool eigen_heap_is_malloc = EIGEN_DEFAULT_ALIGN_BYTES == 0 || EIGEN_MALLOC_ALREADY_ALIGNED != 0;

// How Eigen frees memory is part of the ABI, and follows the flags: alignment those of SIMD (-mavx2,
// -march=native), and under AddressSanitizer Eigen pads by hand what malloc() had aligned. A vector that
// comes from the library would crash a program that was built otherwise; this turns the crash into a link
// error. -DEIGEN_MALLOC_ALREADY_ALIGNED=1 lets a program under AddressSanitizer use a library that was built
// without.
[[gnu::used]] static const char* const eigen_heap_check =
    &EigenHeap<EIGEN_DEFAULT_ALIGN_BYTES, eigen_heap_is_malloc>::
        caller_and_librivid_must_use_the_same_simd_flags_and_EIGEN_MALLOC_ALREADY_ALIGNED;

}  // namespace detail
#endif

/// A motion of n joints at n_m instants: one row a sample, one column a joint.
struct Motion {
  Matrix q;    ///< positions, (n_m × n) [rad | m]
  Matrix qd;   ///< velocities, (n_m × n) [rad/s | m/s]
  Matrix qdd;  ///< accelerations, (n_m × n) [rad/s² | m/s²]

  [[nodiscard]] Index samples() const { return q.rows(); }
  [[nodiscard]] Index joints() const { return q.cols(); }
};

/// Rows in memory of somebody else's: entry (row, column) is data[row + column * ld].
struct RowsTarget {
  double* data = nullptr;
  Index ld = 0;
};

/// Room for rows in the memory of whoever consumes them, so that a producer writes each row once.
struct RowsRoom {
  RowsTarget target;
  Index rows = 0;  ///< that fit
};

}  // namespace rivid
