#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/simulate/reference.hpp"

namespace rivid {

/// How a move from rest to rest gets on.
enum class MoveProfile {
  /// s = 10 u³ − 15 u⁴ + 6 u⁵ with u = t / T: the lowest polynomial without a jump of the acceleration
  quintic,
  /// Trapezoidal acceleration: jerk ±j, 0, so that the acceleration rises to a, stays, and falls, then the velocity
  /// stays at v, then the mirror image. Moves within limits reach them; moves of given durations have seven phases of
  /// equal length.
  trapezoidal_acceleration
};

/// Moves from rest to rest through via points. All joints move together, along a straight line in joint space, either
/// in given times or as fast as the slowest joint's limits allow.
struct PointToPoint {
  Matrix via = {};  ///< points, (k × n), k ≥ 2, one row a point [rad | m]
  MoveProfile profile = MoveProfile::quintic;
  Vector durations = {};         ///< of the moves, (k − 1), or one for all; empty where limits are given [s]
  Vector max_velocity = {};      ///< limits, (n); empty: none [rad/s | m/s]
  Vector max_acceleration = {};  ///< (n); empty: none [rad/s² | m/s²]
  Vector max_jerk = {};  ///< (n); empty: none, but a trapezoidal acceleration needs it [rad/s³ | m/s³]
  Vector dwell = {};     ///< rest at each point, (k), or one for all; empty: none [s]

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// Point-to-point moves as reference motion from t = 0; position, velocity and acceleration are continuous. Threads may
/// share one.
class PointToPointReference final : public Reference {
 public:
  /// @throws InputError  the moves' complaint()
  explicit PointToPointReference(const PointToPoint& moves);

  [[nodiscard]] Index joints() const override { return via_.rows(); }
  [[nodiscard]] double duration() const override { return duration_; }
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r, Eigen::Ref<Vector> qdd_r) const override;

 private:
  struct Move {
    double start = 0.0;
    double duration = 0.0;
    double jerk_time = 0.0;          // T_j: each of the four phases of jerk
    double acceleration_time = 0.0;  // T_a: each of the two of constant acceleration
  };

  MoveProfile profile_;
  Matrix via_;  // (n × k)
  std::vector<Move> moves_;
  double duration_ = 0.0;
};

}  // namespace rivid
