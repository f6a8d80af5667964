#include "identify/least_squares_fit.hpp"

#include <cmath>
#include <optional>
#include <utility>

#include "identify/covariance.hpp"
#include "identify/essential_model.hpp"
#include "identify/fit.hpp"
#include "identify/physical_model.hpp"
#include "identify/robust_covariance.hpp"
#include "identify/robust_least_squares.hpp"
#include "identify/robust_report.hpp"
#include "identify/torque_lag.hpp"
#include "identify/verdict.hpp"
#include "rivid/error.hpp"

namespace rivid {

namespace {

using detail::all_factors;
using detail::describe_parameters;
using detail::deviation;
using detail::explain_rank;
using detail::joint_weights;
using detail::judged;

enum class Weights { none, by_joint };

// An estimate with what its statistics are made of.
struct Estimate {
  Vector chi;
  std::vector<double> weights;  // by joint
  LeastSquares solution;        // of an M-estimate RobustLeastSquares::information
  double sigma = 0.0;           // R / sigma is the root of the information
  Matrix unit_covariance;       // covariance for independent errors over sigma²
  double sigma_rho = 0.0;       // standard deviation of the weighted residual
  std::optional<detail::RowLoss> loss;
};

// out.C_chi and what comes with a second look at the rows.
void tell_uncertainty(const Robot& robot, std::span<const Log> logs, const Estimation& method,
                      const Estimate& estimate, double freedom, Identification& out) {
  detail::Uncertainty found =
      detail::classical_covariance(method.signal, estimate.sigma, estimate.unit_covariance, freedom);
  if (detail::resolved(method.covariance.kind, method.signal.convention) == CovarianceKind::hac) {
    detail::ThreadTeam team(method.threads);
    std::vector<detail::ScoredLog> scored;
    for (const Log& log : logs) {
      scored.push_back({&log, &method.signal, nullptr});
    }
    // What is not determined stays so.
    const LeastSquares& solution = estimate.solution;
    const Vector undetermined =
        solution.unit_covariance.diagonal().unaryExpr([](double x) { return std::isfinite(x) ? 0.0 : x; });
    Matrix bread = solution.unit_covariance;
    bread.diagonal() = bread.diagonal().unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; });
    const Index rows = static_cast<Index>(freedom) + solution.rank;
    const bool corrected = detail::leverage_counts(rows, out.base.size());
    const detail::Estimator estimator = {out.chi, false, corrected ? bread : Matrix()};
    const detail::RowLoss* const loss = estimate.loss ? &*estimate.loss : nullptr;
    const detail::Scores scores =
        detail::scores(robot, out.base, scored, std::span(&estimator, 1), out.weights, {}, team, {}, loss);
    if (loss != nullptr && solution.full_rank()) {
      bread = detail::bread_from_slopes(scores.curvature.front(), bread);
    }
    found = detail::hac_covariance(scores.series.front(), scores.interval, bread, method.covariance, freedom);
    found.C.diagonal() += undetermined;
    out.diagnostics =
        Diagnostics{.residuals = detail::residual_tests(robot, scores), .hausman = {}, .torque_lag = {}};
    if (loss == nullptr && method.signal.exact_rows()) {
      out.diagnostics->torque_lag =
          detail::torque_lag(out.base, scores, method.covariance, bread, found.C.diagonal().cwiseSqrt());
    }
  }
  out.C_chi = std::move(found.C);
  out.covariance = found.report;
}

// The estimate of the rows as they are.
Estimate plain_estimate(const RowFactors& data, std::vector<double> weights, const Identification& out) {
  Estimate estimate = {
      .chi = {}, .weights = std::move(weights), .solution = {}, .unit_covariance = {}, .loss = {}};
  estimate.solution = least_squares(data.groups, out.base.size(), estimate.weights);
  estimate.chi = estimate.solution.chi;
  const Residual weighted = residual(data.groups, estimate.chi, estimate.weights);
  const auto freedom = static_cast<double>(weighted.rows - estimate.solution.rank);
  if (freedom <= 0.0) {
    throw InputError("identify(" + out.title + "): " + std::to_string(weighted.rows) + " rows for " +
                     std::to_string(out.base.size()) +
                     " base parameters; more rows than parameters are needed");
  }
  estimate.sigma = estimate.sigma_rho = deviation(weighted, freedom, out.estimation.signal.convention);
  estimate.unit_covariance = estimate.solution.unit_covariance;
  return estimate;
}

// The M-estimate in its place, with out.robust.
Estimate robust_estimate(const Robot& robot, std::span<const Log> logs, const Estimation& method,
                         const Robust& robust, const RowFactors& data, const Estimate& plain,
                         Weights weighting, Identification& out) {
  detail::RobustLeastSquares found =
      detail::robust_least_squares(robot, out.base, logs, out.estimation.signal, data, plain.chi,
                                   weighting == Weights::by_joint, robust, method.threads, method.progress);
  detail::tell_robust(robot, robust, found.loss, found.sums, found.rounds, found.settled, plain.chi, out);
  return {.chi = std::move(found.chi),
          .weights = std::move(found.weights),
          .solution = std::move(found.information),
          .sigma = found.sigma,
          .unit_covariance = found.C / (found.sigma * found.sigma),
          .sigma_rho = found.deviation,
          .loss = std::move(found.loss)};
}

}  // namespace

void detail::least_squares_fit(const Robot& robot, std::span<const Log> logs, const Estimation& method,
                               Identification& out) {
  const SignalOptions& signal = method.signal;
  const Weights weighting = std::holds_alternative<Wls>(method.method) ? Weights::by_joint : Weights::none;
  const RowFactors data = all_factors(robot, out.base, logs, signal, method.threads, method.progress);

  const std::vector<double> ones(data.groups.size(), 1.0);
  Estimate estimate = plain_estimate(data,
                                     weighting == Weights::by_joint
                                         ? joint_weights(("identify(" + out.title + ")").c_str(), robot, data)
                                         : ones,
                                     out);
  if (weighting == Weights::none && data.undecimated.empty()) {
    out.R_diagonal = estimate.solution.R.diagonal().cwiseAbs();
  } else {
    const std::vector<RowGroup>& groups = data.undecimated.empty() ? data.groups : data.undecimated;
    out.R_diagonal = combined(groups, out.base.size(), ones).R().diagonal().cwiseAbs();
  }
  if (method.robust) {
    estimate = robust_estimate(robot, logs, method, *method.robust, data, estimate, weighting, out);
  }
  const LeastSquares& solution = estimate.solution;
  out.chi = estimate.chi;
  out.weights = estimate.weights;
  out.condition = solution.condition;
  if (!solution.full_rank()) {
    explain_rank(solution.rank, solution.undetermined, "these data", out);
  }
  out.fit = judged(robot, data, out.chi, solution.rank, signal.convention);
  out.fit.sigma_rho = estimate.sigma_rho;
  const auto freedom = static_cast<double>(out.fit.rows - solution.rank);
  tell_uncertainty(robot, logs, method, estimate, freedom, out);
  describe_parameters(robot, out);
  detail::judge_robust(out);
  detail::judge_torque_lag(out);
  detail::add_physical(robot, method.physical, data, solution.R / estimate.sigma, out);
  detail::judge_parameters(robot, logs, out);
  detail::add_essential(robot, method.essential, logs, data,
                        detail::decimation_factor(signal) / estimate.sigma * solution.R, freedom, out);
}

}  // namespace rivid
