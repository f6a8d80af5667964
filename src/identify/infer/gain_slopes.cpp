#include "identify/infer/gain_slopes.hpp"

#include <variant>

#include "rivid/model/kinds.hpp"

namespace rivid::detail {

Matrix gain_slopes(const EstimationProblem& problem, const Estimate& estimate) {
  const Index b = problem.base.size();
  const std::vector<RowGroup>& groups = problem.data.groups;
  const LeastSquares fit = least_squares(groups, b, estimate.weights);
  Matrix out = Matrix::Zero(b, problem.joints());
  if (!fit.full_rank()) {
    return out;
  }
  // Rows of a tangent at some load give the torques without the part that stands on the left already.
  Vector chi = estimate.chi;
  for (Index i = 0; i < b; ++i) {
    if (about(problem.base.parameters[static_cast<std::size_t>(i)].leading.kind).basis == Basis::load) {
      chi[i] = 0.0;
    }
  }
  const bool of_these_rows = !std::holds_alternative<Iv>(problem.estimation.method) && !estimate.loss;
  for (std::size_t j = 0; j < groups.size(); ++j) {
    const std::vector<Index>& columns = groups[j].columns;
    const Matrix R = groups[j].qr.R();
    Vector tau = R * chi(columns);
    if (of_these_rows) {
      tau += groups[j].qr.qty() - R * estimate.chi(columns);
    }
    const double weight = estimate.weights[j] * estimate.weights[j];
    out.col(static_cast<Index>(j)) =
        fit.unit_covariance(Eigen::all, columns) * (weight * (R.transpose() * tau));
  }
  return out;
}

}  // namespace rivid::detail
