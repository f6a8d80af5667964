#pragma once

#include "rivid/data/interpolate.hpp"
#include "rivid/simulate/reference.hpp"

namespace rivid {

/// The reference that a controller logged: a cubic spline through its samples, twice continuously differentiable.
///
/// Velocity and acceleration are the derivatives of that spline. Where a reference velocity was logged as well, it is
/// not used: two columns that disagree, by a delay or by rounding, have no motion between their samples, and the
/// position is what the joint must follow. Who needs a controller's own velocity reference writes a Reference.
///
/// Threads may share one.
class LoggedReference final : public Reference {
 public:
  /// @param t    instants, (n_m), increasing, n_m ≥ 2 [s]
  /// @param q_r  reference positions, (n_m × n) [rad | m]
  /// @throws InputError  where the sizes differ, t does not increase or a value is not finite
  LoggedReference(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& q_r);

  [[nodiscard]] Index joints() const override { return spline_.size(); }
  [[nodiscard]] double begin() const override { return spline_.begin(); }
  [[nodiscard]] double duration() const override { return spline_.end() - spline_.begin(); }
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r, Eigen::Ref<Vector> qdd_r) const override;

 private:
  CubicSpline spline_;
};

/// A logged reference joined by straight lines, as simulators interpolate tables. Its velocity is the slope of the
/// line that begins at a sample, its acceleration is zero: for laws that use neither, or to repeat a simulation that was
/// made so. LoggedReference is the better motion.
///
/// Threads may share one.
class LinearReference final : public Reference {
 public:
  /// @param t    instants, (n_m), increasing, n_m ≥ 2 [s]
  /// @param q_r  reference positions, (n_m × n) [rad | m]
  /// @throws InputError  where the sizes differ, t does not increase or a value is not finite
  LinearReference(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& q_r);

  [[nodiscard]] Index joints() const override { return q_r_.cols(); }
  [[nodiscard]] double begin() const override { return t_[0]; }
  [[nodiscard]] double duration() const override { return t_[t_.size() - 1] - t_[0]; }
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r, Eigen::Ref<Vector> qdd_r) const override;

 private:
  Vector t_;
  Matrix q_r_;
};

}  // namespace rivid
