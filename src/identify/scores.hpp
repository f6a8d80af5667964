#pragma once

#include <array>
#include <span>
#include <vector>

#include "identify/reweighting.hpp"
#include "identify/row_source.hpp"
#include "identify/thread_team.hpp"
#include "identify/torque_lag.hpp"

namespace rivid::detail {

// The solution χ of Zᵀ Ω⁻¹ (Y − W χ) = 0, where Z are the instruments V or W itself; of an M-estimate with ψ of the residual
// in its place.
struct Estimator {
  Vector chi;  // (b)
  bool instrumental = false;
  // A⁻¹ = (Zᵀ Ω⁻¹ W)⁻¹, (b × b), of an M-estimate that of RobustInformation, where residuals are to be corrected for the leverage of their rows: a row draws the
  // estimate towards itself, and its residual falls short of its error by 1 − wᵀ A⁻¹ z / σ², with ψ' before the last term
  // where a loss has one. Empty for none.
  Matrix bread;
};

// Whether rows are so few, for b parameters, that leverage counts.
[[nodiscard]] inline bool leverage_counts(Index rows, Index b) {
  constexpr Index many = 1000;
  return rows < many * b;
}

// Sums over the residual ρ of a joint's rows, for tests of whiteness and normality.
struct ResidualMoments {
  static constexpr Index lags = 20;

  Index rows = 0;
  std::array<double, 4> powers{};          // Σ ρ, Σ ρ², Σ ρ³, Σ ρ⁴
  std::array<double, lags> products{};     // Σ ρ_t ρ_{t−l}, l = 1 … lags, of rows without a gap between them
  std::array<double, lags> pair_counts{};  // of these sums

  void merge(const ResidualMoments& other);
};

// What a second look at the rows finds once an estimate is known.
struct Scores {
  // Σ Z_tᵀ Ω⁻¹ ρ_t over the rows of each interval of time, (intervals × b): for each estimator one of each log.
  std::vector<std::vector<Matrix>> series;
  double interval = 0.0;  // [s]
  // Σ Z_tᵀ Ω⁻¹ ψ'_t W_t of each estimator, (b × b); empty without a loss.
  std::vector<Matrix> curvature;
  std::vector<ResidualMoments> residuals;  // of the first estimator, one a joint
  RateSums rates;                          // of the first estimator
};

// How the rows of a log are made.
struct ScoredLog {
  const Log* log = nullptr;
  const SignalOptions* signal = nullptr;
  const Motion* instruments = nullptr;  // that V is built from, or nullptr where no estimator is instrumental
};

// Scores of estimators on the same rows.
//
// estimators  at least one
// weights     1/σ of each joint's rows, Ω = diag σ²
// signs       columns of W, within each joint's own, that were taken from V
// whitening   coefficients of the filter of each joint's rows, see WhitenedSink, (n); empty for none
// loss        of M-estimates, or nullptr
//
// throws InputError where RowSource does
[[nodiscard]] Scores scores(const Robot& robot, const BaseParameters& base, std::span<const ScoredLog> logs,
                            std::span<const Estimator> estimators, std::span<const double> weights,
                            const std::vector<std::vector<Index>>& signs, ThreadTeam& team,
                            std::span<const Vector> whitening = {}, const RowLoss* loss = nullptr);

}  // namespace rivid::detail
