#pragma once

#include <vector>

#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/dynamics.hpp"

namespace rivid {

/// How InverseDynamics goes about friction.
struct InverseDynamicsOptions {
  /// v_s of each joint, (n) [rad/s | m/s], positive: sign(q̇) becomes tanh(q̇ / v_s). The sign of a measured velocity
  /// flickers about rest with the noise of the encoder, and the torque with it. A motor that several joints turn takes
  /// Σ |c_k| v_s,k. Empty: sign(q̇) as it is identified, 0 at rest. What has a Joint::sign_speed keeps that one.
  Vector smoothing_speed = {};
};

/// Torques of a robot with numbers for its parameters, for the loop of a controller:
///
///   τ = M(q) q̈ + N(q, q̇) + friction(q̇),   Eq. (1) of [RIV].
///
/// Base parameters are all that it needs. Recursive Newton-Euler over links from which everything has been taken that
/// their joints turn without showing it, see DynamicModel for what it makes of friction that drives.
///
/// After the constructor no member allocates, throws or locks, provided that arguments are plain vectors, columns, or
/// maps of contiguous memory: Eigen::Ref copies what is not. Where a size is wrong the output is filled with NaN, which
/// every drive refuses. Scratch is in the object: a thread has a copy of its own, which shares nothing with the others.
class InverseDynamics {
 public:
  using Values = Eigen::Ref<const Vector>;
  using Result = Eigen::Ref<Vector>;

  /// The model is copied.
  ///
  /// @throws InputError  where an option can not be used
  explicit InverseDynamics(const DynamicModel& model, const InverseDynamicsOptions& options = {});

  /// From base parameters. Of an identification or its result.json take identified_model() or read_identified_model(),
  /// which refuse what a controller should not have.
  ///
  /// @param chi  (b)
  /// @throws InputError  as DynamicModel does, and where an option can not be used
  InverseDynamics(const Robot& robot, const BaseParameters& base, const Eigen::Ref<const Vector>& chi,
                  const InverseDynamicsOptions& options = {});

  [[nodiscard]] Index size() const noexcept { return model_.size(); }
  [[nodiscard]] const DynamicModel& model() const noexcept { return model_; }

  /// τ = M(q) q̈ + N(q, q̇) + friction(q̇).
  ///
  /// @param q    (n) [rad | m]
  /// @param qd   (n) [rad/s | m/s]
  /// @param qdd  (n) [rad/s² | m/s²]
  /// @param tau  (n) [N·m | N]; none of the others' memory
  void torque(const Values& q, const Values& qd, const Values& qdd, Result tau) noexcept;

  /// N(q, 0): what holds the robot against gravity, without friction, (n) [N·m | N].
  void gravity(const Values& q, Result tau) noexcept;

  /// N(q, q̇): Coriolis, centrifugal and gravity torques, without friction, (n) [N·m | N].
  void bias(const Values& q, const Values& qd, Result tau) noexcept;

  /// N(q, q̇) − N(q, 0), (n) [N·m | N].
  void coriolis(const Values& q, const Values& qd, Result tau) noexcept;

  /// Friction at these velocities, smoothed where the options say so, (n) [N·m | N]. A feed-forward takes the velocities
  /// of the reference, which do not flicker; compensation of what is measured takes measured ones and a smoothing speed.
  void friction(const Values& qd, Result tau) const noexcept;

  /// M(q), rotors included, (n × n) [kg·m² | kg·m | kg].
  void M(const Values& q, Eigen::Ref<Matrix> M) noexcept;

 private:
  void turn(const double* q) noexcept;
  [[nodiscard]] detail::Vec3<double> first_acceleration() const noexcept;
  // M q̈ + N without rotors; q̈ = 0 where qdd is null.
  void newton_euler(const double* q, const double* qd, const double* qdd, double* tau) noexcept;
  // From the wrenches of the links to the torques of the joints.
  void sum_up(const double* q, double* tau) noexcept;

  DynamicModel model_;
  Vector smoothing_;  // of each element of dry friction; empty: none
  detail::DynamicsTables tables_;
  Dynamics<double> dynamics_;                     // for M
  std::vector<detail::Wrench<double>> wrenches_;  // of the links
  std::vector<detail::CosSin<double>> turns_;     // of the joints
  Vector at_rest_;                                // zeros
  Vector scratch_;
};

}  // namespace rivid
