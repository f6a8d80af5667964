#include "signal/kernels_impl.hpp"

namespace rivid::detail {

const SignalKernels signal_avx2 = {decimate_segments, run_cascade};

}  // namespace rivid::detail
