#include "rivid/types.hpp"

namespace rivid::detail {

template <int AlignBytes, bool IsMalloc>
const char EigenHeap<
    AlignBytes, IsMalloc>::caller_and_librivid_must_use_the_same_simd_flags_and_EIGEN_MALLOC_ALREADY_ALIGNED =
    0;

// An instantiation, not a specialisation: the header has already used it, after which clang refuses the
// latter.
template struct EigenHeap<EIGEN_DEFAULT_ALIGN_BYTES, eigen_heap_is_malloc>;

}  // namespace rivid::detail
