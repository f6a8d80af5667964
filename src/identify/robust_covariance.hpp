#pragma once

#include <span>
#include <vector>

#include "identify/reweighting.hpp"

namespace rivid::detail {

// What a loss makes of the information in the rows of each joint, [Huber 1981], section 7.6: an estimate errs by
// A⁻¹ Σ_t Z_tᵀ ω² s ψ_t with A = Σ_j ω² E[ψ'] Z_jᵀ W_j, where ω are the weights by joint, and the variance of the sum is
// B = Σ_j ω⁴ s² E[ψ²] Z_jᵀ Z_j if the errors of rows are independent of each other and of Z.
struct RobustInformation {
  std::vector<double> bread;  // by which the rows of each joint are scaled for A …
  std::vector<double> meat;   // … and for B
  double sigma = 0.0;         // A / σ² is about the information on the parameters
};

// weights  ω, one a joint
// b        parameters
[[nodiscard]] RobustInformation robust_information(std::span<const RobustSums> sums, const RowLoss& loss,
                                                   std::span<const double> weights, Index b);

// A⁻¹ from the slopes of the rows as they are, Σ_t Z_tᵀ ω² ψ'_t W_t.
//
// bread  A⁻¹ as information tells, which that is near to
[[nodiscard]] Matrix bread_from_slopes(const Matrix& curvature, const Matrix& bread);

// Standard deviation that weighted errors have but for the outliers.
[[nodiscard]] double robust_deviation(std::span<const RobustSums> sums, const RowLoss& loss,
                                      std::span<const double> weights);

}  // namespace rivid::detail
