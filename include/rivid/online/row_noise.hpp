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
// (lags + 1)) γ_k [Newey & West 1987]. The variance is that of the rows of like speed, for friction is known
// worst where it is slow; the autocorrelations are those of errors over their deviation. Both follow the
// prediction errors. They begin with the deviation of the identification and with errors of a model, which
// last as long as a motion does.
class RowNoise {
 public:
  // Kinds of rows of each joint: of four octaves of speed, and of rests.
  static constexpr std::size_t octaves = 4;
  static constexpr std::size_t kinds = octaves + 1;

  // slow    speeds at which the lowest octave begins, (n)
  // step    time from one row to the next [s]
  RowNoise(const Vector& sigma, const Vector& slow, double step)
      : joints_(static_cast<std::size_t>(sigma.size())), slow_(sigma.size()) {
    constexpr double usual = 0.02;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const auto at = static_cast<Index>(j);
      slow_[at] = at < slow.size() && slow[at] > 0.0 ? slow[at] : usual;
      State& s = joints_[j];
      s.least = least * sigma[at] * sigma[at];
      s.variance.fill(sigma[at] * sigma[at]);
      for (std::size_t k = 0; k <= lags; ++k) {
        s.alike[k] = std::exp(-static_cast<double>(k) * step / alike_for);
      }
    }
  }

  [[nodiscard]] static std::size_t joint(std::size_t kind) noexcept { return kind / kinds; }
  [[nodiscard]] std::size_t kind(std::size_t j, double speed) const noexcept {
    const int octave = std::ilogb(std::max(std::abs(speed) / slow_[static_cast<Index>(j)], 1.0));
    return j * kinds + std::min(static_cast<std::size_t>(octave), octaves - 1);
  }
  [[nodiscard]] static std::size_t at_rest(std::size_t j) noexcept { return j * kinds + octaves; }
  // What friction may hold at rest, beside the noise [N·m | N].
  void set_rest(std::size_t j, double sigma) noexcept { joints_[j].variance[octaves] += sigma * sigma; }

  [[nodiscard]] double sigma(std::size_t kind) const noexcept {
    const State& s = joints_[joint(kind)];
    const bool rests = kind % kinds == octaves;
    return std::sqrt(std::max(s.variance[kind % kinds] * (rests ? 1.0 : long_run(s)), s.least));
  }

  // error  prediction error of a row, scaled to the variance of its noise [N·m | N]
  void take(std::size_t kind, double error) noexcept {
    State& s = joints_[joint(kind)];
    double& variance = s.variance[kind % kinds];
    double& rows = s.rows[kind % kinds];
    const bool rests = kind % kinds == octaves;
    // A jump of the payload is no noise.
    const double limit = outlier * sigma(kind);
    const double e = std::clamp(error, -limit, limit);
    const double share =
        rests ? 1.0 / std::min(rows + guessed_rests, rests_memory) : 1.0 / std::min(rows + guessed, memory);
    variance = std::max(variance + share * (e * e - variance), s.least);
    rows = std::min(rows + 1.0, memory);
    if (rests) {
      return;
    }
    for (std::size_t k = lags; k > 0; --k) {
      s.errors[k] = s.errors[k - 1];
    }
    s.errors[0] = e / std::sqrt(variance);
    double all = 0.0;
    for (std::size_t c = 0; c < octaves; ++c) {
      all += s.rows[c];
    }
    for (std::size_t k = 0; k <= lags; ++k) {
      s.alike[k] += (s.errors[0] * s.errors[k] - s.alike[k]) / std::min(all + guessed, memory);
    }
  }

  // Whether the noise of such rows is known: at the begin it is not, and rows of a window much shorter than
  // the identification's are noisier than it was.
  [[nodiscard]] bool known(std::size_t kind) const noexcept {
    return joints_[joint(kind)].rows[kind % kinds] >= enough_rows && kind % kinds != octaves;
  }

  // Variance of Σ g^k e_k over Σ g^2k, over that of long sums: below one where errors are alike.
  [[nodiscard]] double short_run(std::size_t kind, double g) const noexcept {
    const State& s = joints_[joint(kind)];
    double sum = s.alike[0];
    double weight = 2.0;
    for (std::size_t k = 1; k <= lags; ++k) {
      weight *= g;
      sum += weight * s.alike[k];
    }
    return std::clamp(sum / long_run(s), least, 1.0 / least);
  }

  [[nodiscard]] auto state() noexcept { return std::tie(joints_); }

  struct State {
    static constexpr std::size_t lags = 10;
    double least = 0.0;
    std::array<double, kinds> variance{};
    std::array<double, kinds> rows{};  // that were seen, at most as many as are remembered
    std::array<double, lags + 1> alike{};
    std::array<double, lags + 1> errors{};
  };
  [[nodiscard]] std::vector<State>& states() noexcept { return joints_; }
  [[nodiscard]] const std::vector<State>& states() const noexcept { return joints_; }

 private:
  static constexpr std::size_t lags = State::lags;
  // Time for which errors are alike, before any was seen [s].
  static constexpr double alike_for = 0.5;
  // Rows that variances and autocorrelations remember; of rests.
  static constexpr double memory = 200.0;
  static constexpr double rests_memory = 20.0;
  // Rows that the begin is worth, and after which the noise is known.
  static constexpr double guessed = 20.0;
  static constexpr double guessed_rests = 3.0;
  static constexpr double enough_rows = 20.0;
  // Errors count as so many deviations at most.
  static constexpr double outlier = 3.0;
  // No variance below this part of that of the identification.
  static constexpr double least = 0.1;

  [[nodiscard]] static double long_run(const State& s) noexcept {
    double sum = s.alike[0];
    for (std::size_t k = 1; k <= lags; ++k) {
      sum += 2.0 * (1.0 - static_cast<double>(k) / static_cast<double>(lags + 1)) * s.alike[k];
    }
    return std::max(sum, least);
  }

  std::vector<State> joints_;
  Vector slow_;
};

