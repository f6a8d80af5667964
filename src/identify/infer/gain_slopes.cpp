#include "identify/infer/gain_slopes.hpp"

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
  for (std::size_t j = 0; j < groups.size(); ++j) {
    const std::vector<Index>& columns = groups[j].columns;
    const Matrix R = estimate.weights[j] * groups[j].qr.R();
    const Vector Wt_tau = R.transpose() * (R * chi(columns));
    out.col(static_cast<Index>(j)) = fit.unit_covariance(Eigen::all, columns) * Wt_tau;
  }
  return out;
}

}  // namespace rivid::detail
