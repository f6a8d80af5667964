#include <utility>

#include "dense.hpp"
#include "identify/estimate/estimate.hpp"
#include "identify/rows/factors.hpp"

namespace rivid::detail {

namespace {

bool by_joint(const EstimationProblem& problem) {
  return std::holds_alternative<Wls>(problem.estimation.method);
}

std::vector<double> ones(const EstimationProblem& problem) {
  return std::vector<double>(problem.data.groups.size(), 1.0);
}

// Robot::total_mass, whose column the rows have on the other side: as good as exact.
LeastSquares with_known_mass(const EstimationProblem& problem, LeastSquares out) {
  // any small value: the data know no mass as well; a smaller one spoils the condition
  constexpr double relative_deviation = 1e-6;
  for (Index c = 0; c < problem.base.size(); ++c) {
    if (problem.robot.known_mass(problem.base.parameters[static_cast<std::size_t>(c)].leading)) {
      const double mass = *problem.robot.total_mass;
      const double deviation = relative_deviation * mass;
      Matrix both(out.R.rows() + 1, out.R.cols());
      both << out.R, Vector::Unit(out.R.cols(), c).transpose() / deviation;
      out.R = triangular_factor(both).topRows(out.R.cols());
      out.chi[c] = mass;
      out.unit_covariance(c, c) = deviation * deviation;
      out.rank += static_cast<Index>(std::erase(out.undetermined, std::vector<Index>{c}));
    }
  }
  return out;
}

// The estimate whose triangle and covariance these are, its chi and statistics aside.
Estimate estimate_of(const EstimationProblem& problem, const LeastSquares& solution, Estimated& out) {
  if (!solution.full_rank()) {
    explain_rank(problem.base, solution.rank, solution.undetermined, "these data", out);
  }
  return {.chi = solution.chi,
          .weights = {},
          .rows = rows_of(problem.data.groups),
          .rank = solution.rank,
          .condition = solution.condition,
          .root = solution.R,
          .unit_covariance = solution.unit_covariance,
          .bread = solution.unit_covariance,
          .signals = problem.signals,
          .loss = {},
          .instruments = {},
          .scores = {}};
}

// The estimate of the rows as they are.
//
// throws InputError where there are too few
LeastSquares plain_solution(const EstimationProblem& problem, const std::vector<double>& weights) {
  LeastSquares out =
      with_known_mass(problem, least_squares(problem.data.groups, problem.base.size(), weights));
  if (const Index rows = rows_of(problem.data.groups); rows <= out.rank) {
    problem.refuse_few_rows(rows);
  }
  return out;
}

// A⁻¹ B A⁻¹ on what is determined.
Matrix sandwich(const LeastSquares& A, const Matrix& root_B) {
  const Matrix half = root_B * finite_part(A.unit_covariance);
  Matrix out = half.transpose() * half;
  out.diagonal() += undetermined(A.unit_covariance);
  return out;
}

// Weights of the rows and parameters in turn, from the estimate `plain` on.
Estimate robust_estimate(const EstimationProblem& problem, const Robust& options, const Vector& plain,
                         Estimated& out) {
  const Index b = problem.base.size();
  const auto& progress = problem.estimation.progress;
  Reweighting reweighting(options, plain, problem.data.groups.size());
  std::vector<RowGroup> groups;
  const auto make_rows = [&] {
    groups = empty_groups(problem.data.groups);
    for (std::size_t k = 0; k < problem.logs.size(); ++k) {
      const JointSinks<FactorSink> factors = factor_sinks(groups);
      const ReweightedSinks weighted(factors.sinks(), &reweighting, groups, {});
      problem.send_rows(k, problem.signals[k], weighted.sinks());
      if (progress) {
        progress("round " + std::to_string(reweighting.rounds() + 1),
                 static_cast<double>(k + 1) / static_cast<double>(problem.logs.size()));
      }
    }
  };
  std::vector<double> weights;
  reweighting.settle(make_rows, [&] {
    weights = by_joint(problem) ? reweighting.weights() : ones(problem);
    const LeastSquares solution = with_known_mass(problem, least_squares(groups, b, weights));
    const double sigma = robust_deviation(reweighting.sums(), reweighting.loss(), weights);
    return Reweighting::Solution{solution.chi, sigma * solution.unit_covariance.diagonal().cwiseSqrt()};
  });
  report_robust(problem, options, reweighting, plain, out);
  const std::vector<RobustSums> sums = reweighting.sums();
  const RobustInformation information = robust_information(sums, reweighting.loss(), weights, b);
  const LeastSquares A = with_known_mass(problem, least_squares(problem.data.groups, b, information.bread));
  Estimate estimate = estimate_of(problem, A, out);
  const Matrix C = sandwich(A, combined(problem.data.groups, b, information.meat).R());
  estimate.unit_covariance = C / (information.sigma * information.sigma);
  estimate.chi = reweighting.chi();
  estimate.sigma = information.sigma;
  estimate.sigma_rho = robust_deviation(sums, reweighting.loss(), weights);
  estimate.loss = reweighting.loss();
  estimate.weights = std::move(weights);
  return estimate;
}

}  // namespace

void least_squares_estimate(const EstimationProblem& problem, Estimated& out) {
  std::vector<double> weights = by_joint(problem) ? joint_weights(problem) : ones(problem);
  const LeastSquares solution = plain_solution(problem, weights);
  if (const auto& robust = problem.estimation.robust) {
    out.estimate = robust_estimate(problem, *robust, solution.chi, out);
    return;
  }
  Estimate estimate = estimate_of(problem, solution, out);
  estimate.sigma = estimate.sigma_rho = deviation(residual(problem.data.groups, estimate.chi, weights),
                                                  estimate.freedom(), problem.estimation.signal.convention);
  estimate.weights = std::move(weights);
  out.estimate = std::move(estimate);
}

}  // namespace rivid::detail
