#include "identify/choose/friction_fits.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "dense.hpp"
#include "identify/choose/load_passes.hpp"
#include "ranges.hpp"
#include "rivid/regressor/load.hpp"

namespace rivid::detail {

namespace {

// Steps of Gauss-Newton end when no weight of a joint changes by more than this part and the loads of no more
// than this part of the rows turn; a choice well below the gain that a law is chosen by. Logs that determine
// the arm take 5 to 8; those of the KUKA, which do not, up to all.
constexpr int most_steps = 20;
constexpr double settled_weights = 0.01;
constexpr double settled_rows = 1e-3;
// Singular values of scaled columns below this part of the largest belong to parameters that the rows do not
// show; its square stands well above the rounding of normal equations.
constexpr double not_seen = 3e-6;
// part of the squared torques of a joint below which squares of residuals are rounding of sums
constexpr double rounding = 1e-14;

// 1/√ of the diagonal, zero where that is.
Vector scale_of(const Matrix& A) {
  return A.diagonal().unaryExpr([](double x) { return x > 0.0 ? 1.0 / std::sqrt(x) : 0.0; });
}

// A of columns of norm 1. What the rows show less than `not_seen` of stays where it is.
Eigen::LLT<Matrix> damped(const Matrix& A, const Vector& scale) {
  Matrix scaled = scale.asDiagonal() * A * scale.asDiagonal();
  scaled.diagonal().array() += not_seen * not_seen;
  return scaled.llt();
}

}  // namespace

FrictionFits::FrictionFits(const Robot& robot, const BaseParameters& base, std::vector<StretchRows> stretches,
                           std::size_t folds)
    : b_(base.size()), n_(robot.size()), stretches_(std::move(stretches)), folds_(folds) {
  const std::vector<StandardParameter> columns = base.columns();
  root_at_.assign(robot.joints.size(), -1);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (about(columns[c].kind).basis == Basis::root) {
      root_at_[static_cast<std::size_t>(columns[c].joint)] = static_cast<Index>(c);
    }
  }
  columns_.resize(robot.joints.size());
  all_.resize(robot.joints.size());
  for (StretchRows& s : stretches_) {
    if (s.fold >= folds_) {
      continue;
    }
    columns_[s.joint] = s.columns;
    s.turned = Vector::Zero(s.sign.size());
    const Matrix L = s.sign.asDiagonal() * s.rigid;
    s.sums = {.WW = s.W.transpose() * s.W,
              .Wy = s.W.transpose() * s.y,
              .WL = Matrix::Zero(L.cols(), L.cols()),
              .LL = L.transpose() * L,
              .Ly = Vector::Zero(L.cols()),
              .yy = s.y.squaredNorm(),
              .rows = s.y.size()};
    if (JointSums& joint = all_[s.joint]; joint.rows == 0) {
      joint = s.sums;
    } else {
      joint.add(s.sums, 1.0);
    }
  }
}

LawFit FrictionFits::fit(const std::vector<Friction>& laws, std::size_t without) {
  LawFit out{.theta = Vector::Zero(b_ + n_), .weights = Vector::Ones(n_), .A = {}};
  const Vector wanted = unknowns(laws);
  for (int k = 0; k < most_steps; ++k) {
    const double turned = k > 0 ? turn(out.theta, wanted) : 1.0;
    std::vector<JointSums> sums = all_;
    for (const StretchRows& s : stretches_) {
      if (s.fold == without) {
        sums[s.joint].add(s.sums, -1.0);
      }
    }
    const Vector before = out.weights;
    step(sums, wanted, out);
    if (turned <= settled_rows && out.weights.cwiseQuotient(before).isOnes(settled_weights)) {
      break;
    }
  }
  return out;
}

Matrix FrictionFits::unseen_errors(const std::vector<Friction>& laws) {
  Matrix out = Matrix::Zero(n_, static_cast<Index>(folds_));
  for (std::size_t fold = 0; fold < folds_; ++fold) {
    add_errors(fold, fit(laws, fold).theta, out.col(static_cast<Index>(fold)));
  }
  return out;
}

Vector FrictionFits::validation_errors(const Vector& theta) const {
  Vector out = Vector::Zero(n_);
  add_errors(folds_, theta, out);
  return out;
}

Matrix FrictionFits::torques() const {
  Matrix out = Matrix::Zero(n_, static_cast<Index>(folds_) + 1);
  for (const StretchRows& s : stretches_) {
    out(static_cast<Index>(s.joint), static_cast<Index>(s.fold)) += s.y.squaredNorm();
  }
  return out;
}

Vector FrictionFits::values(const Vector& theta, const BaseParameters& from, const BaseParameters& to) const {
  Vector out = carried_over(from, theta.head(b_), to);
  for (Index i = 0; i < to.size(); ++i) {
    const StandardParameter& p = to.parameters[static_cast<std::size_t>(i)].leading;
    if (about(p.kind).basis == Basis::load) {
      out[i] = theta[b_ + p.joint];
    }
  }
  return out;
}

