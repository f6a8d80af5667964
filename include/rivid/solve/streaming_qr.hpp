#pragma once

#include "rivid/types.hpp"

namespace rivid {

/// Orthogonal factorisation of [W Y] whose rows come block by block: only the triangle R, Qᵀ Y, the residual norm
/// and column sums are kept, so memory does not grow with the number of rows. Rows may come in any blocks, and
/// accumulators of parts of the rows may be merged in any order: the result is that of one factorisation of all
/// rows, to rounding.
class StreamingQr {
 public:
  /// @param columns  of W, at least 0
  explicit StreamingQr(Index columns);

  /// Adds rows.
  ///
  /// @param W  (rows × columns)
  /// @param Y  (rows)
  /// @throws InputError where the sizes do not fit
  void add(const Eigen::Ref<const Matrix>& W, const Eigen::Ref<const Vector>& Y);

  /// Adds all rows that another accumulator of the same columns has seen.
  void merge(const StreamingQr& other);

  [[nodiscard]] Index columns() const { return triangle_.cols() - 1; }
  [[nodiscard]] Index rows() const { return rows_; }

  /// R of W = Q R, upper triangular, (columns × columns).
  [[nodiscard]] Eigen::Block<const Matrix> R() const { return triangle_.topLeftCorner(columns(), columns()); }
  /// Qᵀ Y, (columns).
  [[nodiscard]] Vector qty() const { return triangle_.col(columns()).head(columns()); }
  /// Norm of the part of Y that no combination of the columns of W reaches.
  [[nodiscard]] double unreachable_norm() const;

  [[nodiscard]] const Vector& column_sums() const { return column_sums_; }  ///< 1ᵀ W, (columns)
  [[nodiscard]] double y_sum() const { return y_sum_; }                     ///< 1ᵀ Y
  [[nodiscard]] double y_norm() const;                                      ///< ‖Y‖

  /// ‖Y − W chi‖, without another look at the rows.
  [[nodiscard]] double residual_norm(const Eigen::Ref<const Vector>& chi) const;
  /// 1ᵀ (Y − W chi): the sum of the residual.
  [[nodiscard]] double residual_sum(const Eigen::Ref<const Vector>& chi) const;

 private:
  void reduce(Matrix& stacked);

  Matrix triangle_;     // factor of [W Y], (columns + 1)², upper triangular
  Vector column_sums_;  // 1ᵀ W
  double y_sum_ = 0.0;
  Index rows_ = 0;
};

}  // namespace rivid