// Whether prediction errors look like another load: u = lᵀ δ + e, e with unit variance, δ the change of first
// moments and mass. Sums with exponentially fading weights g^age: a = Σ g^age l u has the covariance B = Σ
// g^(2 age) l lᵀ while nothing has changed, so aᵀ B⁻¹ a is χ² with four degrees of freedom. On a real arm it
// is larger, by errors of the model that look like a load; it is measured by its own mean of late, which a
// change that is not found moves little.
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
    per_second_ = options.per_second;
    for (std::size_t m = 0; m < memories; ++m) {
      fade_[m] = std::exp(-1.0 / std::max(seconds[m] * options.per_second, 0.5));
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const double scale = k < 3 ? options.mass * options.length : options.mass;
      known_[k] = 1.0 / (scale * scale);
    }
  }

  // A row of some kind: l and u, both over the deviation of the prediction by the long-run noise. A short
  // memory has a shorter run. Of rows whose noise is not known yet nothing can be said.
  void take(const std::array<double, 4>& l, double u, const RowNoise& noise, std::size_t kind) noexcept {
    if (!noise.known(kind)) {
      return;
    }
    if (state_.tried) {
      const double likely = inner(state_.delta, l);
      state_.ratio += likely * (u - 0.5 * likely) / misfit();
      state_.highest = std::max(state_.highest, state_.ratio);
    }
    for (std::size_t m = 0; m < memories; ++m) {
      Sums& s = state_.sums[m];
      const double weight = 1.0 / noise.short_run(kind, fade_[m]);
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
    state_.steps = std::min(state_.steps + 1.0, mean_seconds * per_second_);
    const double share = 1.0 / std::max(state_.steps, first_seconds * per_second_);
    for (std::size_t m = 0; m < memories; ++m) {
      Sums& s = state_.sums[m];
      const double test = quadratic(s.B, s.a);
      const double usual = std::max(s.mean, degrees);
      state_.tests[m] = test * degrees / (threshold_ * usual);
      state_.suspicion = std::max(state_.suspicion, state_.tests[m]);
      s.mean += share * (std::min(test, most_usual * usual) - s.mean);
    }
    if (!quiet()) {
      state_.likely = most_likely();
    }
    for (std::size_t m = 0; (state_.suspicion <= 1.0 || tried()) && m < memories; ++m) {
      state_.sums[m].fade(fade_[m]);
    }
  }

  // What a change that is suspected makes of a row: no noise.
  [[nodiscard]] double suspected(const std::array<double, 4>& l) const noexcept {
    return quiet() ? 0.0 : inner(state_.likely, l);
  }

  // The change that was found is tried from now on: whether the rows that come show it too, by their likelihood over
  // that of no change.
  void try_change() noexcept {
    state_.delta = most_likely();
    state_.ratio = state_.highest = 0.0;
    state_.tried = true;
  }
  [[nodiscard]] bool tried() const noexcept { return state_.tried; }
  [[nodiscard]] bool shows() const noexcept { return state_.tried && state_.tests[of_late] > 0.5; }
  [[nodiscard]] bool goes_on() const noexcept {
    return state_.tried && state_.ratio > certain && state_.ratio > state_.highest - 0.5 * certain;
  }
  // Whether it does no longer. One that looks otherwise in another pose is tried anew.
  [[nodiscard]] bool over() noexcept {
    const bool unlike = state_.tried && state_.ratio < state_.highest - certain;
    const bool other = unlike && state_.tests[of_late] > 1.0;
    if (other) {
      try_change();
    }
    return unlike && !other;
  }

  [[nodiscard]] bool found() const noexcept { return state_.suspicion > 1.0; }
  [[nodiscard]] bool quiet() const noexcept { return state_.suspicion < 0.5; }
  [[nodiscard]] double suspicion() const noexcept { return state_.suspicion; }
  // What the test is of late over what noise makes it, at least 1: errors of the model that look like a load.
  [[nodiscard]] double misfit() const noexcept {
    double out = 1.0;
    for (const Sums& s : state_.sums) {
      out = std::max(out, s.mean / degrees);
    }
    return out;
  }

  // What a trial has not used yet is forgotten.
  void forget_rows() noexcept {
    for (std::size_t m = 0; m < memories; ++m) {
      state_.sums[m].fade(0.0);
      state_.tests[m] = 0.0;
    }
  }

  // Begins anew; what is usual of the test stays.
  void reset() noexcept {
    State next;
    next.steps = state_.steps;
    for (std::size_t m = 0; m < memories; ++m) {
      next.sums[m].mean = state_.sums[m].mean;
    }
    state_ = next;
  }

  [[nodiscard]] auto state() noexcept { return std::tie(state_); }

 private:
  using Vector4 = std::array<double, 4>;
  using Triangle = std::array<Vector4, 4>;
  static constexpr double degrees = 4.0;
  // Time over which the mean of the test is taken, at the begin and later [s], and what counts in it at most,
  // over the mean.
  static constexpr double first_seconds = 5.0;
  static constexpr double mean_seconds = 60.0;
  static constexpr double most_usual = 2.0;
  struct Sums {
    Vector4 a{};
    Triangle B{};
    double mean = 1.5 * degrees;  // of the test of late

    void fade(double g) noexcept {
      for (std::size_t i = 0; i < 4; ++i) {
        a[i] *= g;
        for (std::size_t k = 0; k <= i; ++k) {
          B[i][k] *= g * g;
        }
      }
    }
  };

  static constexpr std::size_t memories = 4;
  static constexpr std::size_t of_late = 1;  // memory that says whether there is any change of late
  static constexpr double certain = 5.0;     // logarithm of a likelihood ratio
  static constexpr std::array<double, memories> seconds = {0.04, 0.15, 0.5, 2.0};
  struct State {
    std::array<Sums, memories> sums{};
    std::array<double, memories> tests{};  // over their thresholds
    double suspicion = 0.0;                // the largest of these
    double steps = 0.0;
    bool tried = false;
    Vector4 likely{};      // change that is suspected
    Vector4 delta{};       // what is tried
    double ratio = 0.0;    // logarithm of its likelihood over that of none
    double highest = 0.0;  // so far
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
  // L⁻¹ a
  [[nodiscard]] static Vector4 whitened(const Triangle& L, const Vector4& a) noexcept {
    Vector4 x = a;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        x[i] -= L[i][k] * x[k];
      }
      x[i] /= L[i][i];
    }
    return x;
  }
  [[nodiscard]] static double inner(const Vector4& a, const Vector4& b) noexcept {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  }
  [[nodiscard]] double quadratic(const Triangle& B, const Vector4& a) const noexcept {
    const Vector4 x = whitened(factor(B), a);
    return inner(x, x);
  }
  // δ of L Lᵀ δ = a
  [[nodiscard]] Vector4 most_likely() const noexcept {
    const auto by = std::ranges::max_element(state_.tests) - state_.tests.begin();
    const Sums& s = state_.sums[static_cast<std::size_t>(by)];
    const Triangle L = factor(s.B);
    Vector4 x = whitened(L, s.a);
    for (std::size_t i = 4; i-- > 0;) {
      for (std::size_t k = i + 1; k < 4; ++k) {
        x[i] -= L[k][i] * x[k];
      }
      x[i] /= L[i][i];
    }
    return x;
  }

  double threshold_ = 0.0;
  double per_second_ = 1.0;
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
