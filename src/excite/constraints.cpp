#include "excite/constraints.hpp"

#include <cmath>
#include <limits>

namespace rivid::detail {

std::vector<SideLimit> side_limits(const MotionBounds& bounds) {
  std::vector<SideLimit> out;
  for (Index j = 0; j < bounds.lower.size(); ++j) {
    const double half = 0.5 * (bounds.upper[j] - bounds.lower[j]);
    if (std::isfinite(half)) {
      out.push_back({Limited::position, j, 1.0, bounds.upper[j], half});
      out.push_back({Limited::position, j, -1.0, -bounds.lower[j], half});
    }
    for (const LimitedRow& row : limited_rows) {
      const double size =
          row.bound != nullptr ? (bounds.*row.bound)[j] : std::numeric_limits<double>::infinity();
      for (const double side : {1.0, -1.0}) {
        if (std::isfinite(size)) {
          out.push_back({row.quantity, j, side, size, size});
        }
      }
    }
  }
  return out;
}

Peak peak(const SideLimit& limit, const LimitedMotion& motion) {
  Peak out;
  const double extreme = (limit.side * motion.of(limit)).maxCoeff(&out.sample);
  out.value = (extreme - limit.edge) / limit.scale;
  return out;
}

double soft_maximum(const Vector& g, double rho, Vector& share) {
  const double most = g.maxCoeff();
  // Most samples are far below the largest one: what they add is less than rounding.
  share = g.unaryExpr([&](double x) {
    const double exponent = rho * (x - most);
    return exponent > negligible_exponent ? std::exp(exponent) : 0.0;
  });
  const double sum = share.sum();
  share /= sum;
  return most + std::log(sum) / rho;
}

}  // namespace rivid::detail
