#include "dense.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>

namespace rivid::detail {

Svd svd(const Matrix& A, int options) {
  const Eigen::BDCSVD<Matrix> found(A, static_cast<unsigned>(options));
  Svd out{.U = {}, .values = found.singularValues(), .V = {}};
  if (found.computeU()) {
    out.U = found.matrixU();
  }
  if (found.computeV()) {
    out.V = found.matrixV();
  }
  return out;
}

Vector singular_values(const Matrix& A) { return svd(A, 0).values; }

SymmetricEigen symmetric_eigen(const Matrix& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix> found(A);
  return {.values = found.eigenvalues(), .vectors = found.eigenvectors()};
}

bool is_positive_semidefinite(const Matrix& A) {
  if (A.rows() != A.cols() || !A.allFinite()) {
    return false;
  }
  constexpr double rounding = 1e-9;  // relative; above the rounding of a covariance, below any fault of one
  const Vector root = A.diagonal().cwiseMax(0.0).cwiseSqrt();
  Matrix correlation = A;
  for (Index i = 0; i < A.rows(); ++i) {
    for (Index j = 0; j < A.cols(); ++j) {
      const double most = root[i] * root[j];
      if (A(i, i) < 0.0 || std::abs(A(i, j)) > (1.0 + rounding) * most ||
          std::abs(A(i, j) - A(j, i)) > rounding * most) {
        return false;
      }
      correlation(i, j) = most > 0.0 ? A(i, j) / most : 0.0;
    }
  }
  return A.size() == 0 || symmetric_eigenvalues(correlation).minCoeff() >= -rounding;
}

Vector symmetric_eigenvalues(const Matrix& A) {
  return Eigen::SelfAdjointEigenSolver<Matrix>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

Matrix inverse(const Matrix& A) { return A.inverse(); }

Matrix solve(const Matrix& A, const Matrix& B) { return A.partialPivLu().solve(B); }

Matrix least_squares_solution(const Matrix& A, const Matrix& B) {
  return Eigen::HouseholderQR<Matrix>(A).solve(B);
}

Vector minimum_norm_solution(const Matrix& A, const Vector& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<Matrix> solver;
  solver.setThreshold(threshold);
  solver.compute(A);
  return solver.solve(b);
}

Matrix triangular_factor(Matrix& A) {
  const Eigen::HouseholderQR<Eigen::Ref<Matrix>> qr(A);
  return qr.matrixQR().topRows(A.cols()).triangularView<Eigen::Upper>();
}

ThinQr thin_qr(const Matrix& A) {
  const Eigen::HouseholderQR<Matrix> qr(A);
  return {.Q = qr.householderQ() * Matrix::Identity(A.rows(), A.cols()),
          .R = qr.matrixQR().topRows(A.cols()).triangularView<Eigen::Upper>()};
}

struct PivotedQr::Factors {
  Eigen::ColPivHouseholderQR<Matrix> qr;
};

PivotedQr::PivotedQr(const Matrix& A, double threshold) {
  auto factors = std::make_unique<Factors>(Factors{Eigen::ColPivHouseholderQR<Matrix>(A)});
  factors->qr.setThreshold(threshold);
  factors_ = std::move(factors);
}

PivotedQr::~PivotedQr() = default;

Index PivotedQr::rank() const { return factors_->qr.rank(); }

double PivotedQr::last_pivot() const {
  const Matrix& R = factors_->qr.matrixR();
  return std::abs(R(R.rows() - 1, R.cols() - 1));
}

Matrix PivotedQr::solve(const Matrix& B) const { return factors_->qr.solve(B); }

Vector PivotedQr::rotated(Vector y) const {
  y.applyOnTheLeft(factors_->qr.householderQ().adjoint());
  return y;
}

}  // namespace rivid::detail
