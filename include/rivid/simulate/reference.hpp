#pragma once

#include "rivid/types.hpp"

namespace rivid {

/// Reference motion of n joints as a function of time. Velocity and acceleration are the derivatives of the position.
class Reference {
 public:
  Reference() = default;
  Reference(const Reference&) = default;
  Reference& operator=(const Reference&) = default;
  virtual ~Reference() = default;

  [[nodiscard]] virtual Index joints() const = 0;
  [[nodiscard]] virtual double begin() const { return 0.0; }  ///< [s]
  /// Length of the motion from t = begin() [s].
  [[nodiscard]] virtual double duration() const = 0;

  /// Reference at one instant, (n) each; before the beginning and after the end it rests where it began or ended.
  /// No allocation.
  virtual void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
                  Eigen::Ref<Vector> qdd_r) const = 0;
};

}  // namespace rivid
