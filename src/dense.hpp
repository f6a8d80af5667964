#pragma once

#include <memory>

#include "rivid/types.hpp"

// The dense factorisations of Eigen that take long to compile, compiled once for all modules. Results are
// Eigen's, bit by bit.
namespace rivid::detail {

/// A = U diag(values) Vᵀ, singular values in descending order.
struct Svd {
  Matrix U;
  Vector values;
  Matrix V;
};
/// @param options  Eigen::ComputeThinU, ComputeFullV …; what is not asked for stays empty
[[nodiscard]] Svd svd(const Matrix& A, int options);
[[nodiscard]] Vector singular_values(const Matrix& A);

/// Of a symmetric matrix, eigenvalues in ascending order.
struct SymmetricEigen {
  Vector values;
  Matrix vectors;
};
[[nodiscard]] SymmetricEigen symmetric_eigen(const Matrix& A);
[[nodiscard]] Vector symmetric_eigenvalues(const Matrix& A);

/// Whether A can be a covariance or an information: square, finite, symmetric, without a negative eigenvalue,
/// but for rounding.
[[nodiscard]] bool is_positive_semidefinite(const Matrix& A);

/// A⁻¹ and A⁻¹ B by partial pivoting.
[[nodiscard]] Matrix inverse(const Matrix& A);
[[nodiscard]] Matrix solve(const Matrix& A, const Matrix& B);

/// argmin ‖A X − B‖ by Householder reflections, for A of full rank.
[[nodiscard]] Matrix least_squares_solution(const Matrix& A, const Matrix& B);

/// The solution of least norm; a pivot below `threshold` times the largest is zero.
[[nodiscard]] Vector minimum_norm_solution(const Matrix& A, const Vector& b, double threshold);

/// R of A = Q R, with zeros below its diagonal; A is overwritten.
[[nodiscard]] Matrix triangular_factor(Matrix& A);

struct ThinQr {
  Matrix Q;
  Matrix R;
};
/// A = Q R with as many columns in Q as in A.
[[nodiscard]] ThinQr thin_qr(const Matrix& A);

/// Householder factorisation of a square matrix with column pivoting.
class PivotedQr {
 public:
  /// @param threshold  a pivot below `threshold` times the largest counts as zero
  PivotedQr(const Matrix& A, double threshold);
  ~PivotedQr();
  PivotedQr(const PivotedQr&) = delete;
  PivotedQr& operator=(const PivotedQr&) = delete;

  [[nodiscard]] Index rank() const;
  [[nodiscard]] double last_pivot() const;
  [[nodiscard]] Matrix solve(const Matrix& B) const;
  /// Qᵀ y.
  [[nodiscard]] Vector rotated(Vector y) const;

 private:
  struct Factors;
  std::unique_ptr<const Factors> factors_;
};

}  // namespace rivid::detail
