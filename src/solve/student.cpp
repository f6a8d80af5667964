#include <cmath>
#include <numbers>

#include "rivid/solve/distributions.hpp"

namespace rivid {

namespace {

constexpr double normal_quantile_975 = 1.959963984540054;

}  // namespace

double student_quantile_975(double freedom) {
  // Exact for one and two degrees of freedom; above, the expansion of Fisher and Cornish in 1/freedom
  // (Abramowitz and Stegun 26.7.5), whose error is 0.12 % at 3 degrees of freedom and 1e-5 at 8.
  if (freedom < 1.5) {
    return std::tan(0.475 * std::numbers::pi);
  }
  if (freedom < 2.5) {
    return 0.95 * std::sqrt(2.0 / (1.0 - 0.95 * 0.95));
  }
  const double z = normal_quantile_975;
  const double z2 = z * z;
  const double g1 = z * (z2 + 1.0) / 4.0;
  const double g2 = z * ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
  const double g3 = z * (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0;
  const double g4 = z * ((((79.0 * z2 + 776.0) * z2 + 1482.0) * z2 - 1920.0) * z2 - 945.0) / 92160.0;
  return z + (g1 + (g2 + (g3 + g4 / freedom) / freedom) / freedom) / freedom;
}

}  // namespace rivid
