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

/// W K, (rows × b).
///
/// @param K  (b × b), symmetric
[[nodiscard]] Matrix times_symmetric(const Matrix& W, const Matrix& K);

/// A scalar of the information matrix M that is to be made small, and its derivative K: d value = −⟨K, dM⟩.
struct ObjectiveValue {
  double value = 0.0;
  Matrix K;  ///< empty where it is not wanted
};

/// What is made small, of the covariance C = M⁻¹:
struct Information {};  ///< −log det M
struct TorqueError {    ///< log tr(C B): the mean variance of the torques that are predicted along other
                        ///< motions
  Matrix B;             ///< (b × b)
};
struct Deviations {  ///< Σ log C_ii over some parameters: the geometric mean of their variances
  std::vector<Index> parameters;
};
struct Condition {};  ///< log sqrt κ(M): the condition number of the weighted observation matrix
using Objective = std::variant<Information, TorqueError, Deviations, Condition>;

/// Nothing where M is not positive definite.
///
/// @param M      (b × b), symmetric
/// @param slope  whether K is wanted
[[nodiscard]] std::optional<ObjectiveValue> score(const Matrix& M, const Objective& objective,
                                                  bool slope = true);

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
