// Compiled with flags of its own, see src/CMakeLists.txt; what that forbids stands in batch_kernel.hpp.
#include "regressor/batch_kernel.hpp"

namespace rivid::detail {

namespace {

struct Here;  // gives every instantiation internal linkage

constexpr BatchKernel kernel = {8, &fill_packs<BasicPack<8, Here>>};

}  // namespace

const BatchKernel& avx512_kernel() { return kernel; }

}  // namespace rivid::detail
