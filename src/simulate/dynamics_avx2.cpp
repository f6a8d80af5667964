// Compiled with flags of its own, see src/CMakeLists.txt; what that forbids stands in regressor/batch_kernel.hpp.
#include "simulate/dynamics_batch_kernel.hpp"

namespace rivid::detail {

namespace {

struct Here;  // gives every instantiation internal linkage

constexpr DynamicsBatchKernel kernel = {4, &accelerate_packs<BasicPack<4, Here>>};

}  // namespace

const DynamicsBatchKernel& avx2_dynamics() { return kernel; }

}  // namespace rivid::detail
