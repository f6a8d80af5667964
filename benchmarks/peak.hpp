#pragma once

#include "rivid/regressor/batch.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace rivid::benchmarks {

/// As many multiplications and additions as the machine can do: chains enough to hide their latency, few
/// enough for the registers.
struct Peak {
  static constexpr int chains = 12;
  static constexpr int steps = 20'000;

  void (*run)();
  int lanes;          ///< of a register
  double operations;  ///< of run(), each on a whole register; a fused multiply-add is one
};

namespace detail {

#if defined(__x86_64__)
[[gnu::target("avx512f")]] inline void multiply_add_avx512() {
  __m512d x[Peak::chains] = {};
  for (int k = 0; k < Peak::steps; ++k) {
    for (__m512d& each : x) {
      each = _mm512_fmadd_pd(each, _mm512_set1_pd(0.5), _mm512_set1_pd(1.0));
      asm volatile("" : "+v"(each));
    }
  }
}

[[gnu::target("avx2,fma")]] inline void multiply_add_avx2() {
  __m256d x[Peak::chains] = {};
  for (int k = 0; k < Peak::steps; ++k) {
    for (__m256d& each : x) {
      each = _mm256_fmadd_pd(each, _mm256_set1_pd(0.5), _mm256_set1_pd(1.0));
      asm volatile("" : "+x"(each));
    }
  }
}
#endif

// Two numbers a register, as every machine has it.
inline void multiply_and_add() {
  using Values = double __attribute__((vector_size(16)));
  Values x[Peak::chains] = {};
  for (int k = 0; k < Peak::steps; ++k) {
    for (Values& each : x) {
      each = each * 0.5 + 1.0;
#if defined(__x86_64__)
      asm volatile("" : "+x"(each));
#else
      asm volatile("" : "+w"(each));
#endif
    }
  }
}

}  // namespace detail

/// @param simd  that this machine supports
inline Peak peak(Simd simd) {
  constexpr double products = 1.0 * Peak::chains * Peak::steps;
#if defined(__x86_64__)
  if (simd == Simd::best) {
    return peak(supported(Simd::avx512) ? Simd::avx512 : supported(Simd::avx2) ? Simd::avx2 : Simd::baseline);
  }
  if (simd == Simd::avx512) {
    return {detail::multiply_add_avx512, 8, products};
  }
  if (simd == Simd::avx2) {
    return {detail::multiply_add_avx2, 4, products};
  }
#endif
  return {detail::multiply_and_add, 2, 2.0 * products};
}

}  // namespace rivid::benchmarks
