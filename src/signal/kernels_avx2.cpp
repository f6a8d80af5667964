#include "signal/cascade_impl.hpp"
#include "signal/decimation_impl.hpp"

namespace rivid::detail {

const SignalKernels signal_avx2 = {decimate_segments, run_cascade};

}  // namespace rivid::detail
