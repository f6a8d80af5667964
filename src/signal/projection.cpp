#include "projection.hpp"

namespace rivid::detail {

namespace {

using Lanes = double __attribute__((vector_size(64)));  // split by the compiler where registers are narrower

}  // namespace

// The loop works on raw pointers and builtins alone: a function of the standard library or of Eigen that was inlined
// here for wide vectors could be merged by the linker with the plain one.
__attribute__((target_clones("arch=skylake-avx512", "arch=haswell", "default"))) void project_segments(
    const double* weights, long n_d, const double* x, long segments, double* out) {
  constexpr long together = 4;  // segments side by side hide the latency of the additions
  long s = 0;
  for (; s + together <= segments; s += together) {
    Lanes a[2 * together] = {};
    for (long m = 0; m < n_d; ++m) {
      Lanes low;
      Lanes high;
      __builtin_memcpy(&low, weights + projections * m, sizeof low);
      __builtin_memcpy(&high, weights + projections * m + 8, sizeof high);
#pragma GCC unroll 4
      for (long k = 0; k < together; ++k) {
        const double value = x[n_d * (s + k) + m];
        a[2 * k] += low * value;
        a[2 * k + 1] += high * value;
      }
    }
    __builtin_memcpy(out + projections * s, a, sizeof a);
  }
  for (; s < segments; ++s) {
    Lanes a[2] = {};
    for (long m = 0; m < n_d; ++m) {
      Lanes low;
      Lanes high;
      __builtin_memcpy(&low, weights + projections * m, sizeof low);
      __builtin_memcpy(&high, weights + projections * m + 8, sizeof high);
      a[0] += low * x[n_d * s + m];
      a[1] += high * x[n_d * s + m];
    }
    __builtin_memcpy(out + projections * s, a, sizeof a);
  }
}

}  // namespace rivid::detail
