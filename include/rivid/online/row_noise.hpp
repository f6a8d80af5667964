#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "rivid/online/saved_state.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Standard deviation that rows of a joint must be given so that sums of many of them err as they do: errors of neighbouring rows are
// alike, and count as independent ones with the long-run variance γ₀ + 2 Σ (1 − k / (lags + 1)) γ_k [Newey & West 1987]. The
// autocovariances follow the prediction errors. They begin with the deviation of the identification and with errors of a model, which
// last as long as a motion does.
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

  // Whether the noise of all joints is known: few errors of late were outliers. At the begin it is not, and rows of a window much shorter
  // than the identification's are noisier than it was.
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

  template <typename Visit>
  void visit_state(Visit& visit) noexcept {
    auto& [joints] = *this;
    visit_parts(visit, joints);
  }

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

}  // namespace rivid::detail
