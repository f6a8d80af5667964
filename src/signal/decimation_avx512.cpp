#include "signal/decimation_kernel_impl.hpp"

namespace rivid::detail {

const DecimationKernel decimation_avx512 = decimate_segments;

}  // namespace rivid::detail
