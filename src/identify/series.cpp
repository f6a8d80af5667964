#include "identify/series.hpp"

#include <algorithm>
#include <cmath>

#include "identify/noise_level.hpp"

namespace rivid::detail {

namespace {

// A joint stands still where its positions stay within so many deviations of their noise, or within this range.
constexpr double still_sigmas = 12.0;
constexpr double still_range = 1e-3;  // [rad | m]

}  // namespace

double rms(const Eigen::Ref<const Vector>& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(std::max<Index>(x.size(), 1)));
}

Vector centred(const Eigen::Ref<const Vector>& x) { return x.array() - x.mean(); }

double range(const Eigen::Ref<const Vector>& x) { return x.maxCoeff() - x.minCoeff(); }

bool stands_still(const Eigen::Ref<const Vector>& q) {
  return range(q) <= std::max(still_range, still_sigmas * noise_level(q));
}

Likeness likeness(const Eigen::Ref<const Vector>& x, const Eigen::Ref<const Vector>& y) {
  const Vector a = centred(x);
  const Vector b = centred(y);
  const double norms = a.norm() * b.norm();
  return norms > 0.0 ? Likeness{a.dot(b) / a.squaredNorm(), a.dot(b) / norms} : Likeness{};
}

}  // namespace rivid::detail
