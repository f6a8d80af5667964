#include "solve/householder_kernel_impl.hpp"

namespace rivid::detail {

namespace {

struct Avx512 {
  static constexpr int lanes = 8;
  using Vec [[gnu::vector_size(64)]] = double;
  using Bits [[gnu::vector_size(64)]] = long long;

  static void keep(Vec& v) { asm("" : "+v"(v)); }
  static Vec pair(Vec a, Vec b) {
    return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14) +
           __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  }
  static Vec quad(Vec a, Vec b) {
    return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13) +
           __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  }
  static Vec sums(const Vec* a) {
    const Vec low = quad(pair(a[0], a[1]), pair(a[2], a[3]));
    const Vec high = quad(pair(a[4], a[5]), pair(a[6], a[7]));
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 8, 9, 10, 11) +
           __builtin_shufflevector(low, high, 4, 5, 6, 7, 12, 13, 14, 15);
  }
};

}  // namespace

const HouseholderKernel householder_avx512 = Householder<Avx512, 8>::kernel("AVX-512");

}  // namespace rivid::detail
