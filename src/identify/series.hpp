#pragma once

#include "rivid/types.hpp"

// Figures of single columns of a log.
namespace rivid::detail {

[[nodiscard]] double rms(const Eigen::Ref<const Vector>& x);

[[nodiscard]] Vector centred(const Eigen::Ref<const Vector>& x);

/// Largest less smallest value.
[[nodiscard]] double range(const Eigen::Ref<const Vector>& x);

/// Whether positions [rad | m] stay within their noise, or within what is no motion.
[[nodiscard]] bool stands_still(const Eigen::Ref<const Vector>& q);

/// How well y = factor x + constant holds.
struct Likeness {
  /// Below this correlation two columns do not belong together.
  static constexpr double alike = 0.8;

  double factor = 0.0;
  double correlation = 0.0;
};

/// Zeros where one of both is constant.
[[nodiscard]] Likeness likeness(const Eigen::Ref<const Vector>& x, const Eigen::Ref<const Vector>& y);

}  // namespace rivid::detail
