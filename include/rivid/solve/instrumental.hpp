#pragma once

#include <span>
#include <vector>

#include "rivid/solve/streaming_qr.hpp"

namespace rivid {

/// Rows [V W Y] that share a scale of error and whose V and W touch the same columns: in rivid, those of one
/// joint.
struct InstrumentalGroup {
  std::vector<Index> columns;  ///< that the rows touch, ascending, (m)
  StreamingQr qr;              ///< of V, with W and Y carried: StreamingQr(m, m + 1)
};

/// Instrumental-variable solution of the rows of several groups.
struct InstrumentalVariables {
  Vector chi;   ///< (b), Eq. (29) of [RIV]; not a number without full rank
  Matrix R_VV;  ///< (b × b) triangle of V
  Matrix R_VW;  ///< (b × b) Q_Vᵀ W, square and full
  /// (VᵀW)⁻¹ (VᵀV) (WᵀV)⁻¹ = R_VW⁻¹ R_VW⁻ᵀ: the covariance per unit of residual variance, (b × b).
  Matrix unit_covariance;
  Index rank = 0;                                ///< of VᵀW
  std::vector<std::vector<Index>> undetermined;  ///< sets of columns that the instruments can not distinguish
  double smallest_pivot = 0.0;  ///< of R_VW with columns of norm 1: what the rank decision looked at
  double condition_V = 0.0;     ///< of R_VV
  double condition_VW = 0.0;    ///< of R_VW

  [[nodiscard]] bool full_rank() const { return rank == chi.size(); }
};

/// χ̂ of Vᵀ Ω⁻¹ W χ = Vᵀ Ω⁻¹ Y with Ω^(−1/2) = weights, by way of [V | W Y] = Q [R_VV | R_VW r_VY; 0 | …] and
/// R_VW χ = r_VY, Eq. (34) of [RIV]: from the triangles of the groups, without another look at the rows and
/// without normal equations.
///
/// @param groups   at least one
/// @param columns  b
/// @param weights  (number of groups), each positive
/// @throws InputError  where a group's columns are not those of its factor or among the b, a weight is
///                     missing, or a factor does not carry W and Y
[[nodiscard]] InstrumentalVariables instrumental_variables(std::span<const InstrumentalGroup> groups,
                                                           Index columns, std::span<const double> weights);

}  // namespace rivid
