#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "excite/curve.hpp"
#include "excite/sampled_regressor.hpp"
#include "rivid/excite/limits.hpp"
#include "rivid/model/kinds.hpp"
#include "rivid/types.hpp"

// Limits of a sampled motion, each joint, quantity and side as one smooth function.
namespace rivid::detail {

enum class Limited { position, velocity, acceleration, jerk, torque };

/// All that is known of such a quantity.
struct LimitedRow {
  Limited quantity;
  std::string_view name;
  JointUnit unit;
  Vector MotionBounds::* bound;    ///< of both sides; null: each side has its own
  Matrix FunctionTables::* table;  ///< that it is linear in; null: it is not linear
};
inline constexpr auto limited_rows = std::to_array<LimitedRow>({
    {Limited::position, "position", {"rad", "m"}, nullptr, &FunctionTables::position},
    {Limited::velocity, "velocity", {"rad/s", "m/s"}, &MotionBounds::velocity, &FunctionTables::velocity},
    {Limited::acceleration,
     "acceleration",
     {"rad/s²", "m/s²"},
     &MotionBounds::acceleration,
     &FunctionTables::acceleration},
    {Limited::jerk, "jerk", {"rad/s³", "m/s³"}, &MotionBounds::jerk, &FunctionTables::jerk},
    {Limited::torque, "torque", {"N·m", "N"}, &MotionBounds::torque, nullptr},
});
static_assert(complete<limited_rows, &LimitedRow::quantity>(), "one row for each Limited, in its order");

[[nodiscard]] constexpr const LimitedRow& about(Limited quantity) {
  return limited_rows[static_cast<std::size_t>(quantity)];
}
[[nodiscard]] inline std::string unit_of(Limited quantity, JointType type) {
  const JointUnit& unit = about(quantity).unit;
  return std::string(type == JointType::revolute ? unit.revolute : unit.prismatic);
}

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

  [[nodiscard]] Eigen::Ref<const Vector> of(const SideLimit& limit) const {
    const std::array all = {&motion.q, &motion.qd, &motion.qdd, &jerk, &torque};
    static_assert(all.size() == limited_rows.size());
    return all[static_cast<std::size_t>(limit.quantity)]->col(limit.joint);
  }
};

/// Largest value of a limit over the samples, and where.
struct Peak {
  double value = 0.0;  ///< (side · x − edge) / scale
  Index sample = 0;
};
[[nodiscard]] Peak peak(const SideLimit& limit, const LimitedMotion& motion);

/// What is smaller than the largest by more than this, times ρ, has no share of a soft maximum.
inline constexpr double negligible_exponent = -37.0;

/// Soft maximum by Kreisselmeier & Steinhauser: log Σ exp(ρ g_k) / ρ, above the largest g by log N / ρ at
/// most.
///
/// @param share  is set to its derivatives by g; zero where g is so small that it makes no difference
[[nodiscard]] double soft_maximum(const Vector& g, double rho, Vector& share);

}  // namespace rivid::detail
