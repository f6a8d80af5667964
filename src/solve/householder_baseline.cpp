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

}  // namespace rivid::detail
