#include "solve/householder_kernel_impl.hpp"

namespace rivid::detail {

namespace {

struct Baseline {
  static constexpr int lanes = 2;
  using Vec [[gnu::vector_size(16)]] = double;
  using Bits [[gnu::vector_size(16)]] = long long;

  static void keep(Vec& /*v*/) {}
  static Vec sums(const Vec* a) {
    return __builtin_shufflevector(a[0], a[1], 0, 2) + __builtin_shufflevector(a[0], a[1], 1, 3);
  }
};

}  // namespace

const HouseholderKernel householder_baseline = Householder<Baseline, 4>::kernel("baseline");

namespace {

struct Runnable {
  const HouseholderKernel* kernels[3] = {};
  std::size_t count = 0;

  void add(const HouseholderKernel& kernel) { kernels[count++] = &kernel; }
};

Runnable runnable_kernels() {
  Runnable out;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) {
    out.add(householder_avx512);
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    out.add(householder_avx2);
  }
#endif
  out.add(householder_baseline);
  return out;
}

}  // namespace

std::span<const HouseholderKernel* const> householder_kernels() {
  static const Runnable once = runnable_kernels();
  return {once.kernels, once.count};
}

}  // namespace rivid::detail
