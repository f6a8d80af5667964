#include "identify/physical/barrier.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "rivid/model/parameters.hpp"

namespace rivid::detail {

namespace {

using Moments = Eigen::Matrix<double, 10, 1>;

// By how much the weight of the barrier falls at a time.
constexpr double reduction = 0.03;
// Squared Newton decrement, in units of the barrier, below which a point counts as the centre for its weight.
constexpr double centred = 0.05;
// Newton steps for one weight, after which roundings must be in the way.
constexpr int most_steps_for_a_weight = 200;
// Part of the way to the boundary that a step may go.
constexpr double most_of_the_way = 0.98;

Moments svec(const Eigen::Matrix4d& S) {
  // weighs pairs of entries, so that the product of two vectors is the trace of that of the matrices
  constexpr double r = std::numbers::sqrt2;
  Moments v;
  v << S(0, 0), S(1, 1), S(2, 2), S(3, 3), r * S(1, 0), r * S(2, 0), r * S(3, 0), r * S(2, 1), r * S(3, 1),
      r * S(3, 2);
  return v;
}

Eigen::Matrix4d smat(const Moments& v) {
  constexpr double r = 1.0 / std::numbers::sqrt2;  // undoes that of svec()
  Eigen::Matrix4d S;
  S << v[0], r * v[4], r * v[5], r * v[6],  //
      r * v[4], v[1], r * v[7], r * v[8],   //
      r * v[5], r * v[7], v[2], r * v[9],   //
      r * v[6], r * v[8], r * v[9], v[3];
  return S;
}

// The function along a step: a parabola and logarithms, slope + curvature t − Σ weight e / (1 + t e).
struct AlongStep {
  double slope = 0.0;
  double curvature = 0.0;
  std::vector<std::pair<double, double>> logarithms;  // weight, e

  [[nodiscard]] double derivative(double t) const {
    double out = slope + curvature * t;
    for (const auto& [weight, e] : logarithms) {
      out -= weight * e / (1.0 + t * e);
    }
    return out;
  }
  // Where the first logarithm ends.
  [[nodiscard]] double boundary() const {
    double least = 0.0;
    for (const auto& [weight, e] : logarithms) {
      least = std::min(least, e);
    }
    return least < 0.0 ? -1.0 / least : std::numeric_limits<double>::infinity();
  }
  // Its minimum to a few digits, by bisection; the full Newton step where that is as good.
  [[nodiscard]] double minimum() const {
    // part of the first slope that the full step may leave; a choice: less takes more bisections
    constexpr double flat = 0.1;
    constexpr double digits = 1e-3;   // relative; a choice: the next step begins anew anyhow
    constexpr double farthest = 1e3;  // Newton steps; any large value: it bounds a search to infinity
    const double end = most_of_the_way * boundary();
    if (1.0 < end && std::abs(derivative(1.0)) <= flat * std::abs(derivative(0.0))) {
      return 1.0;
    }
    double low = 0.0;
    double high = std::min(end, farthest);
    if (derivative(high) <= 0.0) {
      return high;
    }
    while (high - low > digits * high) {
      const double middle = 0.5 * (low + high);
      (derivative(middle) < 0.0 ? low : high) = middle;
    }
    return low > 0.0 ? low : high;
  }
};

// The problem with its barrier at one point.
class Newton {
 public:
  Newton(const BarrierProblem& problem, Vector x)
      : problem_(problem),
        x_(std::move(x)),
        quadratic_(problem.rows.transpose() * problem.rows),
        gradient_(x_.size()),
        step_(x_.size()) {}

  [[nodiscard]] const Vector& x() const { return x_; }

  // The Newton step for a weight of the barrier; the decrement squared, in units of the barrier.
  double aim(double weight) {
    weight_ = weight;
    residual_ = problem_.rows * x_ - problem_.target;
    gradient_ = problem_.rows.transpose() * residual_ + problem_.linear;
    hessian_ = quadratic_;
    bodies_.clear();
    const double of_bodies = problem_.log_weight + weight;
    for (const Index at : problem_.bodies) {
      bodies_.push_back(whitened_parameters(pseudo_inertia(x_.segment<inertial_count>(at))));
      const BodyMatrix& G = bodies_.back();
      gradient_.segment<inertial_count>(at) -= of_bodies * G.transpose() * identity_moments();
      hessian_.block<inertial_count, inertial_count>(at, at) += of_bodies * G.transpose() * G;
    }
    for (const LinearBound& bound : problem_.bounds) {
      const double slack = bound.slack(x_);
      for (const auto& [i, c_i] : bound.terms) {
        gradient_[i] -= weight * c_i / slack;
        for (const auto& [j, c_j] : bound.terms) {
          hessian_(i, j) += weight * (c_i / slack) * (c_j / slack);
        }
      }
    }
    solve();
    return -gradient_.dot(step_) / weight;
  }

  // Goes along the step, as far as the function falls.
  void go() {
    AlongStep line;
    const Vector change = problem_.rows * step_;
    line.slope = residual_.dot(change) + problem_.linear.dot(step_);
    line.curvature = change.squaredNorm();
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const Moments moments = bodies_[k] * step_.segment<inertial_count>(problem_.bodies[k]);
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(smat(moments), Eigen::EigenvaluesOnly);
      for (const double e : eigen.eigenvalues()) {
        line.logarithms.emplace_back(problem_.log_weight + weight_, e);
      }
    }
    for (const LinearBound& bound : problem_.bounds) {
      double change_of_slack = 0.0;
      for (const auto& [i, c] : bound.terms) {
        change_of_slack += c * step_[i];
      }
      line.logarithms.emplace_back(weight_, change_of_slack / bound.slack(x_));
    }
    double t = line.minimum();
    // Roundings must not lead outside.
    while (t > 0.0 && !problem_.inside(x_ + t * step_)) {
      t = t > std::numeric_limits<double>::epsilon() ? 0.5 * t : 0.0;
    }
    x_ += t * step_;
  }

