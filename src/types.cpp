#include "rivid/types.hpp"

namespace rivid::detail {

template <>
const char EigenHeapAlignment<EIGEN_DEFAULT_ALIGN_BYTES>::caller_and_librivid_must_use_the_same_simd_flags =
    0;

}  // namespace rivid::detail
