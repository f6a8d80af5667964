#include "rivid/identify/least_squares_fit.hpp"

#include <cmath>

#include "identify/covariance.hpp"
#include "identify/essential_model.hpp"
#include "identify/fit.hpp"
#include "identify/physical_model.hpp"
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

// out.C_chi and what comes with a second look at the rows.
template <typename Method>
void tell_uncertainty(const Robot& robot, std::span<const Log> logs, const Method& method,
                      const LeastSquares& solution, double sigma, double freedom, Identification& out) {
  detail::Uncertainty found =
      detail::classical_covariance(method.signal, sigma, solution.unit_covariance, freedom);
  if (detail::resolved(method.covariance.kind, method.signal.convention) == CovarianceKind::hac) {
    detail::ThreadTeam team(method.threads);
    std::vector<detail::ScoredLog> scored;
    for (const Log& log : logs) {
      scored.push_back({&log, &method.signal, nullptr});
    }
    // What is not determined stays so.
    const Vector undetermined =
        solution.unit_covariance.diagonal().unaryExpr([](double x) { return std::isfinite(x) ? 0.0 : x; });
    Matrix bread = solution.unit_covariance;
    bread.diagonal() = bread.diagonal().unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; });
    const Index rows = static_cast<Index>(freedom) + solution.rank;
    const bool corrected = detail::leverage_counts(rows, out.base.size());
    const detail::Estimator estimator = {out.chi, false, corrected ? bread : Matrix()};
    const detail::Scores scores =
        detail::scores(robot, out.base, scored, std::span(&estimator, 1), out.weights, {}, team);
    found = detail::hac_covariance(scores.series.front(), scores.interval, bread, method.covariance, freedom);
    found.C.diagonal() += undetermined;
    out.diagnostics = Diagnostics{.residuals = detail::residual_tests(robot, scores), .hausman = {}};
  }
  out.C_chi = std::move(found.C);
  out.covariance = found.report;
}

template <typename Method>
Identification least_squares_fit(const Robot& robot, std::span<const Log> logs, const Method& method,
                                 Weights weighting) {
  const SignalOptions& signal = method.signal;
  Identification out;
  out.method = weighting == Weights::none ? "ols" : "wls";
  out.title = weighting == Weights::none ? "IDIM-OLS" : "IDIM-WLS";
  if (logs.empty()) {
    throw InputError("identify(" + out.title + "): no log is given");
  }
  if (const auto fault = method.covariance.complaint()) {
    throw InputError("identify(" + out.title + "): " + *fault);
  }
  if (const auto fault = method.essential ? method.essential->complaint() : std::nullopt) {
    throw InputError("identify(" + out.title + "): essential: " + *fault);
  }
  out.signal = signal;
  out.base = base_parameters(robot);
  if (auto doubt = out.base.doubt()) {
    out.warnings.push_back(std::move(*doubt));
  }
  const RowFactors data = all_factors(robot, out.base, logs, signal, method.threads, method.progress);

  out.weights.assign(data.groups.size(), 1.0);
  if (weighting == Weights::by_joint) {
    out.weights = joint_weights(("identify(" + out.title + ")").c_str(), robot, data);
  }
  const LeastSquares solution = least_squares(data.groups, out.base.size(), out.weights);
  out.chi = solution.chi;
  out.columns = out.base.size();
  out.condition = solution.condition;
  if (weighting == Weights::none && data.undecimated.empty()) {
    out.R_diagonal = solution.R.diagonal().cwiseAbs();
  } else {
    const std::vector<RowGroup>& groups = data.undecimated.empty() ? data.groups : data.undecimated;
    const std::vector<double> ones(groups.size(), 1.0);
    out.R_diagonal = combined(groups, out.base.size(), ones).R().diagonal().cwiseAbs();
  }
  if (!solution.full_rank()) {
    explain_rank(solution.rank, solution.undetermined, "these data", out);
  }

  const Residual weighted = residual(data.groups, out.chi, out.weights);
  const auto freedom = static_cast<double>(weighted.rows - solution.rank);
  if (freedom <= 0.0) {
    throw InputError("identify(" + out.title + "): " + std::to_string(weighted.rows) + " rows for " +
                     std::to_string(out.base.size()) +
                     " base parameters; more rows than parameters are needed");
  }
  const double sigma = deviation(weighted, freedom, signal.convention);
  tell_uncertainty(robot, logs, method, solution, sigma, freedom, out);
  out.fit = judged(robot, data, out.chi, solution.rank, signal.convention);
  out.fit.sigma_rho = sigma;
  describe_parameters(robot, out);
  detail::add_physical(robot, method.physical, data, solution.R / sigma, out);
  detail::judge_parameters(robot, logs, out);
  detail::add_essential(robot, method.essential, logs, data,
                        detail::decimation_factor(signal) / sigma * solution.R, freedom, out);
  return out;
}

}  // namespace

Identification identify(const Robot& robot, std::span<const Log> logs, const Ols& method) {
  return least_squares_fit(robot, logs, method, Weights::none);
}

Identification identify(const Robot& robot, std::span<const Log> logs, const Wls& method) {
  return least_squares_fit(robot, logs, method, Weights::by_joint);
}

Validation validate(const Robot& robot, const Identification& identification, const Log& log, int threads) {
  const SignalOptions& signal = identification.signal;
  const RowFactors data = all_factors(robot, identification.base, std::span(&log, 1), signal, threads, {});
  Validation out{log.source, judged(robot, data, identification.chi, 0, signal.convention), {}, {}};
  if (identification.physical) {
    out.physical = judged(robot, data, identification.physical->parameters.chi, 0, signal.convention);
  }
  if (identification.essential) {
    out.essential = judged(robot, data, identification.essential->parameters.chi, 0, signal.convention);
  }
  return out;
}

}  // namespace rivid
