// Compiled with flags of its own, see src/CMakeLists.txt; what that forbids stands in batch_kernel.hpp.
#include "regressor/batch_kernel.hpp"

namespace rivid::detail {

namespace {

struct Here;  // gives every instantiation internal linkage

constexpr BatchKernel kernel = {4, &fill_packs<BasicPack<4, Here>>};

}  // namespace

const BatchKernel& avx2_kernel() { return kernel; }

}  // namespace rivid::detail
