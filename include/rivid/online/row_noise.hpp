#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "rivid/model/chain.hpp"
#include "rivid/online/information_triangle.hpp"
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
  // Rows that variances and autocorrelations remember.
  static constexpr double memory = 200.0;

  // slow    speeds at which the lowest octave begins, (n)
  // step    time from one row to the next [s]
  RowNoise(const Vector& sigma, const Vector& slow, double step)
      : joints_(static_cast<std::size_t>(sigma.size())), slow_(sigma.size()) {
    constexpr double usual = 0.02;  // [rad/s | m/s] where the model has none; a choice
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

  [[nodiscard]] auto state() noexcept { return std::tie(joints_); }

  struct State {
    static constexpr std::size_t lags = 10;  // rows; a choice: more make the variance rougher
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
  // The same of rests.
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
// moments and mass, l what it makes of a row that the estimate has followed [Willsky & Jones 1976]. Sums
// since a step, a = Σ l u, have the covariance B = Σ l lᵀ while nothing has changed, so aᵀ B⁻¹ a is χ² with
// four degrees of freedom: the likelihood ratio of a change at that step. Several steps are tried, each about
// twice as long ago as the next. That what is held is let go is the likeliest change, and known: δ = −λ̂. Its
// likelihood ratio exceeds A at any time after its step with a probability of 1/A at most. On a real arm the
// test is larger, by errors of the model that look like a load, and smaller where errors of neighbouring rows
// are alike; both are measured by its own mean of late, which a change that is not found moves little.
class LoadChange {
 public:
  static constexpr std::size_t onsets = 6;  // a choice: each takes four columns beside y
  using Vector4 = std::array<double, 4>;
  using Signatures = std::array<Vector4, onsets>;  // l of each step that is tried

  struct Options {
    double per_second = 40.0;  // steps
    double hours_to_false_alarm = 10.0;
    double mass = 10.0;   // that a change may have [kg]
    double length = 0.2;  // and its distance from the last link's origin [m]
  };

  explicit LoadChange(const Options& options) {
    const double steps = 3600.0 * options.hours_to_false_alarm * options.per_second;
    const double p = 1.0 / (steps * static_cast<double>(onsets));
    // P(4 F > x) = (1 + x/ν)^(−ν/2) (1 + x/2 / (1 + x/ν)) of F with 4 and ν degrees of freedom, by
    // fixed-point iteration: variances are those of ν rows.
    constexpr double rows = RowNoise::memory;
    threshold_ = 40.0;
    for (int k = 0; k < 60; ++k) {
      const double x = threshold_;
      threshold_ = rows * std::expm1(2.0 / rows * (std::log1p(0.5 * x / (1.0 + x / rows)) - std::log(p)));
    }
    release_threshold_ = rows * std::expm1(2.0 / rows * std::log(steps / spacing));
    per_second_ = options.per_second;
    for (std::size_t k = 0; k < 4; ++k) {
      const double scale = k < 3 ? options.mass * options.length : options.mass;
      known_[k] = 1.0 / (scale * scale);
    }
    state_.mean.fill(1.5 * degrees);
  }

  // A row of some kind: l and u, both over the deviation of the prediction by the long-run noise. Of rows
  // whose noise is not known yet nothing can be said.
  void take(const Signatures& l, double u, const RowNoise& noise, std::size_t kind) noexcept {
    if (!noise.known(kind)) {
      return;
    }
    if (state_.tried) {
      const double likely = inner(state_.delta, l[0]);
      state_.ratio += likely * (u - 0.5 * likely) / misfit();
      state_.highest = std::max(state_.highest, state_.ratio);
    }
    for (std::size_t m = 0; m < onsets; ++m) {
      Sums& s = state_.sums[m];
      for (std::size_t i = 0; i < 4; ++i) {
        s.a[i] += l[m][i] * u;
        for (std::size_t k = 0; k < 4; ++k) {
          s.B[i][k] += l[m][i] * l[m][k];
        }
      }
    }
  }

  // One step of time.
  void step() noexcept {
    state_.suspicion = state_.late = 0.0;
    state_.steps = std::min(state_.steps + 1.0, mean_seconds * per_second_);
    const double share = 1.0 / std::max(state_.steps, first_seconds * per_second_);
    for (std::size_t m = 0; m < onsets; ++m) {
      Sums& s = state_.sums[m];
      s.age += 1.0;
      const Vector4 likely = most_likely(s);
      const double test = inner(likely, s.a);
      double& mean = state_.mean[std::min(static_cast<std::size_t>(std::ilogb(s.age)), octaves - 1)];
      const double usual = std::max(mean, least_usual * degrees);
      s.test = std::max(test / threshold_, release(s) / release_threshold_) * degrees / usual;
      mean += share * (std::min(test, most_usual * usual) - mean);
      if (s.test >= state_.suspicion) {
        state_.suspicion = s.test;
        state_.by = m;
        state_.likely = likely;
      }
      if (s.age <= late_seconds * per_second_) {
        state_.late = std::max(state_.late, s.test);
      }
    }
  }

  // Which step is given up for a new one, once in a while: the oldest if it is too old, else that which
  // leaves the smallest gap.
  //
  // release  change that lets go what is held now
  [[nodiscard]] std::optional<std::size_t> restart(const Vector4& release = {}) noexcept {
    state_.since_restart += 1.0;
    if (state_.since_restart < spacing) {
      return std::nullopt;
    }
    state_.since_restart = 0.0;
    std::array<std::pair<double, std::size_t>, onsets + 1> by_age{};  // first that at hand
    for (std::size_t m = 0; m < onsets; ++m) {
      by_age[m + 1] = {state_.sums[m].age, m};
    }
    std::ranges::sort(by_age.begin() + 1, by_age.end());
    auto [oldest, out] = by_age[onsets];
    double smallest = oldest < longest_seconds * per_second_ ? std::numeric_limits<double>::infinity() : 0.0;
    for (std::size_t i = 1; i < onsets; ++i) {
      const double gap = (by_age[i + 1].first + spacing) / (by_age[i - 1].first + spacing);
      if (gap < smallest && (quiet() || by_age[i].second != state_.by)) {
        smallest = gap;
        out = by_age[i].second;
      }
    }
    state_.sums[out] = {.release = release};
    return out;
  }

  // What a change that is suspected makes of a row: no noise.
  [[nodiscard]] double suspected(const Signatures& l) const noexcept {
    return quiet() ? 0.0 : inner(state_.likely, l[state_.by]);
  }

  // The change that was found is tried from now on: whether the rows that come show it too, by their
  // likelihood over that of no change.
  void try_change() noexcept {
    state_.delta = state_.likely;
    state_.ratio = state_.highest = 0.0;
    state_.tried = true;
  }
  [[nodiscard]] bool tried() const noexcept { return state_.tried; }
  [[nodiscard]] bool shows() const noexcept { return state_.tried && state_.late > 0.5; }
  [[nodiscard]] bool goes_on() const noexcept {
    return state_.tried && state_.ratio > certain && state_.ratio > state_.highest - 0.5 * certain;
  }
  // Whether it does no longer.
  [[nodiscard]] bool over() const noexcept { return state_.tried && state_.ratio < state_.highest - certain; }

  [[nodiscard]] bool found() const noexcept { return state_.suspicion > 1.0; }
  [[nodiscard]] bool quiet() const noexcept { return state_.suspicion < 0.5; }
  [[nodiscard]] double suspicion() const noexcept { return state_.suspicion; }
  // Steps since the change that is suspected.
  [[nodiscard]] double age() const noexcept { return state_.sums[state_.by].age; }
  // What the test is of late over what noise makes it, at least 1: errors of the model that look like a load.
  [[nodiscard]] double misfit() const noexcept {
    return std::max(std::ranges::max(state_.mean) / degrees, 1.0);
  }

  // What a trial has not used yet is forgotten.
  void forget_rows() noexcept {
    state_.sums = {};
    state_.late = 0.0;
  }

  // Begins anew; what is usual of the test stays.
  void reset() noexcept {
    State next;
    next.steps = state_.steps;
    next.mean = state_.mean;
    state_ = next;
  }

  [[nodiscard]] auto state() noexcept { return std::tie(state_); }

 private:
  static constexpr double degrees = 4.0;  // of freedom: three first moments and the mass
  // Time over which the mean of the test is taken, at the begin and later [s], and what counts in it at most,
  // over the mean.
  static constexpr double first_seconds = 5.0;
  static constexpr double mean_seconds = 60.0;
  static constexpr double most_usual = 2.0;
  static constexpr double least_usual = 1.0;      // over its degrees of freedom: what noise alone makes it
  static constexpr std::size_t octaves = 8;       // of the time since a change, whose tests have a mean each
  static constexpr double spacing = 3.0;          // steps to the next that is tried
  static constexpr double longest_seconds = 4.0;  // [s] age at which the oldest step is given up; a choice
  static constexpr double late_seconds = 0.6;     // [s] age up to which a step counts as late; a choice
  static constexpr double certain = 5.0;          // logarithm of a likelihood ratio
  struct Sums {
    Vector4 a{};
    std::array<Vector4, 4> B{};
    Vector4 release{};
    double age = 0.0;   // steps
    double test = 0.0;  // over its threshold
  };

  struct State {
    std::array<Sums, onsets> sums{};
    std::array<double, octaves> mean{};  // of the test of late
    double suspicion = 0.0;              // the largest test
    double late = 0.0;                   // of changes of late
    double steps = 0.0;
    double since_restart = 0.0;
    std::size_t by = 0;  // the largest one's
    bool tried = false;
    Vector4 likely{};      // change that is suspected
    Vector4 delta{};       // what is tried
    double ratio = 0.0;    // logarithm of its likelihood over that of none
    double highest = 0.0;  // so far
  };

  [[nodiscard]] static double inner(const Vector4& a, const Vector4& b) noexcept {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  }
  // Twice the logarithm of the likelihood ratio of a release.
  [[nodiscard]] static double release(const Sums& s) noexcept {
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      sum += s.release[i] * (2.0 * s.a[i] - inner(s.B[i], s.release));
    }
    return sum;
  }
  // δ of (B + known) δ = a
  [[nodiscard]] Vector4 most_likely(const Sums& s) const noexcept {
    Equations<4> A{};
    for (std::size_t i = 0; i < 4; ++i) {
      std::ranges::copy(s.B[i], A[i].begin());
      A[i][i] += known_[i];
      A[i][4] = s.a[i];
    }
    const auto delta = solved<4>(A);
    return {delta[0].value, delta[1].value, delta[2].value, delta[3].value};
  }

  double threshold_ = 0.0;
  double release_threshold_ = 0.0;
  double per_second_ = 1.0;
  Vector4 known_{};
  State state_;
};

// Inertia tensor nearest to I, in its second moments, that some body has: Σ = ½ tr(I) 1 − I without its
// negative eigenvalues.
template <typename Scalar>
[[nodiscard]] Eigen::Matrix3<Scalar> nearest_inertia(const Eigen::Matrix3<Scalar>& I) noexcept {
  using M = Eigen::Matrix3<Scalar>;
  const M S = Scalar(0.5) * I.trace() * M::Identity() - I;
  const auto [moments, V] = jacobi_eigen(S);
  M out = M::Zero();
  for (Index k = 0; k < 3; ++k) {
    const Eigen::Vector3<Scalar> axis = V.col(k);
    out += std::max(moments[k], Scalar(0)) * (M::Identity() - axis * axis.transpose());
  }
  return out;
}

}  // namespace rivid::detail
