#include "rivid/solve/robust_loss.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "rivid/error.hpp"

namespace rivid {

namespace {

// 75 % quantile of the normal distribution: half of its values are smaller in magnitude.
constexpr double normal_quartile = 0.6744897501960817;

}  // namespace

double default_tuning(RobustKind kind) { return kind == RobustKind::huber ? 1.345 : 4.685; }

double RobustLoss::weight(double u) const {
  const double a = std::abs(u) / tuning;
  if (kind == RobustKind::huber) {
    return a <= 1.0 ? 1.0 : 1.0 / a;
  }
  const double inner = std::max(1.0 - a * a, 0.0);
  return inner * inner;
}

double RobustLoss::slope(double u) const {
  const double a = std::abs(u) / tuning;
  if (a > 1.0) {
    return 0.0;
  }
  return kind == RobustKind::huber ? 1.0 : (1.0 - a * a) * (1.0 - 5.0 * a * a);
}

double robust_scale(std::span<double> rho) {
  if (rho.empty()) {
    throw InputError("robust_scale: rho has no values, must have at least one");
  }
  const auto smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto middle = rho.begin() + static_cast<std::ptrdiff_t>(rho.size() / 2);
  std::nth_element(rho.begin(), middle, rho.end(), smaller);
  double median = std::abs(*middle);
  if (rho.size() % 2 == 0) {
    median = 0.5 * (median + std::abs(*std::max_element(rho.begin(), middle, smaller)));
  }
  return median / normal_quartile;
}

}  // namespace rivid
