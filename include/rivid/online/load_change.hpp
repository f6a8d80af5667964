#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "rivid/online/row_noise.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Whether prediction errors look like another load: u = lᵀ δ + e, e with unit variance, δ the change of first moments and mass. Sums
// with exponentially fading weights g^age: a = Σ g^age l u has the covariance B = Σ g^(2 age) l lᵀ while nothing has changed, so aᵀ B⁻¹ a
// is χ² with four degrees of freedom. On a real arm it is larger, by errors of the model that look like a load; it is measured by its own mean of
// late.
class LoadChange {
 public:
  struct Options {
    double per_second = 40.0;  // steps
    double hours_to_false_alarm = 10.0;
    double mass = 10.0;   // that a change may have [kg]
    double length = 0.2;  // and its distance from the last link's origin [m]
  };

  explicit LoadChange(const Options& options) {
    const double steps = 3600.0 * options.hours_to_false_alarm * options.per_second;
    const double p = 1.0 / (steps * static_cast<double>(memories));
    // P(χ²₄ > x) = e^(−x/2) (1 + x/2), by fixed-point iteration.
    double x = 40.0;
    for (int k = 0; k < 60; ++k) {
      x = 2.0 * (std::log1p(0.5 * x) - std::log(p));
    }
    threshold_ = x;
    mean_share_ = 1.0 / (mean_seconds * options.per_second);
    for (std::size_t m = 0; m < memories; ++m) {
      fade_[m] = std::exp(-1.0 / std::max(seconds[m] * options.per_second, 0.5));
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const double scale = k < 3 ? options.mass * options.length : options.mass;
      known_[k] = 1.0 / (scale * scale);
    }
  }

  // A row of joint j: l and u, both over the deviation of the prediction by the long-run noise. A short memory has a shorter run.
  void take(const std::array<double, 4>& l, double u, const RowNoise& noise, std::size_t j) noexcept {
    for (std::size_t m = 0; m < memories; ++m) {
      Sums& s = state_.sums[m];
      const double weight = 1.0 / noise.short_run(j, fade_[m]);
      for (std::size_t i = 0; i < 4; ++i) {
        s.a[i] += weight * l[i] * u;
        for (std::size_t k = 0; k <= i; ++k) {
          s.B[i][k] += weight * l[i] * l[k];
        }
      }
    }
  }

  // One step of time: the test, then the past fades.
  void step() noexcept {
    state_.suspicion = 0.0;
    for (std::size_t m = 0; m < memories; ++m) {
      Sums& s = state_.sums[m];
      const double test = quadratic(s.B, s.a);
      const double excess = std::max(s.mean / degrees, 1.0);
      if (test / (threshold_ * excess) > state_.suspicion) {
        state_.suspicion = test / (threshold_ * excess);
      }
      // A change is no measure of what is usual.
      s.mean += mean_share_ * (std::min(test, 0.5 * threshold_ * excess) - s.mean);
      if (state_.suspicion > 1.0) {
        continue;
      }
      for (std::size_t i = 0; i < 4; ++i) {
        s.a[i] *= fade_[m];
        for (std::size_t k = 0; k <= i; ++k) {
          s.B[i][k] *= fade_[m] * fade_[m];
        }
      }
    }
  }

  [[nodiscard]] bool found() const noexcept { return state_.suspicion > 1.0; }
  [[nodiscard]] bool quiet() const noexcept { return state_.suspicion < 0.5; }
  [[nodiscard]] double suspicion() const noexcept { return state_.suspicion; }

  // Begins anew; what is usual of the test stays.
  void reset() noexcept {
    State next;
    for (std::size_t m = 0; m < memories; ++m) {
      next.sums[m].mean = state_.sums[m].mean;
    }
    state_ = next;
  }

  template <typename Visit>
  void visit_state(Visit& visit) noexcept {
    auto& [threshold, mean_share, fade, known, state] = *this;
    visit_parts(visit, state);
  }

