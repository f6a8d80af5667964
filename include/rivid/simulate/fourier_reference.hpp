#pragma once

#include <optional>
#include <string>

#include "rivid/simulate/reference.hpp"

namespace rivid {

/// A finite Fourier series for each joint, the usual form of exciting trajectories [Swevers 1997]:
///
///   q_i(t) = q0_i + Σ_{l=1…L} A_il / (ω_f l) sin(l ω_f t) − B_il / (ω_f l) cos(l ω_f t)
///
/// so that A and B are the amplitudes of the velocities.
struct FourierSeries {
  double omega_f = 0.0;   ///< fundamental frequency [rad/s]
  Matrix A = {};          ///< (n × L) [rad/s | m/s]
  Matrix B = {};          ///< (n × L) [rad/s | m/s]
  Vector q0 = {};         ///< (n), empty: zero [rad | m]
  double duration = 0.0;  ///< 0: one period, 2π / ω_f [s]

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// A Fourier series as reference motion from t = 0. It does not in general begin or end at rest. Threads may share one.
class FourierReference final : public Reference {
 public:
  /// @throws InputError  the series' complaint()
  explicit FourierReference(FourierSeries series);

  [[nodiscard]] Index joints() const override { return series_.A.rows(); }
  [[nodiscard]] double duration() const override { return series_.duration; }
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r, Eigen::Ref<Vector> qdd_r) const override;

 private:
  FourierSeries series_;
};

}  // namespace rivid
