#include "identify/estimate/estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "accept.hpp"
#include "identify/estimate/fitting_factors.hpp"
#include "identify/rows/factors.hpp"
#include "rivid/error.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

std::string who(const EstimationProblem& problem) {
  return "identify(" + std::string(title(problem.estimation.method)) + ")";
}

// throws InputError for a log without a sampling rate
SignalOptions without_transient(const Log& log, SignalOptions signal, double transient) {
  if (const auto fault = log.complaint()) {
    throw InputError(*fault);
  }
  auto window = signal.window.value_or(std::array{log.t[0], log.t[log.samples() - 1]});
  window[0] = std::max(window[0], log.t[0] + transient);
  signal.window = window;
  return signal;
}

// Whether the rows are needed once more when their factors are known.
bool looks_again(const Estimation& estimation) {
  const bool plain_covariance = estimation.covariance.kind == CovarianceKind::classical ||
                                estimation.signal.convention == Convention::matlab;
  return std::holds_alternative<Iv>(estimation.method) || estimation.robust || !plain_covariance;
}

std::string joined(const BaseParameters& base, const std::vector<Index>& set) {
  std::string out;
  for (std::size_t i = 0; i < set.size(); ++i) {
    const char* const separator = i == 0 ? "" : i + 1 == set.size() ? " and " : ", ";
    out += separator + base.parameters[static_cast<std::size_t>(set[i])].name;
  }
  return out;
}

}  // namespace

EstimationProblem::EstimationProblem(const Robot& its_robot, std::span<const Log> its_logs,
                                     const Estimation& its_estimation, LoadPoint load)
    : robot(its_robot), logs(its_logs), estimation(its_estimation) {
  if (logs.empty()) {
    throw InputError(who(*this) + ": no log is given");
  }
  accept(who(*this), estimation.complaint(robot));
  base = base_parameters(robot);
  base.load = std::move(load);
  const Iv* const iv = std::get_if<Iv>(&estimation.method);
  if (iv != nullptr && iv->chi_0.size() > 0 && (iv->chi_0.size() != base.size() || !iv->chi_0.allFinite())) {
    throw InputError(who(*this) + ": chi_0 has " + counted(iv->chi_0.size(), "value") +
                     ", must have one, finite, for each of " + counted(base.size(), "base parameter"));
  }
  for (const Log& log : logs) {
    const bool all = iv == nullptr || iv->transient == 0.0;
    signals.push_back(all ? estimation.signal : without_transient(log, estimation.signal, iv->transient));
  }
  team = std::make_unique<ThreadTeam>(estimation.threads);
  data = all_factors(robot, base, logs, signals, *team, estimation.progress,
                     looks_again(estimation) ? &kept : nullptr);
  kept.resize(logs.size());
  if (has_load(robot)) {
    secant = all_factors(robot, at_load(base, base.load.chi), logs, signals, *team, {});
  }
}

void EstimationProblem::send_rows(std::size_t k, const SignalOptions& signal, std::span<RowSink* const> sinks,
                                  std::span<const Motion> others) const {
  if (kept[k] && signal.decimation == signals[k].decimation) {
    kept[k]->send(sinks, others);
    return;
  }
  RowSource(robot, base, logs[k], signal, *team).send(sinks, others);
}

EstimationProblem::EstimationProblem(const Robot& its_robot, const LogFactors& its_factors,
                                     const Estimation& its_estimation, const LoopAsk* its_ask)
    : robot(its_robot),
      estimation(its_estimation),
      base(base_parameters(robot)),
      factors(&its_factors),
      ask(its_ask),
      signals({estimation.signal}),
      data(its_factors.rows),
      team(std::make_unique<ThreadTeam>(1)) {
  accept(who(*this), estimation.complaint(robot));
  if (std::ssize(data.groups) != robot.size()) {
    throw InputError(who(*this) + ": the factors are of " + counted(std::ssize(data.groups), "joint") +
                     ", robot \"" + robot.name + "\" has " + std::to_string(robot.size()));
  }
  const RegressorBatch batch(robot, base.columns());
  std::vector<std::vector<Index>> columns;
  for (std::size_t j = 0; j < batch.joints(); ++j) {
    columns.push_back(batch.of_joint(j));
  }
  if (!fit(*factors, columns)) {
    throw InputError(who(*this) + ": the factors are not those of robot \"" + robot.name +
                     "\" and its friction laws");
  }
}

void EstimationProblem::refuse_few_rows(Index rows) const {
  throw InputError(who(*this) + ": " + std::to_string(rows) + " rows for " + std::to_string(base.size()) +
                   " base parameters; more rows than parameters are needed");
}

