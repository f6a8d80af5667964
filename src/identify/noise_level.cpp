#include "identify/noise_level.hpp"

#include <algorithm>
#include <cmath>

namespace rivid::detail {

namespace {

// Part of the differences that tells the noise, the small ones: the others see reversals. And the mean square of a
// Gaussian within the quantile of that part, in units of its variance.
constexpr double quiet_part = 0.95;
constexpr double quiet_square = 0.7588;
// Σ of the squared binomial coefficients of the fourth difference.
constexpr double fourth_difference_gain = 70.0;

}  // namespace

double noise_level(const Eigen::Ref<const Vector>& x) {
  const Index m = x.size() - 4;
  if (m < 1) {
    return 0.0;
  }
  Vector squares =
      (x.head(m) - 4.0 * x.segment(1, m) + 6.0 * x.segment(2, m) - 4.0 * x.segment(3, m) + x.tail(m))
          .cwiseAbs2();
  const auto quiet = static_cast<Index>(std::ceil(quiet_part * static_cast<double>(m)));
  std::nth_element(squares.begin(), squares.begin() + (quiet - 1), squares.end());
  const double mean = squares.head(quiet).sum() / static_cast<double>(quiet);
  return std::sqrt(mean / (quiet_square * fourth_difference_gain));
}

}  // namespace rivid::detail
