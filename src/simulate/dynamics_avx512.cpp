// Compiled with flags of its own, see src/CMakeLists.txt; what that forbids stands in regressor/batch_kernel.hpp.
#include "simulate/dynamics_batch_kernel.hpp"

namespace rivid::detail {

namespace {

struct Here;  // gives every instantiation internal linkage

constexpr DynamicsBatchKernel kernel = {8, &accelerate_packs<BasicPack<8, Here>>};

}  // namespace

const DynamicsBatchKernel& avx512_dynamics() { return kernel; }

}  // namespace rivid::detail
