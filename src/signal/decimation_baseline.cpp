#include "signal/decimation_kernel_impl.hpp"

namespace rivid::detail {

const DecimationKernel decimation_baseline = decimate_segments;

}  // namespace rivid::detail
