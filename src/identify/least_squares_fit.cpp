#include "rivid/identify/least_squares_fit.hpp"

#include <cmath>

#include "identify/fit.hpp"
#include "identify/physical_model.hpp"
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
  out.C_chi = sigma * sigma * solution.unit_covariance;
  out.fit = judged(robot, data, out.chi, solution.rank, signal.convention);
  out.fit.sigma_rho = sigma;
  describe_parameters(robot, freedom, out);
  detail::add_physical(robot, method.physical, data, solution.R / sigma, out);
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
  Validation out{log.source, judged(robot, data, identification.chi, 0, signal.convention), {}};
  if (identification.physical) {
    out.physical = judged(robot, data, identification.physical->parameters.chi, 0, signal.convention);
  }
  return out;
}

}  // namespace rivid
