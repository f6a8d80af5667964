#pragma once

#include <vector>

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

/// A family of Fourier series that begin and end at rest, q̇ = q̈ = 0: their coefficients are those of FourierSeries, of
/// which the null space of the two conditions is left,
///
///   q_j(t) = offset_j + φ(t)ᵀ T_j z_j
///
/// with the functions φ = 1, sin(l ω t) / (l ω), −cos(l ω t) / (l ω). Variables are scaled so that within the bounds all are
/// about one.
class FourierCurve {
 public:
  /// @param duration   one period [s]
  /// @param start      position at both ends, (n), or empty: it is free
  FourierCurve(double duration, int harmonics, const MotionBounds& bounds, const Vector& start);

  [[nodiscard]] Index joints() const { return offset_.size(); }
  [[nodiscard]] Index variables() const { return joints() * per_joint(); }
  [[nodiscard]] Index per_joint() const { return T_.front().cols(); }
  [[nodiscard]] double duration() const { return duration_; }
  /// Whether the position at both ends is given.
  [[nodiscard]] bool starts_fixed() const { return fixed_; }

  [[nodiscard]] FunctionTables tables(const Vector& t) const;

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

  /// The motion as files say it.
  [[nodiscard]] FourierSeries series(const Vector& z) const;

 private:
  double duration_;
  int harmonics_;
  bool fixed_;
  Vector offset_;          // (n)
  std::vector<Matrix> T_;  // one a joint, (functions × variables)
};

}  // namespace rivid::detail
