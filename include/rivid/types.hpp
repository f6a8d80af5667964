#pragma once

#include <Eigen/Core>

// Users of rivid::rivid have RIVID_LIBRARY defined: the headers declare what its archive holds, which src/simulate/headers.cpp
// fills. Users of rivid::headers have not: the headers define what they declare.
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

/// Defined for the one alignment that the library was compiled with.
template <int AlignBytes>
struct EigenHeapAlignment {
  static const char caller_and_librivid_must_use_the_same_simd_flags;
};

// Eigen's heap alignment is part of the ABI: a caller built with -mavx2 or -march=native that exchanges a
// vector with a library built without crashes at run time. This turns the crash into a link error.
[[gnu::used]] static const char* const eigen_heap_alignment_check =
    &EigenHeapAlignment<EIGEN_DEFAULT_ALIGN_BYTES>::caller_and_librivid_must_use_the_same_simd_flags;

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
