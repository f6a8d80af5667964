#pragma once

#include "rivid/types.hpp"

namespace rivid::detail {

// A += weight JᵀJ, on the diagonal and below. J may be without rows, by which Eigen's rankUpdate() divides
// where A is large.
inline void add_gram(Matrix& A, const Eigen::Ref<const Matrix>& J, double weight = 1.0) {
  if (J.rows() > 0) {
    A.selfadjointView<Eigen::Lower>().rankUpdate(J.transpose(), weight);
  }
}

}  // namespace rivid::detail
