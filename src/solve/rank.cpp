#include "solve/rank.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dense.hpp"

namespace rivid::detail {

ColumnScaled column_scaled(const Eigen::Ref<const Matrix>& R) {
  Vector norms = R.colwise().norm();
  norms = (norms.array() > 0.0).select(norms, 1.0);
  return {R * norms.cwiseInverse().asDiagonal(), norms};
}

double rank_tolerance(Index rows, Index columns) {
  return 16.0 * std::numeric_limits<double>::epsilon() *
         std::sqrt(static_cast<double>(std::max<Index>(rows, 1) * std::max<Index>(columns, 1)));
}

std::vector<std::vector<Index>> tied_columns(const Matrix& null_space) {
  constexpr double noise = 1e-6;
  const Index b = null_space.rows();
  // Projector onto the null space: its entry (i, k) is not zero when columns i and k take part in one dependency.
  const Matrix P = null_space * null_space.transpose();
  std::vector<std::vector<Index>> sets;
  std::vector<bool> seen(static_cast<std::size_t>(b), false);
  for (Index start = 0; start < b; ++start) {
    if (seen[static_cast<std::size_t>(start)] || P(start, start) < noise) {
      continue;
    }
    std::vector<Index> set = {start};
    seen[static_cast<std::size_t>(start)] = true;
    for (std::size_t head = 0; head < set.size(); ++head) {
      for (Index k = 0; k < b; ++k) {
        if (!seen[static_cast<std::size_t>(k)] && std::abs(P(set[head], k)) > noise) {
          seen[static_cast<std::size_t>(k)] = true;
          set.push_back(k);
        }
      }
    }
    std::ranges::sort(set);
    sets.push_back(std::move(set));
  }
  return sets;
}

double condition_number(const Matrix& R) {
  const Vector singular = singular_values(R);
  const double least = singular[singular.size() - 1];
  return least > 0.0 ? singular[0] / least : std::numeric_limits<double>::infinity();
}

}  // namespace rivid::detail
