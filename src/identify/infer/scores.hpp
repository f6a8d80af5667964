#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "identify/estimate/estimate.hpp"
#include "identify/estimate/robust.hpp"
#include "identify/rows/row_source.hpp"
#include "identify/rows/thread_team.hpp"
#include "identify/rows/time_blocks.hpp"

namespace rivid::detail {

// The solution χ of Zᵀ Ω⁻¹ (Y − W χ) = 0, where Z are the instruments V or W itself; of an M-estimate with ψ
// of the residual in its place.
struct Estimator {
  Vector chi;  // (b)
  bool instrumental = false;
  // A⁻¹ = (Zᵀ Ω⁻¹ W)⁻¹, (b × b), of an M-estimate that of RobustInformation, where residuals are to be
  // corrected for the leverage of their rows: a row draws the estimate towards itself, and its residual falls
  // short of its error by 1 − wᵀ A⁻¹ z / σ², with ψ' before the last term where a loss has one. Empty for
  // none.
  Matrix bread;
};

// Whether rows are so few, for b parameters, that leverage counts.
[[nodiscard]] inline bool leverage_counts(Index rows, Index b) {
  // rows for each parameter, beyond which leverages are 0.1 % on average; a choice
  constexpr Index many = 1000;
  return rows < many * b;
}

// Sums over the residual ρ of a joint's rows, for tests of whiteness and normality.
struct ResidualMoments {
  static constexpr Index lags = 20;  // of the test of whiteness, its degrees of freedom; a choice

  Index rows = 0;
  std::array<double, 4> powers{};          // Σ ρ, Σ ρ², Σ ρ³, Σ ρ⁴
  std::array<double, lags> products{};     // Σ ρ_t ρ_{t−l}, l = 1 … lags, of rows without a gap between them
  std::array<double, lags> pair_counts{};  // of these sums

  void merge(const ResidualMoments& other);
};

// Whether the torques are as old as the motion. Torques that are d samples late are Y = W χ − d D with their
// rate D, and what is left of an estimate with the instruments Z is ρ = −d (D − W B Zᵀ D), B = (Zᵀ W)⁻¹. The
// rate P of Z χ̂, which knows no noise of the torques, picks d out of it: Pᵀ ρ = −d H.

// Sums over the rows of a joint.
class LagSums {
 public:
  // Rows that come before those of a call, from the calls before.
  static constexpr Index lead = 4;

  // stride     samples from one row to the next where none is left out
  // intervals  of time that sums are told for
  LagSums(Index own, Index stride, Index intervals, double samples_per_interval);

  // Rows lead … lead + samples.size() − 1; those before them are the last of the call before. The last two
  // are counted with the next call.
  //
  // Z, W    (lead + count × own)
  // Y, rho  torques and residual, (lead + count)
  // chi     (own)
  void add(const Eigen::Ref<const Matrix>& Z, const Eigen::Ref<const Matrix>& W,
           const Eigen::Ref<const Vector>& Y, const Eigen::Ref<const Vector>& rho,
           const Eigen::Ref<const Vector>& chi, std::span<const Index> samples);

  Vector PD;     // Pᵀ D of each interval of time
  Vector P_rho;  // Pᵀ ρ of each
  Vector WP;     // Wᵀ P, (own)
  Matrix ZD;     // Zᵀ D of each, (intervals × own)

 private:
  // far before all samples, so that differences to it do not overflow
  static constexpr Index none = std::numeric_limits<Index>::min() / 2;

  // Whether no row is missing from so many before row i to so many after it.
  [[nodiscard]] bool beside(Index i, Index before, Index after) const;
  // Rate at row i, from one row to the next: by two rows on each side where they are, else by one, or by two
  // on one side.
  [[nodiscard]] double rate(const Eigen::Ref<const Vector>& x, Index i) const;
  // Slope of the straight line through five rows, 0 where they are not there.
  [[nodiscard]] double slope(const Eigen::Ref<const Vector>& x, Index i) const;

  Index stride_;
  double samples_per_interval_;
  std::vector<Index> samples_;  // of the last rows
};

// The sums of all joints and logs, weighted.
struct RateSums {
  Matrix WP;  // (b × n)
  Matrix ZD;  // (b × n)
  // One of each log.
  std::vector<Matrix> P_rho;       // (intervals × n)
  std::vector<Matrix> PD;          // (intervals × n)
  std::vector<Matrix> ZD_by_time;  // of all joints together, (intervals × b)
};

// What a second look at the rows finds once an estimate is known.
struct Scores {
  // Σ Z_tᵀ Ω⁻¹ ρ_t over the rows of each interval of time, (intervals × b): for each estimator one of each
  // log.
  std::vector<std::vector<Matrix>> series;
  double interval = 0.0;  // [s]
  // Σ Z_tᵀ Ω⁻¹ ψ'_t W_t of each estimator, (b × b); empty without a loss.
  std::vector<Matrix> curvature;
  std::vector<ResidualMoments> residuals;  // of the first estimator, one a joint
  RateSums rates;                          // of the first estimator
  std::vector<BlockSums> blocks;  // of the first estimator: some ten of all logs together; empty with a loss
};

// Scores of estimators on the same rows.
//
// signals     that the rows are made with, one a log, see EstimationProblem::send_rows()
// instruments motions that V is built from, one a log; empty where no estimator is instrumental
// estimators  at least one
// weights     1/σ of each joint's rows, Ω = diag σ²
// from_V      columns of W, within each joint's own, that were taken from V
// whitening   coefficients of the filter of each joint's rows, see WhitenedSink, (n); empty for none
// loss        of M-estimates, or nullptr
//
// throws InputError where RowSource does
[[nodiscard]] Scores scores(const EstimationProblem& problem, std::span<const SignalOptions> signals,
                            std::span<const Motion> instruments, std::span<const Estimator> estimators,
                            std::span<const double> weights, const std::vector<std::vector<Index>>& from_V,
                            std::span<const Vector> whitening = {}, const RowLoss* loss = nullptr);

}  // namespace rivid::detail
