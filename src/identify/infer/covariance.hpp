#pragma once

#include <optional>
#include <span>
#include <vector>

#include "identify/infer/scores.hpp"
#include "rivid/identify/covariance.hpp"
#include "rivid/identify/diagnostics.hpp"
#include "rivid/identify/rows.hpp"

namespace rivid::detail {

// By which a decimation shrinks deviations of white errors; 1 where that is not undone.
[[nodiscard]] double decimation_factor(const SignalOptions& signal);

[[nodiscard]] CovarianceKind resolved(CovarianceKind kind, Convention convention);

// An estimate's covariance and where it comes from.
struct Uncertainty {
  Matrix C;            // (b × b)
  Vector plain_sigma;  // deviations before they were scaled to blocks, (b); empty where they were not
  CovarianceReport report;
};

// (18), the factor of the decimation undone; published digits of convention `matlab` keep it.
//
// sigma            standard deviation of the weighted residual
// unit_covariance  (b × b)
[[nodiscard]] Uncertainty classical_covariance(const SignalOptions& signal, double sigma,
                                               const Matrix& unit_covariance, double freedom);

// Intervals that a long-run covariance counts as correlated.
[[nodiscard]] Index lag_of(std::span<const Matrix> series, double interval, const CovarianceOptions& options);

// A⁻¹ S A⁻ᵀ with S the long-run covariance of the scores Σ Zᵀ Ω⁻¹ ρ.
//
// series   one a log, (intervals × b)
// bread    A⁻¹ = (Zᵀ Ω⁻¹ W)⁻¹, (b × b)
// freedom  rows without the parameters
[[nodiscard]] Uncertainty hac_covariance(std::span<const Matrix> series, double interval, const Matrix& bread,
                                         const CovarianceOptions& options, double freedom);

// What the scatter of the blocks of time tells of an estimate beside its HAC covariance: estimates without
// one block each (delete-a-block jackknife). Errors of the model last longer than any lag, and what the
// parameters take up of errors that last no residual shows.
//
// Deviations of the covariance are scaled to those of the jackknife, all alike by the ratio of all parameters
// and each by its own in part, for ten blocks tell a deviation to a quarter of itself only.
void scale_to_blocks(std::span<const BlockSums> blocks, const Matrix& bread, Uncertainty& uncertainty);

[[nodiscard]] std::vector<ResidualTests> residual_tests(const Robot& robot, const Scores& scores);

// Durbin, Wu, Hausman.
//
// shift          χ̂_IV − χ̂_LS, (b)
// by_iv, by_ls   scores of both, bread_… their A⁻¹
// sigma          deviations of χ̂_IV, (b)
[[nodiscard]] HausmanTest hausman_test(const BaseParameters& base, const Vector& shift,
                                       std::span<const Matrix> by_iv, const Matrix& bread_iv,
                                       std::span<const Matrix> by_ls, const Matrix& bread_ls, double interval,
                                       const CovarianceOptions& options, const Vector& sigma);

// One lag of all joints, and what it does to the estimate; its deviation is widened where the joints do not
// agree.
//
// scores   of the estimate, its own the first
// options  of its covariance
// bread    (Zᵀ Ω⁻¹ W)⁻¹, (b × b)
// sigma    deviations that are told of the estimate, (b)
//
// Nothing where no joint's torques change.
[[nodiscard]] std::optional<TorqueLag> torque_lag(const BaseParameters& base, const Scores& scores,
                                                  const CovarianceOptions& options, const Matrix& bread,
                                                  const Vector& sigma);

}  // namespace rivid::detail