Estimated estimated(const EstimationProblem& problem) {
  Estimated out;
  if (std::holds_alternative<Iv>(problem.estimation.method)) {
    if (const Index rows = rows_of(problem.data.groups); rows <= problem.base.size()) {
      problem.refuse_few_rows(rows);
    }
    switch (problem.iv().compares) {
      case Iv::Compares::instruments:
        instrumental_estimate(problem, out);
        break;
      case Iv::Compares::torques:
        didim_estimate(problem, out);
        break;
      case Iv::Compares::positions:
        output_error_estimate(problem, out);
        break;
    }
  } else {
    least_squares_estimate(problem, out);
  }
  return out;
}

Matrix finite_part(Matrix covariance) {
  covariance.diagonal() =
      covariance.diagonal().unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; });
  return covariance;
}

Vector undetermined(const Matrix& covariance) {
  return covariance.diagonal().unaryExpr([](double x) { return std::isfinite(x) ? 0.0 : x; });
}

double deviation(const Residual& r, double freedom, Convention convention) {
  const auto rows = static_cast<double>(r.rows);
  if (convention == Convention::matlab) {
    return std::sqrt(std::max(r.norm * r.norm - r.sum * r.sum / rows, 0.0) / std::max(rows - 1.0, 1.0));
  }
  return r.norm / std::sqrt(std::max(freedom, 1.0));
}

std::vector<double> joint_weights(const EstimationProblem& problem) {
  const std::vector<RowGroup>& groups = problem.data.groups;
  for (auto j = static_cast<std::size_t>(problem.robot.base_joints); j < groups.size(); ++j) {
    if (groups[j].qr.rows() > 0 && groups[j].qr.y_norm() == 0.0) {
      throw InputError(who(problem) + ": joint \"" + problem.robot.joints[j].name +
                       "\": its torque is zero in every row, so its rows have no weight; check its column");
    }
  }
  std::vector<double> out = group_sigmas(groups);
  std::ranges::transform(out, out.begin(), [](double sigma) { return 1.0 / sigma; });
  return out;
}

std::optional<double> residual_weight(const RowGroup& group, const Vector& chi) {
  const double norm = group.qr.residual_norm(chi(group.columns));
  if (!(norm > 0.0)) {
    return std::nullopt;
  }
  // At least a part of the rows: other joints determine parameters of this one too.
  const Index freedom = std::max<Index>({group.qr.rows() - group.qr.columns(), group.qr.rows() / 10, 1});
  return std::sqrt(static_cast<double>(freedom)) / norm;
}

void explain_rank(const BaseParameters& base, Index rank, const std::vector<std::vector<Index>>& undetermined,
                  const std::string& what, Estimated& out) {
  out.status = Status::rank_deficient;
  std::vector<Index> unexcited;
  std::string alike;
  for (const std::vector<Index>& set : undetermined) {
    if (set.size() == 1) {
      unexcited.push_back(set.front());
    } else {
      alike += (alike.empty() ? "" : "; ") + joined(base, set);
    }
  }
  std::string reason = "rank " + std::to_string(rank) + " of " + std::to_string(base.size()) + ": ";
  if (!unexcited.empty()) {
    reason += joined(base, unexcited) + (unexcited.size() == 1 ? " is" : " are") + " not excited by " + what;
  }
  if (!alike.empty()) {
    reason += (unexcited.empty() ? "" : "; ") + alike + " can not be distinguished by " + what;
  }
  out.reasons.push_back(reason);
}

void report_robust(const EstimationProblem& problem, const Robust& options, const Reweighting& reweighting,
                   const Vector& plain, Estimated& out) {
  out.loss = options.kind == RobustKind::huber ? ", Huber" : ", bisquare";
  RobustReport& report = out.robust.emplace();
  report.options = options;
  report.rounds = reweighting.rounds();
  report.chi = plain;
  const std::vector<RobustSums> sums = reweighting.sums();
  for (std::size_t j = 0; j < sums.size(); ++j) {
    report.joints.push_back({.name = problem.robot.joints[j].name,
                             .scale = reweighting.loss().scales[j],
                             .rows = sums[j].rows,
                             .below_one = sums[j].below_one,
                             .below_half = sums[j].below_half,
                             .rejected = sums[j].rejected});
  }
  if (!reweighting.settled() && out.status == Status::identified) {
    out.status = Status::not_converged;
    out.reasons.push_back("the weights of the rows and the parameters do not settle on each other in " +
                          counted(options.max_rounds, "round"));
  }
}

}  // namespace rivid::detail
