#pragma once

#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "excite/sampled_regressor.hpp"
#include "rivid/types.hpp"

// What a motion tells of the base parameters.
namespace rivid::detail {

/// Adds Σ_i W_iᵀ W_i weights[i] to M, both triangles.
void add_information(const SampledRegressor& regressor, std::span<const Matrix> W, const Vector& weights,
                     Matrix& M);

/// A scalar of the information matrix M that is to be made small, and its derivative K: d value = −⟨K, dM⟩.
struct ObjectiveValue {
  double value = 0.0;
  Matrix K;
};

/// What is made small, of the covariance C = M⁻¹:
struct Information {};  ///< −log det M
struct
    TorqueError {  ///< log tr(C B): the mean variance of the torques that are predicted along other motions
  Matrix B;        ///< (b × b)
};
struct Deviations {  ///< Σ log C_ii over some parameters: the geometric mean of their variances
  std::vector<Index> parameters;
};
using Objective = std::variant<Information, TorqueError, Deviations>;

/// Nothing where M is not positive definite.
///
/// @param M  (b × b), symmetric
[[nodiscard]] std::optional<ObjectiveValue> score(const Matrix& M, const Objective& objective);

/// log det M, or −∞.
[[nodiscard]] double log_determinant(const Matrix& M);

/// Covariance and what can be said of M without it.
struct Spread {
  Vector sigma;            ///< (b), infinite for what M does not determine
  double log_det = 0.0;    ///< of M, −∞ where it is singular
  double condition = 0.0;  ///< of the observation matrix, sqrt κ(M)
};
[[nodiscard]] Spread spread(const Matrix& M);

}  // namespace rivid::detail
