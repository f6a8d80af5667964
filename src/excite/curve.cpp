#include "excite/curve.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rivid::detail {

namespace {

// Columns that span what is orthogonal to w, (L × L − 1): those of the Householder reflection that turns w into the first
// axis.
Matrix orthogonal_to(const Vector& w) {
  const Index L = w.size();
  Vector v = w;
  v[0] += (w[0] < 0.0 ? -1.0 : 1.0) * w.norm();
  const Matrix H = Matrix::Identity(L, L) - 2.0 / v.squaredNorm() * v * v.transpose();
  return H.rightCols(L - 1);
}

}  // namespace

FourierCurve::FourierCurve(double duration, int harmonics, const MotionBounds& bounds, const Vector& start)
    : duration_(duration),
      harmonics_(harmonics),
      fixed_(start.size() > 0),
      offset_(fixed_ ? start : 0.5 * (bounds.lower + bounds.upper)) {
  const Index L = harmonics;
  const double omega = 2.0 * std::numbers::pi / duration;
  const Index constants = fixed_ ? 0 : 1;
  for (Index j = 0; j < offset_.size(); ++j) {
    const double half = 0.5 * (bounds.upper[j] - bounds.lower[j]);
    // Amplitudes of the velocity that the bounds leave to each harmonic.
    Vector scale(L);
    Vector order(L);
    for (Index l = 0; l < L; ++l) {
      order[l] = static_cast<double>(l + 1);
      const double w = omega * order[l];
      scale[l] = std::min({half * w, bounds.velocity[j], bounds.acceleration[j] / w});
    }
    // Σ A_l = 0 is rest, Σ l B_l = 0 its continuation.
    const Matrix A = scale.asDiagonal() * orthogonal_to(scale);
    const Matrix B = scale.asDiagonal() * orthogonal_to(scale.cwiseProduct(order));
    Matrix T = Matrix::Zero(1 + 2 * L, constants + 2 * (L - 1));
    T.block(1, constants, L, L - 1) = A;
    T.block(1 + L, constants + L - 1, L, L - 1) = B;
    if (fixed_) {
      // q(0) = q0 − Σ B_l / (l ω) stays where it is.
      T.row(0).tail(L - 1) = (order * omega).cwiseInverse().transpose() * B;
    } else {
      T(0, 0) = half;
    }
    T_.push_back(std::move(T));
  }
}

FunctionTables FourierCurve::tables(const Vector& t) const {
  const Index L = harmonics_;
  const double omega = 2.0 * std::numbers::pi / duration_;
  FunctionTables out;
  for (Matrix* const table : {&out.position, &out.velocity, &out.acceleration, &out.jerk}) {
    table->setZero(t.size(), 1 + 2 * L);
  }
  out.position.col(0).setOnes();
  for (Index l = 0; l < L; ++l) {
    const double w = omega * static_cast<double>(l + 1);
    const Vector c = (w * t).array().cos();
    const Vector s = (w * t).array().sin();
    out.position.col(1 + l) = s / w;
    out.velocity.col(1 + l) = c;
    out.acceleration.col(1 + l) = -w * s;
    out.jerk.col(1 + l) = -w * w * c;
    out.position.col(1 + L + l) = -c / w;
    out.velocity.col(1 + L + l) = s;
    out.acceleration.col(1 + L + l) = w * c;
    out.jerk.col(1 + L + l) = -w * w * s;
  }
  return out;
}

Matrix FourierCurve::coefficients(const Vector& z) const {
  const Index m = per_joint();
  Matrix out(T_.front().rows(), joints());
  for (Index j = 0; j < joints(); ++j) {
    out.col(j) = T_[static_cast<std::size_t>(j)] * z.segment(j * m, m);
  }
  return out;
}

Motion FourierCurve::motion(const FunctionTables& tables, const Matrix& coefficients) const {
  return {.q = (tables.position * coefficients).rowwise() + offset_.transpose(),
          .qd = tables.velocity * coefficients,
          .qdd = tables.acceleration * coefficients};
}

Vector FourierCurve::at_rest(const Vector& pose) const {
  Vector z = Vector::Zero(variables());
  if (!fixed_) {
    for (Index j = 0; j < joints(); ++j) {
      z[j * per_joint()] = (pose[j] - offset_[j]) / T_[static_cast<std::size_t>(j)](0, 0);
    }
  }
  return z;
}

FourierSeries FourierCurve::series(const Vector& z) const {
  const Matrix c = coefficients(z);
  const Index L = harmonics_;
  FourierSeries out;
  out.omega_f = 2.0 * std::numbers::pi / duration_;
  out.q0 = offset_ + c.row(0).transpose();
  out.A = c.middleRows(1, L).transpose();
  out.B = c.bottomRows(L).transpose();
  out.duration = duration_;
  return out;
}

}  // namespace rivid::detail