 private:
  using Triangle = std::array<std::array<double, 4>, 4>;
  static constexpr double degrees = 4.0;
  static constexpr double mean_seconds = 10.0;  // over which the mean of the test is taken
  struct Sums {
    std::array<double, 4> a{};
    Triangle B{};
    double mean = 2.0 * degrees;  // of the test of late
  };

  static constexpr std::size_t memories = 3;
  static constexpr std::array<double, memories> seconds = {0.04, 0.15, 0.5};
  struct State {
    std::array<Sums, memories> sums{};
    double suspicion = 0.0;
  };

  [[nodiscard]] Triangle factor(const Triangle& A) const noexcept {
    Triangle L{};
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t i = j; i < 4; ++i) {
        double sum = A[i][j] + (i == j ? known_[i] : 0.0);
        for (std::size_t k = 0; k < j; ++k) {
          sum -= L[i][k] * L[j][k];
        }
        L[i][j] = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / L[j][j];
      }
    }
    return L;
  }
  [[nodiscard]] double quadratic(const Triangle& B, const std::array<double, 4>& a) const noexcept {
    const Triangle L = factor(B);
    std::array<double, 4> x = a;
    double out = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        x[i] -= L[i][k] * x[k];
      }
      x[i] /= L[i][i];
      out += x[i] * x[i];
    }
    return out;
  }

  double threshold_ = 0.0;
  double mean_share_ = 0.0;
  std::array<double, memories> fade_{};
  std::array<double, 4> known_{};
  State state_;
};

// Inertia tensor nearest to I, in its second moments, that some body has: Σ = ½ tr(I) 1 − I without its negative eigenvalues.
template <typename Scalar>
[[nodiscard]] Eigen::Matrix3<Scalar> nearest_inertia(const Eigen::Matrix3<Scalar>& I) noexcept {
  using std::abs;
  using std::sqrt;
  using M = Eigen::Matrix3<Scalar>;
  M S = -I;
  for (Index k = 0; k < 3; ++k) {
    S(k, k) += Scalar(0.5) * (I(0, 0) + I(1, 1) + I(2, 2));
  }
  M V = M::Identity();
  // Jacobi's rotations: for three by three they settle in a few sweeps.
  for (int sweep = 0; sweep < 8; ++sweep) {
    for (Index p = 0; p < 2; ++p) {
      for (Index q = p + 1; q < 3; ++q) {
        if (S(p, q) == Scalar(0)) {
          continue;
        }
        const Scalar theta = (S(q, q) - S(p, p)) / (Scalar(2) * S(p, q));
        const Scalar t =
            (theta < Scalar(0) ? Scalar(-1) : Scalar(1)) / (abs(theta) + sqrt(theta * theta + Scalar(1)));
        const Scalar c = Scalar(1) / sqrt(t * t + Scalar(1));
        const Scalar s = t * c;
        for (Index k = 0; k < 3; ++k) {
          const Scalar a = S(k, p);
          S(k, p) = c * a - s * S(k, q);
          S(k, q) = s * a + c * S(k, q);
          const Scalar v = V(k, p);
          V(k, p) = c * v - s * V(k, q);
          V(k, q) = s * v + c * V(k, q);
        }
        for (Index k = 0; k < 3; ++k) {
          const Scalar a = S(p, k);
          S(p, k) = c * a - s * S(q, k);
          S(q, k) = s * a + c * S(q, k);
        }
      }
    }
  }
  M out = M::Zero();
  Scalar trace(0);
  for (Index k = 0; k < 3; ++k) {
    const Scalar moment = std::max(S(k, k), Scalar(0));
    trace += moment;
    for (Index i = 0; i < 3; ++i) {
      for (Index j = 0; j < 3; ++j) {
        out(i, j) -= moment * V(i, k) * V(j, k);
      }
    }
  }
  for (Index k = 0; k < 3; ++k) {
    out(k, k) += trace;
  }
  return out;
}

}  // namespace rivid::detail
