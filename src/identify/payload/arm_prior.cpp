#include "identify/payload/arm_prior.hpp"

#include <utility>

#include "dense.hpp"

namespace rivid::detail {

namespace {

// With exact gains.
Matrix covariance_of(const IdentifiedArm& arm) {
  return arm.gain_covariance.size() == 0
             ? arm.C_chi
             : Matrix(arm.C_chi - arm.gain_slopes * arm.gain_covariance * arm.gain_slopes.transpose());
}

// Inverse; directions of next to no variance count as known well.
Matrix information_of(const Matrix& C) {
  // Least eigenvalue of the correlations, relative to the largest.
  constexpr double least = 1e-12;
  const Vector scale = C.diagonal().cwiseSqrt().cwiseInverse();
  const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * C * scale.asDiagonal());
  const double floor = least * eigen.values[eigen.values.size() - 1];
  const Matrix inverse =
      eigen.vectors * eigen.values.cwiseMax(floor).cwiseInverse().asDiagonal() * eigen.vectors.transpose();
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

}  // namespace

ArmPrior::ArmPrior(const IdentifiedArm& arm, std::vector<Index> places, Index gains_at)
    : chi_(arm.chi),
      information_(information_of(covariance_of(arm))),
      slopes_(arm.gain_slopes),
      places_(std::move(places)),
      gains_at_(gains_at) {}

void ArmPrior::add_to(Known& known, const Vector& theta) const {
  Matrix J = Matrix::Zero(chi_.size(), theta.size());
  Vector rho = chi_ - theta(places_);
  for (Index i = 0; i < chi_.size(); ++i) {
    J(i, places_[static_cast<std::size_t>(i)]) = 1.0;
  }
  for (Index j = 0; gains_at_ >= 0 && j < slopes_.cols(); ++j) {
    const double r = theta[gains_at_ + j];
    J.col(gains_at_ + j) = slopes_.col(j) / (r * r);
    rho -= (1.0 - 1.0 / r) * slopes_.col(j);
  }
  const Matrix JtC = J.transpose() * information_;
  known.A += JtC * J;
  known.a += JtC * rho;
}

}  // namespace rivid::detail
