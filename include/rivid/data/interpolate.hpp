#pragma once

#include "rivid/types.hpp"

namespace rivid {

/// Cubic spline through samples, twice continuously differentiable, with not-a-knot ends: the two intervals
/// at each end share one cubic. The same curve as the default of SciPy's CubicSpline; two samples give a
/// line, three a parabola.
class CubicSpline {
 public:
  /// @param t       instants, (m), strictly increasing, m ≥ 2 [s]
  /// @param values  (m × n), one column a signal
  /// @throws InputError  where the sizes differ, m < 2, or t does not increase
  CubicSpline(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& values);

  /// Values at other instants, (k × n). Outside of the samples the cubic of the end is continued.
  ///
  /// @param at  instants, (k), in any order, fastest when ascending [s]
  [[nodiscard]] Matrix operator()(const Eigen::Ref<const Vector>& at) const;

 private:
  Vector t_;
  Matrix values_;
  Matrix slopes_;
};

/// Values of the polygon through samples at other instants, (k × n); outside of the samples the end value is
/// held.
///
/// @param t       instants, (m), strictly increasing, m ≥ 1 [s]
/// @param values  (m × n), one column a signal
/// @param at      instants, (k), in any order, fastest when ascending [s]
/// @throws InputError  where the sizes differ, m < 1, or t does not increase
[[nodiscard]] Matrix linear_interpolation(const Eigen::Ref<const Vector>& t,
                                          const Eigen::Ref<const Matrix>& values,
                                          const Eigen::Ref<const Vector>& at);

}  // namespace rivid
