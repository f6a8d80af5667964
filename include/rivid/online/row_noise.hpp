#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "rivid/model/chain.hpp"
#include "rivid/online/saved_state.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Standard deviation that rows of a joint must be given so that sums of many of them err as they do: errors
// of neighbouring rows are alike, and count as independent ones with the long-run variance γ₀ + 2 Σ (1 − k /
// (lags + 1)) γ_k [Newey & West 1987]. The autocovariances follow the prediction errors. They begin with the
// deviation of the identification and with errors of a model, which last as long as a motion does.
class RowNoise {
 public:
  // step  time from one row to the next [s]
  RowNoise(const Vector& sigma, double step) : joints_(static_cast<std::size_t>(sigma.size())) {
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      State& s = joints_[j];
      s.begun_with = sigma[static_cast<Index>(j)];
      for (std::size_t k = 0; k <= lags; ++k) {
        s.covariance[k] = s.begun_with * s.begun_with * std::exp(-static_cast<double>(k) * step / alike_for);
      }
      s.sigma = std::sqrt(long_run(s));
    }
  }

  [[nodiscard]] double sigma(std::size_t j) const noexcept { return joints_[j].sigma; }

  // error  prediction error of a row of joint j, scaled to the variance of its noise [N·m | N]
  void take(std::size_t j, double error) noexcept {
    State& s = joints_[j];
    // A jump of the payload is no noise.
    const double limit = outlier * s.sigma;
    const double e = std::clamp(error, -limit, limit);
    s.outliers += ((e == error ? 0.0 : 1.0) - s.outliers) / short_memory;
    for (std::size_t k = lags; k > 0; --k) {
      s.errors[k] = s.errors[k - 1];
    }
    s.errors[0] = e;
    for (std::size_t k = 0; k <= lags; ++k) {
      s.covariance[k] += (e * s.errors[k] - s.covariance[k]) / memory;
    }
    s.sigma = std::sqrt(std::max(long_run(s), least * s.begun_with * s.begun_with));
  }

  // Whether the noise of all joints is known: few errors of late were outliers. At the begin it is not, and
  // rows of a window much shorter than the identification's are noisier than it was.
  [[nodiscard]] bool settled() const noexcept {
    return std::ranges::all_of(joints_, [](const State& s) { return s.outliers < few_outliers; });
  }

  // Variance of Σ g^k e_k over Σ g^2k, over that of long sums: below one where errors are alike.
  [[nodiscard]] double short_run(std::size_t j, double g) const noexcept {
    const State& s = joints_[j];
    double sum = s.covariance[0];
    double weight = 2.0;
    for (std::size_t k = 1; k <= lags; ++k) {
      weight *= g;
      sum += weight * s.covariance[k];
    }
    return std::clamp(sum / (s.sigma * s.sigma), least, 1.0 / least);
  }

  [[nodiscard]] auto state() noexcept { return std::tie(joints_); }

  struct State {
    static constexpr std::size_t lags = 10;
    double begun_with = 1.0;
    double sigma = 1.0;
    double outliers = 0.5;  // share of late
    std::array<double, lags + 1> covariance{};
    std::array<double, lags + 1> errors{};
  };
  [[nodiscard]] std::vector<State>& states() noexcept { return joints_; }
  [[nodiscard]] const std::vector<State>& states() const noexcept { return joints_; }

 private:
  static constexpr std::size_t lags = State::lags;
  // Time for which errors are alike, before any was seen [s].
  static constexpr double alike_for = 0.5;
  // Rows that the autocovariances remember.
  static constexpr double memory = 200.0;
  // … and rows that the share of outliers does.
  static constexpr double short_memory = 50.0;
  static constexpr double few_outliers = 0.2;
  // Errors count as so many deviations at most.
  static constexpr double outlier = 3.0;
  // No variance below this part of that of the identification.
  static constexpr double least = 0.1;

  [[nodiscard]] static double long_run(const State& s) noexcept {
    double sum = s.covariance[0];
    for (std::size_t k = 1; k <= lags; ++k) {
      sum += 2.0 * (1.0 - static_cast<double>(k) / static_cast<double>(lags + 1)) * s.covariance[k];
    }
    return sum;
  }

  std::vector<State> joints_;
};

// Whether prediction errors look like another load: u = lᵀ δ + e, e with unit variance, δ the change of first
// moments and mass. Sums with exponentially fading weights g^age: a = Σ g^age l u has the covariance B = Σ
// g^(2 age) l lᵀ while nothing has changed, so aᵀ B⁻¹ a is χ² with four degrees of freedom. On a real arm it
// is larger, by errors of the model that look like a load; it is measured by its own mean of late.
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

  // A row of joint j: l and u, both over the deviation of the prediction by the long-run noise. A short
  // memory has a shorter run.
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

  [[nodiscard]] auto state() noexcept { return std::tie(state_); }

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

// Inertia tensor nearest to I, in its second moments, that some body has: Σ = ½ tr(I) 1 − I without its
// negative eigenvalues.
template <typename Scalar>
[[nodiscard]] Eigen::Matrix3<Scalar> nearest_inertia(const Eigen::Matrix3<Scalar>& I) noexcept {
  using M = Eigen::Matrix3<Scalar>;
  M S = -I;
  for (Index k = 0; k < 3; ++k) {
    S(k, k) += Scalar(0.5) * (I(0, 0) + I(1, 1) + I(2, 2));
  }
  const auto [moments, V] = jacobi_eigen(S);
  M out = M::Zero();
  Scalar trace(0);
  for (Index k = 0; k < 3; ++k) {
    const Scalar moment = std::max(moments[k], Scalar(0));
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
