#pragma once

#include <string_view>
#include <vector>

#include "excite/curve.hpp"
#include "excite/sampled_regressor.hpp"
#include "rivid/excite/limits.hpp"
#include "rivid/types.hpp"

// Limits of a sampled motion, each joint, quantity and side as one smooth function.
namespace rivid::detail {

enum class Limited { position, velocity, acceleration, jerk, torque };

/// One side of one limit of one joint: side · x ≤ edge, told as (side · x − edge) / scale ≤ 0.
struct SideLimit {
  Limited quantity = Limited::position;
  Index joint = 0;
  double side = 1.0;  ///< 1: x ≤ edge, −1: −x ≤ edge
  double edge = 0.0;
  double scale = 1.0;  ///< half of the range
};

/// Those of finite bounds.
[[nodiscard]] std::vector<SideLimit> side_limits(const MotionBounds& bounds);

/// A motion as limits see it.
struct LimitedMotion {
  const Motion& motion;
  const Matrix& jerk;
  const Matrix& torque;  ///< (samples × n), may be empty where torques are not limited

  [[nodiscard]] Eigen::Ref<const Vector> of(const SideLimit& limit) const;
};

/// Largest value of a limit over the samples, and where.
struct Peak {
  double value = 0.0;  ///< (side · x − edge) / scale
  Index sample = 0;
};
[[nodiscard]] Peak peak(const SideLimit& limit, const LimitedMotion& motion);

/// Soft maximum by Kreisselmeier & Steinhauser: log Σ exp(ρ g_k) / ρ, above the largest g by log N / ρ at most.
///
/// @param share  is set to its derivatives by g; zero where g is so small that it makes no difference
[[nodiscard]] double soft_maximum(const Vector& g, double rho, Vector& share);

}  // namespace rivid::detail
