#pragma once

#include <Eigen/Core>

namespace rivid {

using Index = Eigen::Index;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

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
}  // namespace rivid