Matrix FrictionFits::covariance(const LawFit& of, const BaseParameters& from,
                                const BaseParameters& to) const {
  const Vector scale = scale_of(of.A);
  const SymmetricEigen scaled = symmetric_eigen(scale.asDiagonal() * of.A * scale.asDiagonal());
  const double least = not_seen * not_seen * scaled.values.tail<1>()[0];
  Matrix out(to.size(), of.A.cols());
  for (Index c = 0; c < out.cols(); ++c) {
    const double size = scaled.values[c];
    const double deviation = size > least ? 1.0 / std::sqrt(size) : 0.0;
    out.col(c) = values(deviation * scale.cwiseProduct(scaled.vectors.col(c)), from, to);
  }
  return out * out.transpose();
}

Vector FrictionFits::load_sigma(const LawFit& of) const {
  const Index p = of.A.cols();
  const Matrix inverse = damped(of.A, scale_of(of.A)).solve(Matrix::Identity(p, p));
  return inverse.diagonal().cwiseQuotient(of.A.diagonal()).tail(n_).cwiseSqrt();
}

Vector FrictionFits::unknowns(const std::vector<Friction>& laws) const {
  Vector out = Vector::Ones(b_ + n_);
  for (std::size_t j = 0; j < laws.size(); ++j) {
    out[b_ + static_cast<Index>(j)] = has(laws[j], Basis::load) ? 1.0 : 0.0;
    if (root_at_[j] >= 0 && !has(laws[j], Basis::root)) {
      out[root_at_[j]] = 0.0;
    }
  }
  return out;
}

double FrictionFits::turn(const Vector& theta, const Vector& wanted) {
  double count = 0.0;
  double rows = 1.0;
  for (StretchRows& s : stretches_) {
    if (s.fold >= folds_ || wanted[b_ + static_cast<Index>(s.joint)] == 0.0) {
      continue;
    }
    const Vector load = s.rigid * theta(s.columns);
    const Vector turned = s.sign.cwiseProduct(load.unaryExpr([](double x) { return x < 0.0 ? -1.0 : 1.0; }));
    const std::vector<Index> changed =
        places_where(load.size(), [&](Index k) { return turned[k] != s.turned[k]; });
    const Vector change = (turned - s.turned)(changed);
    const Matrix L = change.asDiagonal() * s.rigid(changed, Eigen::all);
    const Matrix WL = s.W(changed, Eigen::all).transpose() * L;
    const Vector on_y = L.transpose() * s.y(changed);
    for (JointSums* const sums : {&s.sums, &all_[s.joint]}) {
      sums->WL += WL;
      sums->Ly += on_y;
    }
    s.turned = turned;
    count += static_cast<double>(changed.size());
    rows += static_cast<double>(load.size());
  }
  return count / rows;
}

void FrictionFits::step(std::span<const JointSums> sums, const Vector& wanted, LawFit& fit) const {
  const bool first = fit.A.size() == 0;
  fit.A = Matrix::Zero(wanted.size(), wanted.size());
  Vector slope = Vector::Zero(wanted.size());
  for (Index j = 0; j < n_; ++j) {
    const JointSums& joint = sums[static_cast<std::size_t>(j)];
    const std::vector<Index>& columns = columns_[static_cast<std::size_t>(j)];
    const Vector chi = fit.theta(columns);
    const Index f = b_ + j;
    const double Fl = fit.theta[f];
    Matrix SS = joint.WW;
    Vector of_y = joint.Wy;
    Vector by_load;  // LL χ
    Vector to_load;
    if (wanted[f] > 0.0) {
      by_load = joint.LL * chi;
      SS += Fl * (joint.WL + joint.WL.transpose()) + Fl * Fl * joint.LL;
      of_y += Fl * joint.Ly;
      to_load = joint.WL * chi;
      to_load += Fl * by_load;
    }
    const Vector left = of_y - SS * chi;
    const double squares = std::max(joint.yy - chi.dot(of_y + left), rounding * joint.yy);
    if (!first && squares > 0.0) {
      fit.weights[j] = std::sqrt(static_cast<double>(joint.rows) / squares);
    }
    const double weight = fit.weights[j] * fit.weights[j];
    fit.A(columns, columns) += weight * SS;
    slope(columns) += weight * left;
    if (wanted[f] > 0.0) {
      fit.A(columns, f) = weight * to_load;
      fit.A(f, columns) = weight * to_load.transpose();
      fit.A(f, f) = weight * chi.dot(by_load);
      slope[f] = weight * (chi.dot(joint.Ly) - chi.dot(to_load));
    }
  }
  fit.A = (wanted.asDiagonal() * fit.A * wanted.asDiagonal()).eval();
  const Vector scale = scale_of(fit.A);
  fit.theta += scale.cwiseProduct(damped(fit.A, scale).solve(scale.cwiseProduct(slope)));
}

Vector FrictionFits::residual(const StretchRows& s, const Vector& theta) const {
  const Vector own = theta(s.columns);
  Vector out = s.y - s.W * own;
  if (s.sign.size() > 0) {
    out -= theta[b_ + static_cast<Index>(s.joint)] * s.sign.cwiseProduct((s.rigid * own).cwiseAbs());
  }
  return out;
}

void FrictionFits::add_errors(std::size_t fold, const Vector& theta, Eigen::Ref<Vector> out) const {
  for (const StretchRows& s : stretches_) {
    if (s.fold == fold) {
      out[static_cast<Index>(s.joint)] += residual(s, theta).squaredNorm();
    }
  }
}

}  // namespace rivid::detail
