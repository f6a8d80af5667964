#include "identify/iv_result.hpp"

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/covariance.hpp"
#include "identify/essential_model.hpp"
#include "identify/fit.hpp"
#include "identify/iv_mismatch.hpp"
#include "identify/iv_prefilter.hpp"
#include "identify/physical_model.hpp"
#include "identify/robust_covariance.hpp"
#include "identify/robust_report.hpp"
#include "identify/verdict.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// First-stage F statistic below which instruments count as weak, after Staiger & Stock (1997).
constexpr double least_F = 10.0;

// Rows without an estimate have no errors.
void forget_errors(Fit& fit) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  fit.relative_error = fit.centred_relative_error = fit.error_norm = fit.sigma_rho = none;
  for (JointFit& joint : fit.joints) {
    joint.relative_error = joint.centred_relative_error = joint.sigma_rho = none;
  }
}

void conclude_without_estimate(const IvProblem& problem, const IvSolver& solver, Identification& out) {
  const Index b = problem.base.size();
  out.weights = solver.weights();
  out.condition = std::numeric_limits<double>::infinity();
  out.chi = Vector::Constant(b, std::numeric_limits<double>::quiet_NaN());
  out.C_chi = Matrix::Constant(b, b, std::numeric_limits<double>::infinity());
  out.fit = judged(problem.robot, problem.data, Vector::Zero(b), b, out.estimation.signal.convention);
  forget_errors(out.fit);
  describe_parameters(problem.robot, out);
  judge_parameters(problem.robot, problem.logs, out);
}

void judge_instruments(const Vector& F, Identification& out) {
  std::string weak;
  for (Index i = 0; i < F.size(); ++i) {
    if (!(F[i] > least_F)) {
      weak += (weak.empty() ? "" : ", ") + out.base.parameters[static_cast<std::size_t>(i)].name +
              " (F = " + number(F[i], 3) + ")";
    }
  }
  // A later iterate that lacks instruments altogether has told why already.
  if (weak.empty() || out.status == Status::rank_deficient) {
    return;
  }
  if (out.status == Status::identified) {
    out.status = Status::weak_instruments;
  }
  out.reasons.push_back(
      "the simulated motion says too little about " + weak + ", which need F above " + number(least_F) +
      "; the assumed loop moves otherwise than the actual one, so try a wider bandwidth, the "
      "actual gains, or a larger motion");
}

}  // namespace

void tell_uncertainty(const IvProblem& problem, const Instruments& instruments, const IvEstimate& estimate,
                      Identification& out) {
  const Estimation& method = problem.estimation;
  const std::vector<SignalOptions>& signals = instruments.signals();
  const double freedom = instruments.freedom();
  const Index b = problem.base.size();
  Uncertainty found =
      classical_covariance(signals.front(), estimate.sigma, estimate.unit_covariance, freedom);
  if (resolved(method.covariance.kind, method.signal.convention) == CovarianceKind::hac &&
      !estimate.motions.empty()) {
    const LeastSquares ls = least_squares(estimate.used, b, estimate.weights);
    const bool corrected = leverage_counts(instruments.rows(), b);
    const auto correction = [&](const Matrix& inverse) { return corrected ? inverse : Matrix(); };
    const std::array<Estimator, 2> estimators = {
        {{estimate.chi, true, correction(estimate.bread)}, {ls.chi, false, correction(ls.unit_covariance)}}};
    std::vector<ScoredLog> scored;
    scored.reserve(problem.logs.size());
    for (std::size_t k = 0; k < problem.logs.size(); ++k) {
      scored.push_back({&problem.logs[k], &signals[k], &estimate.motions[k]});
    }
    const RowLoss* const loss = estimate.loss ? &*estimate.loss : nullptr;
    const Scores found_scores = scores(problem.robot, problem.base, scored, estimators, estimate.weights,
                                       estimate.signs, instruments.team(), instruments.whitening(), loss);
    Matrix bread = estimate.bread;
    Matrix bread_ls = ls.unit_covariance;
    Vector shift = estimate.chi - ls.chi;
    if (loss != nullptr) {
      bread = bread_from_slopes(found_scores.curvature[0], bread);
      if (ls.full_rank()) {
        // Least squares with the weights that the instruments' residuals gave is brought to its own M-estimate by one
        // step of Newton's.
        bread_ls = bread_from_slopes(found_scores.curvature[1], bread_ls);
        shift = bread_ls * (ls.R.transpose() * (ls.R * shift));
      }
    }
    found = hac_covariance(found_scores.series[0], found_scores.interval, bread, method.covariance, freedom);
    out.diagnostics = Diagnostics{
        .residuals = residual_tests(problem.robot, found_scores), .hausman = {}, .torque_lag = {}};
    if (loss == nullptr && method.signal.exact_rows()) {
      out.diagnostics->torque_lag =
          torque_lag(problem.base, found_scores, method.covariance, bread, found.C.diagonal().cwiseSqrt());
    }
    if (ls.full_rank()) {
      out.diagnostics->hausman =
          hausman_test(problem.base, shift, found_scores.series[0], bread, found_scores.series[1], bread_ls,
                       found_scores.interval, method.covariance, found.C.diagonal().cwiseSqrt());
    }
  }
  out.C_chi = std::move(found.C);
  out.covariance = found.report;
}

void conclude(const IvProblem& problem, const IvSolver& solver, double with_V, Identification& out) {
  const Index b = problem.base.size();
  const std::vector<double> ones(problem.data.groups.size(), 1.0);
  out.R_diagonal = combined(problem.data.groups, b, ones).R().diagonal().cwiseAbs();
  IvHistory& history = out.iv.emplace();
  history.iterations = solver.history();
  const std::optional<IvEstimate>& found = solver.estimate();
  if (!found) {
    conclude_without_estimate(problem, solver, out);
    return;
  }
  const IvEstimate& estimate = *found;
  out.weights = estimate.weights;
  out.condition = estimate.condition_VW;
  out.chi = estimate.chi;
  tell_uncertainty(problem, solver.instruments(), estimate, out);
  out.fit = judged(problem.robot, problem.data, estimate.chi, b, out.estimation.signal.convention);
  out.fit.sigma_rho = estimate.sigma_rho;
  describe_parameters(problem.robot, out);
  judge_robust(out);
  judge_torque_lag(out);
  add_physical(problem.robot, problem.estimation.physical, problem.data, estimate.R_VW / estimate.sigma, out);
  judge_parameters(problem.robot, problem.logs, out);
  const double factor = decimation_factor(solver.instruments().signals().front());
  add_essential(problem.robot, problem.estimation.essential, problem.logs, problem.data,
                factor / estimate.sigma * estimate.R_VW, solver.instruments().freedom(), out);
  history.first_stage_F = estimate.first_stage_F;
  judge_instruments(history.first_stage_F, out);
  judge_prefilter(out);
  history.loop = diagnosed_loop(problem, solver.loops(), solver.last_loops(), out);
  diagnose_bandwidth(with_V, out);
}

}  // namespace rivid::detail
