#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "identify/estimate/iv_solver.hpp"
#include "identify/rows/whitened_rows.hpp"
#include "ranges.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr int most_rounds = 10;  // of noise models and instruments; a choice that ends what does not settle

// The noise models of the residual of `chi`, one a joint.
std::vector<NoiseModel> noise_models(const EstimationProblem& problem, const IvSolver& solver,
                                     const Vector& chi) {
  const std::vector<RowGroup>& joints = problem.data.groups;
  const Instruments& instruments = solver.instruments();
  const Index order = problem.iv().prefilter_order;
  const std::vector<Motion> V = instruments.motions(solver.last_loops().motions);
  std::vector<StreamingQr> lagged(joints.size(), StreamingQr(order > 0 ? order : Iv::most_prefilter_order));
  for (std::size_t k = 0; k < problem.logs.size(); ++k) {
    const JointSinks<LaggedResidualSink> sinks(lagged.size(), [&](std::size_t j) {
      return LaggedResidualSink(lagged[j], chi(joints[j].columns), instruments.from_V()[j]);
    });
    problem.send_rows(k, instruments.signals()[k], sinks.sinks(), std::span(&V[k], 1));
  }
  std::vector<NoiseModel> out;
  out.reserve(lagged.size());
  for (std::size_t j = 0; j < lagged.size(); ++j) {
    Autoregression model = autoregression(lagged[j], order);
    out.push_back({problem.robot.joints[j].name, std::move(model.ar), model.innovation});
  }
  return out;
}

// Noise models and instruments in turn, with out.prefilter.
//
// solver  that has settled
void prefilter(const EstimationProblem& problem, IvSolver& solver, Estimated& out) {
  PrefilterReport& report = out.prefilter.emplace();
  report.chi = solver.history().back().chi;
  solver.instruments().keep_every_row();
  while (report.rounds < most_rounds) {
    ++report.rounds;
    const Vector before = solver.history().back().chi;
    report.noise = noise_models(problem, solver, before);
    solver.instruments().whiten(made_of(report.noise, &NoiseModel::ar));
    const bool settled = solver.iterate_again("the whitened instruments");
    report.rows = solver.instruments().rows();
    if (!settled || solver.stands_still(solver.history().back().chi - before)) {
      return;
    }
  }
  out.status = Status::not_converged;
  out.reasons.push_back("noise models and parameters do not settle on each other in " +
                        counted(most_rounds, "round") + " of the prefilter");
}

// The estimate of weighted rows with the statistics of an M-estimate, which come from plain rows.
Estimate with_statistics(const EstimationProblem& problem, Estimate estimate, const Reweighting& reweighting,
                         const std::vector<InstrumentalGroup>& plain) {
  const Index b = problem.base.size();
  const std::vector<RobustSums> sums = reweighting.sums();
  const RobustInformation information = robust_information(sums, reweighting.loss(), estimate.weights, b);
  const InstrumentalVariables A = instrumental_variables(plain, b, information.bread);
  const Matrix root_B = instrumental_variables(plain, b, information.meat).R_VV;
  estimate.bread = bread_of(A);
  estimate.root = A.R_VW;
  estimate.sigma = information.sigma;
  const Matrix half = root_B * estimate.bread.transpose() / estimate.sigma;
  estimate.unit_covariance = half.transpose() * half;
  estimate.sigma_rho = robust_deviation(sums, reweighting.loss(), estimate.weights);
  estimate.loss = reweighting.loss();
  return estimate;
}

// The M-estimate by instruments, Σ V_tᵀ ω² s ψ_t = 0, with out.robust: weights on rows and instruments in
// turn.
//
// solver  that has settled at the estimate `plain_chi`
std::optional<Estimate> robust_estimate(const EstimationProblem& problem, const Robust& options,
                                        const Vector& plain_chi, IvSolver& solver, Estimated& out) {
  const std::size_t plain_iterations = solver.history().size();
  Instruments& instruments = solver.instruments();
  Reweighting reweighting(options, plain_chi, problem.data.groups.size());
  instruments.reweight(&reweighting);
  solver.iterate_again("the instruments with weights on the rows");
  instruments.reweight(nullptr);
  report_robust(problem, options, reweighting, plain_chi, out);
  const std::vector<InstrumentalGroup> plain = solver.factors(solver.last_loops());
  const std::optional<Estimate>& found = solver.estimate();
  const std::vector<IvIteration>& history = solver.history();
  const bool has_own_rows = found && history.size() > plain_iterations && history.back().chi == found->chi;
  return has_own_rows ? std::optional(with_statistics(problem, *found, reweighting, plain)) : found;
}

// How the solver came to out.estimate, with out.iv.
void keep_history(const EstimationProblem& problem, IvSolver& solver, Estimated& out) {
  out.weights = solver.weights();
  IvHistory& history = out.iv.emplace();
  if (out.estimate && out.estimate->instruments) {
    history.first_stage_F = out.estimate->instruments->first_stage_F;
    history.loop = diagnosed_loop(problem, solver.loops().sums_with_control(solver.last_loops()));
  }
  history.iterations = std::move(solver.history());
}

}  // namespace

void instrumental_estimate(const EstimationProblem& problem, Estimated& out) {
  IvSolver solver(problem, out);
  const bool settled = solver.iterate(solver.start());
  if (!solver.history().empty()) {
    out.error_with_V = solver.history().back().relative_error;
  }
  if (settled && problem.iv().prefilter) {
    out.unfiltered = solver.estimate();
    prefilter(problem, solver, out);
  }
  out.estimate = solver.estimate();
  if (const auto& robust = problem.estimation.robust; settled && robust && out.estimate) {
    out.estimate = robust_estimate(problem, *robust, out.estimate->chi, solver, out);
  }
  keep_history(problem, solver, out);
}

std::optional<Vector> start_of_loop_fit(const EstimationProblem& problem, Estimated& out) {
  if (problem.iv().chi_0.size() > 0) {
    out.iv.emplace();
    return problem.iv().chi_0;
  }
  instrumental_estimate(problem, out);
  out.start = std::exchange(out.estimate, std::nullopt);
  out.error_with_V = std::numeric_limits<double>::quiet_NaN();
  if (!out.start || out.status != Status::identified) {
    out.reasons.push_back(std::string(title(problem.estimation.method)) +
                          " begins with the estimate of IDIM-IV, which there is none of");
    return std::nullopt;
  }
  // Instruments gave the start alone.
  out.iv->first_stage_F.resize(0);
  return out.start->chi;
}

void didim_estimate(const EstimationProblem& problem, Estimated& out) {
  const std::optional<Vector> start = start_of_loop_fit(problem, out);
  if (!start) {
    return;
  }
  IvSolver solver(problem, out, Iv::Compares::torques);
  solver.iterate(*start);
  if (!solver.history().empty()) {
    out.error_with_V = solver.history().back().relative_error;
  }
  out.estimate = solver.estimate();
  keep_history(problem, solver, out);
}

}  // namespace rivid::detail
