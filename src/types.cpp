#include "rivid/types.hpp"

namespace rivid::detail {

template <int AlignBytes>
const char EigenHeapAlignment<AlignBytes>::caller_and_librivid_must_use_the_same_simd_flags = 0;

// An instantiation, not a specialisation: the header has already used it, after which clang refuses the latter.
template struct EigenHeapAlignment<EIGEN_DEFAULT_ALIGN_BYTES>;

}  // namespace rivid::detail
