#include "identify/iv_robust.hpp"

#include <optional>
#include <vector>

#include "identify/robust_covariance.hpp"
#include "identify/robust_report.hpp"

namespace rivid::detail {

namespace {

// The estimate of weighted rows with the statistics of an M-estimate, which plain rows tell.
IvEstimate with_statistics(const IvProblem& problem, IvEstimate estimate, const Reweighting& reweighting,
                           const std::vector<InstrumentalGroup>& plain) {
  const Index b = problem.base.size();
  const std::vector<RobustSums> sums = reweighting.sums();
  const RobustInformation information = robust_information(sums, reweighting.loss(), estimate.weights, b);
  const InstrumentalVariables A = instrumental_variables(plain, b, information.bread);
  const Matrix root_B = instrumental_variables(plain, b, information.meat).R_VV;
  estimate.bread = bread_of(A);
  estimate.R_VW = A.R_VW;
  estimate.sigma = information.sigma;
  const Matrix half = root_B * estimate.bread.transpose() / estimate.sigma;
  estimate.unit_covariance = half.transpose() * half;
  estimate.sigma_rho = robust_deviation(sums, reweighting.loss(), estimate.weights);
  estimate.loss = reweighting.loss();
  return estimate;
}

}  // namespace

void make_robust(const IvProblem& problem, IvSolver& solver, Identification& out) {
  const std::optional<IvEstimate>& estimate = solver.estimate();
  const std::optional<Robust>& options = problem.estimation.robust;
  if (!estimate || !options) {
    return;
  }
  const Vector plain_chi = estimate->chi;
  const std::size_t plain_iterations = solver.history().size();
  Instruments& instruments = solver.instruments();
  Reweighting reweighting(*options, plain_chi, problem.data.groups.size());
  instruments.reweight(&reweighting);
  solver.iterate_again("the instruments with weights on the rows");
  instruments.reweight(nullptr);
  tell_robust(problem.robot, *options, reweighting.loss(), reweighting.sums(), reweighting.rounds(),
              reweighting.settled(), plain_chi, out);
  const std::vector<InstrumentalGroup> plain = solver.factors(solver.last_loops());
  const std::vector<IvIteration>& history = solver.history();
  if (history.size() > plain_iterations && history.back().chi == estimate->chi) {
    solver.replace_estimate(with_statistics(problem, *estimate, reweighting, plain));
  }
}

}  // namespace rivid::detail
