#pragma once

#include <span>
#include <vector>

#include "rivid/solve/streaming_qr.hpp"

namespace rivid {

/// Rows of a linear system that share a scale of error and touch the same columns: in rivid, those of one
/// joint.
struct RowGroup {
  std::vector<Index> columns;  ///< that the rows touch, ascending
  StreamingQr qr;              ///< factor of these columns and Y
};

/// Least-squares solution of the rows of several groups.
struct LeastSquares {
  /// (b); without full rank the solution that is smallest in columns of norm 1.
  Vector chi;
  Matrix R;  ///< (b × b) upper triangular factor of all rows
  /// (WᵀW)⁻¹ by way of R, Eq. (18) of [RIV] per unit of residual variance, (b × b). Without full rank it is
  /// the pseudo-inverse on the determined entries; the diagonal is infinite where undetermined.
  Matrix unit_covariance;
  Index rank = 0;
  std::vector<std::vector<Index>> undetermined;  ///< sets of columns that the rows can not distinguish
  /// What the rank decision looked at, of R with its columns brought to norm 1: a lower bound of all pivots,
  /// and of all singular values, where it leaves no doubt, else the last pivot.
  double smallest_pivot = 0.0;
  double condition = 0.0;  ///< of the matrix of all rows

  [[nodiscard]] bool full_rank() const { return rank == chi.size(); }
};

/// The factor of the rows of all groups, each group's scaled by its weight: from the groups' triangles, no
/// row is looked at again. It counts the rows of the triangles.
///
/// @param columns  b
/// @param weights  (number of groups), each positive
/// @throws InputError  where a group's columns are not those of its factor or among the b, or a weight is
///                     missing
[[nodiscard]] StreamingQr combined(std::span<const RowGroup> groups, Index columns,
                                   std::span<const double> weights);

/// χ̂ = argmin Σ_g ‖weights_g (Y_g − W_g χ)‖², Eq. (15) of [RIV]: from the combined() factor;
/// no row is looked at again, no normal equations are formed.
///
/// @param groups   at least one
/// @param columns  b
/// @param weights  (number of groups), each positive
/// @throws InputError  where a group's columns are not those of its factor or among the b, or a weight is
///                     missing
[[nodiscard]] LeastSquares least_squares(std::span<const RowGroup> groups, Index columns,
                                         std::span<const double> weights);

/// Standard deviation of the error of each group's rows, from a fit to this group alone, Eq. (20) of [RIV];
/// the rank of the group's own columns counts for the degrees of freedom. Never zero: rows that fit to
/// rounding get the rounding error of Y, and a group without rows gets 1. A group with fewer than five rows
/// for each of its columns nearly fits itself: its deviation is what the fit to all groups leaves of it, with
/// the degrees of freedom that this fit has there, a thousandth of the rms of its Y at least.
///
/// @throws InputError  where a group's columns are not those of its factor
[[nodiscard]] std::vector<double> group_sigmas(std::span<const RowGroup> groups);

/// Norm and sum of a weighted residual.
struct Residual {
  double norm = 0.0;
  double sum = 0.0;
  double y_norm = 0.0;
  Index rows = 0;
};

/// Norm and sum of the weighted residual over all groups.
///
/// @param chi      (b)
/// @param weights  (number of groups), each positive
/// @throws InputError  where a group's columns are not those of its factor or among the b, or a weight is
///                     missing
[[nodiscard]] Residual residual(std::span<const RowGroup> groups, const Eigen::Ref<const Vector>& chi,
                                std::span<const double> weights);

}  // namespace rivid
