#include "rivid/identify/least_squares_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rivid/error.hpp"
#include "rivid/solve/student.hpp"

namespace rivid {

namespace {

void merge(std::vector<RowGroup>& into, std::vector<RowGroup> groups) {
  if (into.empty()) {
    into = std::move(groups);
    return;
  }
  for (std::size_t g = 0; g < into.size(); ++g) {
    into[g].qr.merge(groups[g].qr);
  }
}

// The factors of all logs.
RowFactors reduced(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                   const SignalOptions& signal, int threads, const Progress& progress) {
  RowFactors out;
  out.left_out.assign(static_cast<std::size_t>(robot.size()), 0);
  for (std::size_t k = 0; k < logs.size(); ++k) {
    const auto tell = [&](double fraction) {
      progress(logs[k].source, (static_cast<double>(k) + fraction) / static_cast<double>(logs.size()));
    };
    RowFactors part = factors(robot, base, logs[k], signal, threads,
                              progress ? std::function<void(double)>(tell) : std::function<void(double)>());
    merge(out.groups, std::move(part.groups));
    merge(out.undecimated, std::move(part.undecimated));
    for (std::size_t j = 0; j < out.left_out.size(); ++j) {
      out.left_out[j] += part.left_out[j];
    }
  }
  return out;
}

double relative(double part, double whole) {
  return whole > 0.0 ? part / whole : std::numeric_limits<double>::quiet_NaN();
}

// Deviation of a residual: (17) with its degrees of freedom, or MATLAB's std with the mean removed.
double deviation(const Residual& r, double freedom, Convention convention) {
  const auto rows = static_cast<double>(r.rows);
  if (convention == Convention::matlab) {
    return std::sqrt(std::max(r.norm * r.norm - r.sum * r.sum / rows, 0.0) / std::max(rows - 1.0, 1.0));
  }
  return r.norm / std::sqrt(std::max(freedom, 1.0));
}

// The model against the rows, unweighted. Each joint is charged its share of the b estimated parameters; a
// validation charges none.
Fit judged(const Robot& robot, const RowFactors& data, const Vector& chi, Index estimated,
           Convention convention) {
  Fit fit;
  const std::vector<double> ones(data.groups.size(), 1.0);
  const Residual all = residual(data.groups, chi, ones);
  fit.rows = all.rows;
  fit.error_norm = all.norm;
  fit.relative_error = relative(all.norm, all.y_norm);
  const double freedom_share = 1.0 - static_cast<double>(estimated) / static_cast<double>(all.rows);
  fit.sigma_rho = deviation(all, static_cast<double>(all.rows) * freedom_share, convention);
  double centred = 0.0;
  for (std::size_t j = 0; j < data.groups.size(); ++j) {
    const StreamingQr& qr = data.groups[j].qr;
    const Residual r = residual(std::span(&data.groups[j], 1), chi, std::span(ones.data(), 1));
    const auto rows = static_cast<double>(r.rows);
    const double y_centred = std::sqrt(std::max(r.y_norm * r.y_norm - qr.y_sum() * qr.y_sum() / rows, 0.0));
    centred = std::hypot(centred, y_centred);
    fit.joints.push_back({.name = robot.joints[j].name,
                          .unit = robot.joints[j].type == JointType::revolute ? "N·m" : "N",
                          .rows = r.rows,
                          .left_out = data.left_out[j],
                          .relative_error = relative(r.norm, r.y_norm),
                          .centred_relative_error = relative(r.norm, y_centred),
                          .sigma_rho = deviation(r, rows * freedom_share, convention)});
  }
  fit.centred_relative_error = relative(all.norm, centred);
  return fit;
}

void describe_parameters(const Robot& robot, double freedom, Identification& out) {
  const Vector a_priori = out.base.from_standard(robot.chi_st());
  const double t = student_quantile_975(freedom);
  for (Index i = 0; i < out.base.size(); ++i) {
    const BaseParameter& p = out.base.parameters[static_cast<std::size_t>(i)];
    const double sigma = std::sqrt(out.C_chi(i, i));
    const double value = std::isfinite(sigma) ? out.chi[i] : std::numeric_limits<double>::quiet_NaN();
    out.parameters.push_back({.name = p.name,
                              .unit = p.unit,
                              .regrouped = p.regrouped,
                              .value = value,
                              .sigma = sigma,
                              .relative_sigma_percent = 100.0 * sigma / std::abs(value),
                              .interval_95 = {value - t * sigma, value + t * sigma},
                              .a_priori = a_priori[i]});
  }
}

std::string joined(const BaseParameters& base, const std::vector<Index>& set) {
  std::string out;
  for (std::size_t i = 0; i < set.size(); ++i) {
    const char* const separator = i == 0 ? "" : i + 1 == set.size() ? " and " : ", ";
    out += separator + base.parameters[static_cast<std::size_t>(set[i])].name;
  }
  return out;
}

void explain_rank(const LeastSquares& solution, Identification& out) {
  out.status = Status::rank_deficient;
  for (const std::vector<Index>& set : solution.undetermined) {
    out.reasons.push_back(
        "rank " + std::to_string(solution.rank) + " of " + std::to_string(out.base.size()) + ": " +
        joined(out.base, set) +
        (set.size() == 1 ? " is not excited by these data" : " can not be told apart by these data"));
  }
}

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
  const RowFactors data = reduced(robot, out.base, logs, signal, method.threads, method.progress);

  out.weights.assign(data.groups.size(), 1.0);
  if (weighting == Weights::by_joint) {
    for (std::size_t j = 0; j < data.groups.size(); ++j) {
      if (data.groups[j].qr.y_norm() == 0.0) {
        throw InputError("identify(" + out.title + "): joint \"" + robot.joints[j].name +
                         "\": its torque is zero in every row, so its rows have no weight; check its column");
      }
    }
    std::ranges::transform(group_sigmas(data.groups), out.weights.begin(),
                           [](double sigma) { return 1.0 / sigma; });
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
    explain_rank(solution, out);
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
  const RowFactors data = reduced(robot, identification.base, std::span(&log, 1), signal, threads, {});
  return {log.source, judged(robot, data, identification.chi, 0, signal.convention)};
}

}  // namespace rivid
