#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "excite/clearance.hpp"
#include "excite/constraints.hpp"
#include "excite/curve.hpp"
#include "excite/information.hpp"
#include "excite/sampled_regressor.hpp"
#include "rivid/excite/excitation.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

/// What a motion is designed for, and within what.
struct Task {
  Robot robot;
  BaseParameters base;
  Vector chi;      ///< a-priori values, (b); empty where torques are not limited
  Vector weights;  ///< rows a second over the variance of their errors, (n)
  Matrix known;    ///< information that is there already, (b × b)
  Objective objective;
  MotionBounds bounds;
  Space space = {};
  std::shared_ptr<const Clearances> clearances = {};
};

/// What forecast() and design() have in common: base parameters, a-priori values, limits, noise.
///
/// @param rate_hz   of the motion
/// @param findings  what was taken for granted is added to these
/// @throws InputError  in the name of `who`
[[nodiscard]] Task task_of(std::string_view who, const Robot& robot, const ExcitationOptions& options,
                           double rate_hz, std::vector<Finding>& findings);

/// The robot with Coulomb friction that is smooth at reversals, where it is not so already.
[[nodiscard]] Robot smoothed(Robot robot, double sign_speed);

/// Distances count as limits: (clearance − distance) / clearance_scale ≤ 0.
// [m] a choice: gradients of distances are then as large as those of other limits
inline constexpr double clearance_scale = 0.1;
/// Part of a distance that is kept free for what is nearer between the instants of the dense check.
inline constexpr double clearance_reserve = 1e-4;  // [m]

/// Joint and quantity, or the two bodies, of a limit of DenseCheck.
[[nodiscard]] std::string limit_in_words(const Task& task, Index limit);
/// What a limit's value means: "82.1 of at most 60 N·m".
[[nodiscard]] std::string excess_in_words(const Task& task, Index limit, double value);

/// Torques of a motion by the a-priori model, (samples × n).
[[nodiscard]] Matrix predicted_torques(SampledRegressor& regressor, const Motion& motion, const Vector& chi);

/// The objective and all limits as functions of the variables of a curve, on instants in the middle of equal
/// intervals.
class Problem {
 public:
  struct Value {
    bool defined = false;  ///< whether the motion determines all parameters
    double objective = 0.0;
    Vector limits = {};  ///< soft maxima with their shifts, not positive where they hold
  };

  /// @param samples  instants
  /// @param rho      sharpness of the soft maxima
  Problem(const Task& task, const Curve& curve, Index samples, double rho);

  [[nodiscard]] Index variables() const { return curve_.variables(); }
  [[nodiscard]] Index limits() const { return std::ssize(limits_) + clearances_.size(); }
  [[nodiscard]] const Curve& curve() const { return curve_; }

  /// @param gradient  where wanted: of the objective, (variables)
  /// @param jacobian  where wanted: of the limits, (variables × limits)
  [[nodiscard]] Value operator()(const Vector& z, Vector* gradient = nullptr, Matrix* jacobian = nullptr);

  /// Moves each limit, so that its soft maximum tells what is found elsewhere: on a denser grid.
  void shift(const Vector& z, const Vector& found);

 private:
  struct Sampled;

  void keep_clear(const Motion& motion, Value& out, Matrix* jacobian);
  [[nodiscard]] Matrix limit_slopes(const Sampled& at, std::span<const Vector> shares,
                                    std::span<const Slopes> of_torque) const;

  const Task& task_;
  const Curve& curve_;
  SampledRegressor regressor_;
  const Clearances& clearances_;
  double rho_;
  FunctionTables tables_;
  Vector weights_;  // of one sample, (n)
  std::vector<SideLimit> limits_;
  Vector shifts_;
  std::vector<Matrix> W_;
};

/// Limits on a grid at least as dense as the motion is played, with friction as it is, on both sides of each
/// reversal.
class DenseCheck {
 public:
  DenseCheck(const Task& task, const Curve& curve, Index samples);

  /// Largest value of each limit, in the order of the problem's.
  [[nodiscard]] Vector operator()(const Vector& z);

 private:
  const Task& task_;
  const Curve& curve_;
  SampledRegressor regressor_;
  const Clearances& clearances_;
  FunctionTables tables_;
  std::vector<SideLimit> limits_;
};

}  // namespace rivid::detail
