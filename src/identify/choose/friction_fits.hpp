#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"

// Fits of friction laws, side by side, to the rows that one is chosen by.
namespace rivid::detail {

// Normal equations of rows of one joint as [W, T L, y]ᵀ [W, T L, y]. The torque is (W + Fl T L) χ, where T
// has the sign of the velocity times that of the load L χ on its diagonal.
struct JointSums {
  Matrix WW;
  Vector Wy;
  Matrix WL;  // Wᵀ T L; those with L are empty where the joint's law is not to be chosen
  Matrix LL;
  Vector Ly;
  double yy = 0.0;
  Index rows = 0;

  // sign  1.0 to add, -1.0 to take away
  void add(const JointSums& other, double sign) {
    WW += sign * other.WW;
    WL += sign * other.WL;
    LL += sign * other.LL;
    Wy += sign * other.Wy;
    Ly += sign * other.Ly;
    yy += sign * other.yy;
    rows += sign > 0.0 ? other.rows : -other.rows;
  }
};

// The rows of one joint in one stretch of time.
struct StretchRows {
  std::size_t joint = 0;
  std::size_t fold = 0;
  std::vector<Index> columns;  // of the linear robot's base parameters
  Matrix W;
  Vector y;
  Vector sign;    // of the velocity; empty where the joint's law is not to be chosen
  Matrix rigid;   // columns of M q̈ + N, zeros elsewhere
  Vector turned;  // diagonal of T in the sums
  JointSums sums;
};

// A fit of some laws.
struct LawFit {
  Vector theta;    // [χ, Fl], zero where the laws do not have it
  Vector weights;  // of the joints
  Matrix A;        // of the normal equations of the last step
};

// Fits of a law for each joint. Laws differ in few columns and stretches of time in few rows, so fits share
// the sums of all of them: cross-validation takes eight times as many fits as there are laws, each of which
// costs as much by all rows as the estimate itself.
class FrictionFits {
 public:
  // No stretch.
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  // folds  of the stretches; those with a larger one take part in no fit
  FrictionFits(const Robot& robot, const BaseParameters& base, std::vector<StretchRows> stretches,
               std::size_t folds);

  // To all stretches, or all but one.
  [[nodiscard]] LawFit fit(const std::vector<Friction>& laws, std::size_t without = none);

  // Squared error of each joint in each stretch of time that was left out of the fit, (n × folds).
  [[nodiscard]] Matrix unseen_errors(const std::vector<Friction>& laws);

  // Of rows that belong to no fit, which have the fold `folds`, by some unknowns, (n).
  [[nodiscard]] Vector validation_errors(const Vector& theta) const;

  // Squared torques of each joint in each stretch of time, those of no fit last, (n × folds + 1).
  [[nodiscard]] Matrix torques() const;

  // Deviation of each joint's Fl, (n), as if rows were independent; infinite where the law has none.
  [[nodiscard]] Vector load_sigma(const LawFit& of) const;

  // Values of unknowns as base parameters of the robot with some laws.
  [[nodiscard]] Vector values(const Vector& theta, const BaseParameters& from,
                              const BaseParameters& to) const;

  // Covariance of values() of a fit, as if rows were independent; zero where they say nothing.
  [[nodiscard]] Matrix covariance(const LawFit& of, const BaseParameters& from,
                                  const BaseParameters& to) const;

 private:
  // One where a law has the unknown, zero elsewhere.
  [[nodiscard]] Vector unknowns(const std::vector<Friction>& laws) const;

  // Gives the friction of all rows the sign of their load by some unknowns; the part of the rows where it
  // changes.
  double turn(const Vector& theta, const Vector& wanted);

  // A step of Gauss-Newton, with weights by the residuals before it but in the first one.
  void step(std::span<const JointSums> sums, const Vector& wanted, LawFit& fit) const;

  [[nodiscard]] Vector residual(const StretchRows& s, const Vector& theta) const;

  void add_errors(std::size_t fold, const Vector& theta, Eigen::Ref<Vector> out) const;

  Index b_;
  Index n_;
  std::vector<StretchRows> stretches_;
  std::size_t folds_;
  std::vector<std::vector<Index>> columns_;  // of each joint
  std::vector<JointSums> all_;               // rows of each joint
  std::vector<Index> root_at_;
};

}  // namespace rivid::detail
