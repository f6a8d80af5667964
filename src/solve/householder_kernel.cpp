#include "solve/householder_kernel.hpp"

#include <array>

namespace rivid::detail {

namespace {

struct Found {
  std::array<const HouseholderKernel*, 3> kernels{};
  std::size_t count = 0;

  void add(const HouseholderKernel& kernel) { kernels[count++] = &kernel; }
};

Found found() {
  Found out;
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
  static const Found once = found();
  return std::span(once.kernels).first(once.count);
}

}  // namespace rivid::detail
