#include "solve/householder_kernel_impl.hpp"

namespace rivid::detail {

namespace {

struct Avx2 {
  static constexpr int lanes = 4;
  using Vec [[gnu::vector_size(32)]] = double;
  using Bits [[gnu::vector_size(32)]] = long long;

  static void keep(Vec& v) { asm("" : "+x"(v)); }
  static Vec pair(Vec a, Vec b) {
    return __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  }
  static Vec sums(const Vec* a) {
    const Vec low = pair(a[0], a[1]);
    const Vec high = pair(a[2], a[3]);
    return __builtin_shufflevector(low, high, 0, 1, 4, 5) + __builtin_shufflevector(low, high, 2, 3, 6, 7);
  }
};

}  // namespace

const HouseholderKernel householder_avx2 = Householder<Avx2, 4>::kernel("AVX2");

}  // namespace rivid::detail
