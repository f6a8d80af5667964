#include "signal/kernels_impl.hpp"

namespace rivid::detail {

const SignalKernels signal_baseline = {decimate_segments, run_cascade};

namespace {

const SignalKernels& fastest() {
#if defined(__x86_64__)
  const bool avx2 = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
  if (avx2 && __builtin_cpu_supports("avx512f") != 0) {
    return signal_avx512;
  }
  if (avx2) {
    return signal_avx2;
  }
#endif
  return signal_baseline;
}

}  // namespace

const SignalKernels& signal_kernels() {
  static const SignalKernels& once = fastest();
  return once;
}

}  // namespace rivid::detail
