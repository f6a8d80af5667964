#include "excite/curve.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace rivid::detail {

namespace {

// Columns that span what is orthogonal to w, (L × L − 1): those of the Householder reflection that turns w
// into the first axis.
Matrix orthogonal_to(const Vector& w) {
  const Index L = w.size();
  Vector v = w;
  v[0] += (w[0] < 0.0 ? -1.0 : 1.0) * w.norm();
  const Matrix H = Matrix::Identity(L, L) - 2.0 / v.squaredNorm() * v * v.transpose();
  return H.rightCols(L - 1);
}

// B-splines of one degree less over the widths that they have.
Matrix over_widths(Matrix lower, const Vector& knots, Index degree) {
  for (Index i = 0; i < lower.cols(); ++i) {
    const double width = knots[i + degree] - knots[i];
    lower.col(i) *= width > 0.0 ? 1.0 / width : 0.0;
  }
  return lower;
}

// B-splines of a degree from those of one less, (instants × count + 1).
Matrix b_splines(const Matrix& lower, const Vector& knots, Index degree, const Vector& t) {
  const Matrix parts = over_widths(lower, knots, degree);
  Matrix out(t.size(), parts.cols() - 1);
  for (Index i = 0; i < out.cols(); ++i) {
    out.col(i) = (t.array() - knots[i]) * parts.col(i).array() +
                 (knots[i + degree + 1] - t.array()) * parts.col(i + 1).array();
  }
  return out;
}

// Derivatives of the B-splines of a degree from those of one less, or their derivatives.
Matrix b_spline_slopes(const Matrix& lower, const Vector& knots, Index degree) {
  const Matrix parts = over_widths(lower, knots, degree);
  const Index count = parts.cols() - 1;
  return static_cast<double>(degree) * (parts.leftCols(count) - parts.rightCols(count));
}

// Half a wave takes two intervals.
double frequency_of(Index intervals, double duration) {
  return 0.5 * std::numbers::pi * static_cast<double>(intervals) / duration;
}

// jerk is continuous from degree 4 on, with 5 its rate is, too
constexpr Index spline_degree = 5;
// Coefficients of an end that rests.
constexpr Index resting = 3;

}  // namespace

Curve::Curve(double duration, const MotionBounds& bounds, const Vector& start)
    : duration_(duration),
      fixed_(start.size() > 0),
      half_(0.5 * (bounds.upper - bounds.lower)),
      offset_(fixed_ ? start : 0.5 * (bounds.lower + bounds.upper)) {}

Matrix Curve::coefficients(const Vector& z) const {
  const Index m = per_joint();
  Matrix out(T_.front().rows(), joints());
  for (Index j = 0; j < joints(); ++j) {
    out.col(j) = T_[static_cast<std::size_t>(j)] * z.segment(j * m, m);
  }
  return out;
}

Motion Curve::motion(const FunctionTables& tables, const Matrix& coefficients) const {
  return {.q = (tables.position * coefficients).rowwise() + offset_.transpose(),
          .qd = tables.velocity * coefficients,
          .qdd = tables.acceleration * coefficients};
}

Vector Curve::at_rest(const Vector& pose) const {
  Vector z = Vector::Zero(variables());
  for (Index j = 0; !fixed_ && j < joints(); ++j) {
    z[j * per_joint()] = (pose[j] - offset_[j]) / half_[j];
  }
  return z;
}

FourierCurve::FourierCurve(double duration, int harmonics, const MotionBounds& bounds, const Vector& start)
    : Curve(duration, bounds, start), harmonics_(harmonics) {
  const Index L = harmonics;
  const double omega = 2.0 * std::numbers::pi / duration;
  const Index constants = fixed_ ? 0 : 1;
  for (Index j = 0; j < offset_.size(); ++j) {
    // Amplitudes of the velocity that the bounds leave to each harmonic.
    Vector scale(L);
    Vector order(L);
    for (Index l = 0; l < L; ++l) {
      order[l] = static_cast<double>(l + 1);
      const double w = omega * order[l];
      scale[l] = std::min({half_[j] * w, bounds.velocity[j], bounds.acceleration[j] / w});
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
      T(0, 0) = half_[j];
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

double FourierCurve::highest_frequency() const { return 2.0 * std::numbers::pi * harmonics_ / duration_; }

std::optional<FourierSeries> FourierCurve::series(const Vector& z) const {
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

SplineCurve::SplineCurve(double duration, int points, const MotionBounds& bounds, const Vector& start)
    : Curve(duration, bounds, start) {
  const Index functions = points + 2 * resting;
  const Index intervals = functions - spline_degree;
  knots_.setZero(functions + spline_degree + 1);
  knots_.segment(spline_degree, intervals + 1).setLinSpaced(intervals + 1, 0.0, duration);
  knots_.tail(spline_degree).setConstant(duration);
  const double w = frequency_of(intervals, duration);
  const Index constants = fixed_ ? 0 : 1;
  for (Index j = 0; j < offset_.size(); ++j) {
    Matrix T = Matrix::Zero(functions, constants + points);
    T.leftCols(constants).setConstant(half_[j]);
    const double scale = std::min({half_[j], bounds.velocity[j] / w, bounds.acceleration[j] / (w * w)});
    T.block(resting, constants, points, points).diagonal().setConstant(scale);
    T_.push_back(std::move(T));
  }
}

double SplineCurve::highest_frequency() const {
  return frequency_of(knots_.size() - 2 * spline_degree - 1, duration_);
}

FunctionTables SplineCurve::tables(const Vector& t) const {
  // Of degree 0: 1 in the interval of the instant, the last of which is closed.
  const Index last = knots_.size() - spline_degree - 2;
  Matrix lower = Matrix::Zero(t.size(), knots_.size() - 1);
  for (Index k = 0; k < t.size(); ++k) {
    Index i = spline_degree;
    while (i < last && t[k] >= knots_[i + 1]) {
      ++i;
    }
    lower(k, i) = 1.0;
  }
  FunctionTables out;
  for (Index degree = 1; degree <= spline_degree; ++degree) {
    // The d-th derivative of the last ones takes d of these steps.
    for (const auto& [slope, order] :
         {std::pair(&out.velocity, 1), std::pair(&out.acceleration, 2), std::pair(&out.jerk, 3)}) {
      if (degree > spline_degree - order) {
        *slope = b_spline_slopes(slope->size() > 0 ? *slope : lower, knots_, degree);
      }
    }
    lower = b_splines(lower, knots_, degree, t);
  }
  out.position = std::move(lower);
  return out;
}

std::unique_ptr<Curve> curve_of(const ExcitationOptions& options, const MotionBounds& bounds) {
  if (options.curve == CurveKind::spline) {
    return std::make_unique<SplineCurve>(options.duration, options.points, bounds, options.start);
  }
  return std::make_unique<FourierCurve>(options.duration, options.harmonics, bounds, options.start);
}

}  // namespace rivid::detail
