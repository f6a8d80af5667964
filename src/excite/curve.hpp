#pragma once

#include <memory>
#include <vector>

#include "rivid/excite/excitation.hpp"
#include "rivid/excite/limits.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/types.hpp"

// Motions that are linear in their variables.
namespace rivid::detail {

/// Functions of time and their derivatives at some instants: one row an instant, one column a function.
struct FunctionTables {
  Matrix position;
  Matrix velocity;
  Matrix acceleration;
  Matrix jerk;
};

/// A family of motions that begin and end at rest, q̇ = q̈ = 0, in the same pose:
///
///   q_j(t) = offset_j + φ(t)ᵀ T_j z_j
///
/// with functions φ of time that all joints share. Variables are scaled so that within the bounds all are
/// about one; the first of a joint moves its whole motion, unless the pose at both ends is given.
class Curve {
 public:
  virtual ~Curve() = default;
  Curve(const Curve&) = delete;
  Curve& operator=(const Curve&) = delete;

  [[nodiscard]] Index joints() const { return offset_.size(); }
  [[nodiscard]] Index variables() const { return joints() * per_joint(); }
  [[nodiscard]] Index per_joint() const { return T_.front().cols(); }
  [[nodiscard]] double duration() const { return duration_; }
  /// Whether the position at both ends is given.
  [[nodiscard]] bool starts_fixed() const { return fixed_; }
  /// About the highest angular frequency of a motion [rad/s].
  [[nodiscard]] virtual double highest_frequency() const = 0;

  [[nodiscard]] virtual FunctionTables tables(const Vector& t) const = 0;
  /// The motion as files say it, where they have a word for it.
  [[nodiscard]] virtual std::optional<FourierSeries> series(const Vector& /*z*/) const {
    return std::nullopt;
  }

  /// T_j z_j for all joints, (functions × n).
  [[nodiscard]] Matrix coefficients(const Vector& z) const;
  /// Motion from the tables of some instants.
  [[nodiscard]] Motion motion(const FunctionTables& tables, const Matrix& coefficients) const;
  /// Jerks from these, (instants × n).
  [[nodiscard]] static Matrix jerk(const FunctionTables& tables, const Matrix& coefficients) {
    return tables.jerk * coefficients;
  }
  /// T_j of the chain rule: d/dz_j from d/d(coefficients of joint j).
  [[nodiscard]] Vector pulled_back(Index joint, const Vector& slope) const {
    return T_[static_cast<std::size_t>(joint)].transpose() * slope;
  }

  /// Variables of the motion that rests at a pose; of a fixed start at that one.
  [[nodiscard]] Vector at_rest(const Vector& pose) const;

 protected:
  /// @param start  position at both ends, (n), or empty: it is free
  Curve(double duration, const MotionBounds& bounds, const Vector& start);

  double duration_;
  bool fixed_;
  Vector half_;            // of the positions' range, (n)
  Vector offset_;          // (n)
  std::vector<Matrix> T_;  // one a joint, (functions × variables)
};

/// Fourier series: φ = 1, sin(l ω t) / (l ω), −cos(l ω t) / (l ω), of whose coefficients those of
/// FourierSeries, the null space of the conditions of rest is left. One period.
class FourierCurve : public Curve {
 public:
  FourierCurve(double duration, int harmonics, const MotionBounds& bounds, const Vector& start);

  [[nodiscard]] double highest_frequency() const override;
  [[nodiscard]] FunctionTables tables(const Vector& t) const override;
  [[nodiscard]] std::optional<FourierSeries> series(const Vector& z) const override;

 private:
  int harmonics_;
};

/// Splines of fifth degree with equal intervals: φ are the B-splines of De Boor, of which the first three
/// have the coefficient of the last three. The jerk is continuous.
class SplineCurve : public Curve {
 public:
  /// @param points  coefficients between those of the ends, at least 1
  SplineCurve(double duration, int points, const MotionBounds& bounds, const Vector& start);

  [[nodiscard]] double highest_frequency() const override;
  [[nodiscard]] FunctionTables tables(const Vector& t) const override;

 private:
  Vector knots_;
};

/// The kind that is asked for.
[[nodiscard]] std::unique_ptr<Curve> curve_of(const ExcitationOptions& options, const MotionBounds& bounds);

}  // namespace rivid::detail