 private:
  // step = −hessian⁻¹ gradient, with all diagonal entries of the Hessian brought to one. It has full rank, if
  // not always to rounding.
  void solve() {
    const Vector scale = hessian_.diagonal().cwiseSqrt().cwiseInverse();
    hessian_ = scale.asDiagonal() * hessian_ * scale.asDiagonal();
    const Vector rhs = -scale.cwiseProduct(gradient_);
    double raised = 0.0;
    for (;;) {
      factor_.compute(hessian_);
      // Numbers that overflowed can not be mended; the step is not a number then, and no step is made.
      constexpr double most = 1e3;
      if (factor_.info() == Eigen::Success || !(raised < most) || !hessian_.allFinite()) {
        break;
      }
      constexpr double first = 1e-14;  // times the diagonal of ones, 45 ε: the least that mends a rounding
      constexpr double faster = 10.0;  // each attempt; a choice: 18 reach the limit
      const double more = raised == 0.0 ? first : (faster - 1.0) * raised;
      hessian_.diagonal().array() += more;
      raised += more;
    }
    step_ = scale.cwiseProduct(factor_.solve(rhs));
  }

  const BarrierProblem& problem_;
  Vector x_;
  Matrix quadratic_;
  double weight_ = 0.0;
  Vector residual_;
  Vector gradient_;
  Matrix hessian_;
  std::vector<BodyMatrix> bodies_;
  Eigen::LLT<Matrix> factor_;
  Vector step_;
};

}  // namespace

BodyMatrix whitened_parameters(const Eigen::Matrix4d& P) {
  static const std::array<Eigen::Matrix4d, inertial_count> units = [] {
    std::array<Eigen::Matrix4d, inertial_count> out;
    for (Index i = 0; i < inertial_count; ++i) {
      out[static_cast<std::size_t>(i)] = pseudo_inertia(Inertial::Unit(i));
    }
    return out;
  }();
  const Eigen::Matrix4d L = P.llt().matrixL();
  const Eigen::Matrix4d inverse =
      L.triangularView<Eigen::Lower>().solve(Eigen::Matrix4d(Eigen::Matrix4d::Identity()));
  BodyMatrix G;
  for (Index i = 0; i < inertial_count; ++i) {
    G.col(i) = svec(inverse * units[static_cast<std::size_t>(i)] * inverse.transpose());
  }
  return G;
}

Moments identity_moments() { return svec(Eigen::Matrix4d::Identity()); }

double LinearBound::slack(const Vector& x) const {
  double out = -bound;
  for (const auto& [i, c] : terms) {
    out += c * x[i];
  }
  return out;
}

double BarrierProblem::complexity() const {
  return 4.0 * static_cast<double>(bodies.size()) + static_cast<double>(bounds.size());
}

double BarrierProblem::cost(const Vector& x) const {
  double out = 0.5 * (target - rows * x).squaredNorm() + linear.dot(x);
  if (log_weight > 0.0) {
    for (const Index at : bodies) {
      const Eigen::LLT<Eigen::Matrix4d> factor(pseudo_inertia(x.segment<inertial_count>(at)));
      out -= 2.0 * log_weight * factor.matrixLLT().diagonal().array().log().sum();
    }
  }
  return out;
}

bool BarrierProblem::inside(const Vector& x) const {
  return x.allFinite() &&
         std::ranges::all_of(
             bodies,
             [&](Index at) {
               const Eigen::LLT<Eigen::Matrix4d> factor(pseudo_inertia(x.segment<inertial_count>(at)));
               return factor.info() == Eigen::Success;
             }) &&
         std::ranges::all_of(bounds, [&](const LinearBound& bound) { return bound.slack(x) > 0.0; });
}

BarrierSolution minimise(const BarrierProblem& problem, const Vector& start, double offset, double tolerance,
                         int max_steps) {
  const double complexity = problem.complexity();
  const auto wanted_gap = [&](const Vector& x) { return tolerance * (1.0 + problem.cost(x) + offset); };
  Newton newton(problem, start);
  BarrierSolution out;
  double weight = (1.0 + problem.cost(start) + offset) / complexity;
  constexpr int most_weights = 300;  // more than the range of a double has of them
  for (int round = 0; round < most_weights; ++round) {
    double decrement = newton.aim(weight);
    for (int k = 0; decrement > centred && k < most_steps_for_a_weight && out.steps < max_steps; ++k) {
      newton.go();
      ++out.steps;
      decrement = newton.aim(weight);
    }
    // At the centre the gap is the weight times the complexity; what is left to the centre comes on top.
    out.gap = weight * (complexity + decrement);
    const double wanted = wanted_gap(newton.x());
    out.reached = out.gap <= wanted;
    if (out.reached || !(decrement <= centred)) {
      break;
    }
    weight = std::max(reduction * weight, 0.9 * wanted / complexity);
  }
  out.x = newton.x();
  return out;
}

}  // namespace rivid::detail
