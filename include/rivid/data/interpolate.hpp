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

  /// Value and derivatives at one instant, (n) each. No allocation, and no search where the clock is nearly uniform.
  ///
  /// @param t  instant [s]
  void at(double t, Eigen::Ref<Vector> value, Eigen::Ref<Vector> slope, Eigen::Ref<Vector> curvature) const;

  [[nodiscard]] Index size() const { return values_.cols(); }
  /// First and last instant of the samples [s].
  [[nodiscard]] double begin() const { return t_[0]; }
  [[nodiscard]] double end() const { return t_[t_.size() - 1]; }

 private:
  Vector t_;
  Matrix values_;
  Matrix slopes_;
};

namespace detail {

/// Interval i of the instants t that `at` lies in, t_i ≤ at < t_{i+1} and 0 ≤ i ≤ m − 2; the first or the last one
/// outside. It needs no search where the clock is nearly uniform.
[[nodiscard]] Index interval(const Vector& t, double at);

}  // namespace detail

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
