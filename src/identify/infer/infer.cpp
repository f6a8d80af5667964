#include "identify/infer/infer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "identify/infer/covariance.hpp"
#include "identify/infer/noise_bias.hpp"
#include "identify/infer/parameter_set.hpp"
#include "identify/rows/factors.hpp"
#include "rivid/model/kinds.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/solve/inference.hpp"

namespace rivid {

namespace detail {

namespace {

double relative(double part, double whole) {
  return whole > 0.0 ? part / whole : std::numeric_limits<double>::quiet_NaN();
}

Scores scores_of(const EstimationProblem& problem, const Estimate& estimate,
                 const LeastSquares* by_least_squares) {
  const EstimateInstruments* const instruments = estimate.instruments ? &*estimate.instruments : nullptr;
  const bool corrected = leverage_counts(estimate.rows, problem.base.size());
  const auto estimator = [&](const Vector& chi, bool instrumental, const Matrix& bread) {
    return Estimator{chi, instrumental, corrected ? finite_part(bread) : Matrix()};
  };
  std::vector<Estimator> estimators = {estimator(estimate.chi, instruments != nullptr, estimate.bread)};
  if (by_least_squares != nullptr) {
    estimators.push_back(estimator(by_least_squares->chi, false, by_least_squares->unit_covariance));
  }
  static const EstimateInstruments none;
  const EstimateInstruments& by = instruments == nullptr ? none : *instruments;
  return scores(problem, estimate.signals, by.motions, estimators, estimate.weights, by.from_V, by.whitening,
                estimate.loss ? &*estimate.loss : nullptr);
}

// The comparison with least squares on the same rows.
HausmanTest hausman(const EstimationProblem& problem, const Estimate& estimate, const Scores& scores,
                    const LeastSquares& ls, const Matrix& bread, const Vector& sigma) {
  Matrix bread_ls = ls.unit_covariance;
  Vector shift = estimate.chi - ls.chi;
  if (estimate.loss) {
    // Least squares with the weights that the instruments' residuals gave is brought to its own M-estimate by
    // one step of Newton's.
    bread_ls = bread_from_slopes(scores.curvature[1], bread_ls);
    shift = bread_ls * (ls.R.transpose() * (ls.R * shift));
  }
  return hausman_test(problem.base, shift, scores.series[0], bread, scores.series[1], bread_ls,
                      scores.interval, problem.estimation.covariance, sigma);
}

Statistics classical_statistics(const Estimate& estimate) {
  return {.uncertainty = classical_covariance(estimate.signals.front(), estimate.sigma,
                                              estimate.unit_covariance, estimate.freedom()),
          .diagnostics = {},
          .blocks = {},
          .loop_C = {},
          .least_squares = {}};
}

// as in docs/statistics.md: Student's t, of 9 degrees of freedom, is 2.26; a choice
constexpr Index fewest_blocks = 10;

// Adds what the factor of a joint's rows [W Y] or [V | W Y] gives, with Z = V or W:
// Zᵀ W = R_ZZᵀ (Q_Zᵀ W) and Zᵀ (Y − W χ) = R_ZZᵀ (Q_Zᵀ Y − Q_Zᵀ W χ).
void add_to(BlockSums& sums, const std::vector<Index>& columns, const StreamingQr& qr, const Matrix& QtW,
            const Estimate& estimate, double weight) {
  const Matrix R = qr.R();
  sums.ZW(columns, columns) += weight * (R.transpose() * QtW);
  sums.Z_rho(columns) += weight * (R.transpose() * (qr.qty() - QtW * estimate.chi(columns)));
}

// Sums over blocks of time from their factors: some ten of all logs together, and of more logs one each as
// far as there are so many.
std::vector<BlockSums> block_sums(const LogFactors& factors, const Estimate& estimate) {
  const Index b = estimate.chi.size();
  const Index most = std::clamp(factors.logs, fewest_blocks, LogFactors::most_blocks);
  std::vector<BlockSums> out;
  const auto sum_up = [&](const auto& blocks, const auto& QtW) {
    for (const auto& block : fewer_blocks(blocks, most)) {
      BlockSums& sums = out.emplace_back(Matrix::Zero(b, b), Vector::Zero(b));
      for (std::size_t j = 0; j < block.size(); ++j) {
        add_to(sums, block[j].columns, block[j].qr, QtW(block[j].qr), estimate,
               estimate.weights[j] * estimate.weights[j]);
      }
    }
  };
  if (estimate.instruments) {
    sum_up(estimate.instruments->blocks,
           [](const StreamingQr& qr) { return Matrix(qr.qt_carried().leftCols(qr.columns())); });
  } else {
    sum_up(factors.blocks, [](const StreamingQr& qr) { return Matrix(qr.R()); });
  }
  return out;
}

// What blocks of time say without another look at the rows.
Statistics statistics_of_factors(const LogFactors& factors, const Estimate& estimate) {
  Statistics out = classical_statistics(estimate);
  out.blocks = block_sums(factors, estimate);
  if (estimate.rank == estimate.chi.size()) {
    scale_to_blocks(out.blocks, finite_part(estimate.bread), out.uncertainty);
  }
  return out;
}

// Of an estimate that compares something else than rows of torques.
Statistics statistics_of_scores(const Estimate& estimate, const EstimateScores& scores,
                                const CovarianceOptions& options, CovarianceKind kind) {
  const Matrix& bread = scores.bread;
  const Index b = estimate.chi.size();
  const Index g = scores.of_prior.size();
  Statistics out = {
      .uncertainty = hac_covariance(scores.series, scores.interval, bread, options, estimate.freedom()),
      .diagnostics = {},
      .blocks = {},
      .loop_C = {},
      .least_squares = {}};
  if (kind == CovarianceKind::classical) {
    out.uncertainty = {.C = estimate.sigma * estimate.sigma * bread,
                       .plain_sigma = {},
                       .report = {.kind = kind, .quantile_975 = student_quantile_975(estimate.freedom())}};
  } else if (kind == CovarianceKind::blocks) {
    const Uncertainty plain = out.uncertainty;
    scale_to_blocks(scores.blocks, bread, out.uncertainty);
    if (g > 0 && out.uncertainty.report.block_ratio < 1.0) {
      // Few blocks do not show less than so many unknowns take up.
      out.uncertainty = plain;
    }
  }
  Matrix& C = out.uncertainty.C;
  if (kind != CovarianceKind::classical) {
    // What was known beforehand was not exact.
    C += bread.rightCols(g) * scores.of_prior.asDiagonal() * bread.rightCols(g).transpose();
  }
  out.loop_C = C.bottomRightCorner(g, g);
  C = C.topLeftCorner(b, b).eval();
  if (Vector& plain = out.uncertainty.plain_sigma; plain.size() > b) {
    plain = plain.head(b).eval();
  }
  // Scores of χ without what the unknowns of the loop take up of them.
  const Matrix own = bread.leftCols(b) * (estimate.root.transpose() * estimate.root);
  for (const BlockSums& block : scores.blocks) {
    out.blocks.push_back({own.transpose() * block.ZW * own, own.transpose() * block.Z_rho});
  }
  return out;
}

// By what an estimate moves with the relative errors of the drive gains, dχ̂/dε of torques (1 + ε_j) y_j, (b
// × n).
//
// Least squares on the rows stand for instruments and for a loss, and the fitted torques for the measured
// ones there: both differ by noise alone. Zero where the rows do not determine all parameters.
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
  const bool of_these_rows = !std::holds_alternative<Iv>(problem.estimation.method) && !estimate.loss;
  for (std::size_t j = 0; j < groups.size(); ++j) {
    const std::vector<Index>& columns = groups[j].columns;
    const Matrix R = groups[j].qr.R();
    Vector tau = R * chi(columns);
    if (of_these_rows) {
      tau += groups[j].qr.qty() - R * estimate.chi(columns);
    }
    const double weight = estimate.weights[j] * estimate.weights[j];
    out.col(static_cast<Index>(j)) =
        fit.unit_covariance(Eigen::all, columns) * (weight * (R.transpose() * tau));
  }
  return out;
}

}  // namespace

Statistics statistics_of(const EstimationProblem& problem, const Estimate& estimate) {
  const CovarianceOptions& options = problem.estimation.covariance;
  const SignalOptions& signal = problem.estimation.signal;
  const CovarianceKind kind = resolved(options.kind, signal.convention);
  if (estimate.scores) {
    return statistics_of_scores(estimate, *estimate.scores, options, kind);
  }
  if (kind == CovarianceKind::classical) {
    return classical_statistics(estimate);
  }
  if (problem.factors != nullptr) {
    return statistics_of_factors(*problem.factors, estimate);
  }
  std::optional<LeastSquares> ls;
  if (estimate.instruments && problem.iv().compares == Iv::Compares::instruments) {
    ls = least_squares(estimate.instruments->used, problem.base.size(), estimate.weights);
  }
  const Scores found = scores_of(problem, estimate, ls ? &*ls : nullptr);
  Matrix bread = finite_part(estimate.bread);
  if (estimate.loss && estimate.rank == problem.base.size()) {
    bread = bread_from_slopes(found.curvature.front(), bread);
  }
  Statistics out = {
      .uncertainty = hac_covariance(found.series.front(), found.interval, bread, options, estimate.freedom()),
      .diagnostics =
          Diagnostics{.residuals = residual_tests(problem.robot, found), .hausman = {}, .torque_lag = {}},
      .blocks = {},
      .loop_C = {},
      .least_squares = {}};
  if (kind == CovarianceKind::blocks && estimate.rank == problem.base.size()) {
    scale_to_blocks(found.blocks, bread, out.uncertainty);
  }
  // Those of a loss are of its slopes and say nothing of predictions.
  out.blocks = estimate.loss ? std::vector<BlockSums>() : found.blocks;
  out.uncertainty.C.diagonal() += undetermined(estimate.bread);
  // What is known has no scores but for roundings.
  constexpr double rounding = 1e-12;
  out.uncertainty.C.diagonal() = (out.uncertainty.C.diagonal().array() <= rounding * bread.diagonal().array())
                                     .select(bread.diagonal(), out.uncertainty.C.diagonal());
  const Vector sigma = out.uncertainty.C.diagonal().cwiseSqrt();
  if (!estimate.loss && signal.exact_rows()) {
    out.diagnostics->torque_lag = torque_lag(problem.base, found, options, bread, sigma);
  }
  if (ls && ls->full_rank()) {
    out.diagnostics->hausman = hausman(problem, estimate, found, *ls, bread, sigma);
    out.least_squares = ls->chi;
  }
  return out;
}

namespace {

// Rows without an estimate have no errors.
void forget_errors(Fit& fit) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  fit.relative_error = fit.centred_relative_error = fit.error_norm = fit.sigma_rho = none;
  for (JointFit& joint : fit.joints) {
    joint.relative_error = joint.centred_relative_error = joint.sigma_rho = none;
  }
}

Inference without_estimate(const EstimationProblem& problem) {
  const Index b = problem.base.size();
  Inference out;
  out.condition = std::numeric_limits<double>::infinity();
  out.chi = Vector::Constant(b, std::numeric_limits<double>::quiet_NaN());
  out.uncertainty.C = Matrix::Constant(b, b, std::numeric_limits<double>::infinity());
  out.gain_slopes = Matrix::Zero(b, problem.joints());
  out.fit = fit_to(problem.robot, problem.rows_to_judge(), Vector::Zero(b), b,
                   problem.estimation.signal.convention);
  forget_errors(out.fit);
  return out;
}

}  // namespace

Inference inferred(const EstimationProblem& problem, const Estimated& found) {
  if (!found.estimate) {
    Inference out = without_estimate(problem);
    out.weights = found.weights;
    return out;
  }
  const Estimate& estimate = *found.estimate;
  Statistics statistics = statistics_of(problem, estimate);
  Inference out{.chi = estimate.chi,
                .weights = estimate.weights,
                .condition = estimate.condition,
                .uncertainty = std::move(statistics.uncertainty),
                .gain_slopes = gain_slopes(problem, estimate),
                .diagnostics = std::move(statistics.diagnostics),
                .least_squares = std::move(statistics.least_squares),
                .fit = fit_to(problem.robot, problem.rows_to_judge(), estimate.chi, estimate.rank,
                              problem.estimation.signal.convention)};
  out.fit.sigma_rho = estimate.sigma_rho;
  if (const Matrix& of_gains = problem.estimation.gain_covariance; of_gains.size() > 0) {
    out.uncertainty.C += out.gain_slopes * of_gains * out.gain_slopes.transpose();
  }
  if (const Matrix& of_choice = problem.estimation.choice_covariance; of_choice.rows() == out.chi.size()) {
    out.of_choice = of_choice;
  }
  out.of_geometry = geometry_covariance(problem, estimate);
  // Errors of the model last in the positions of a simulated loop, and no interval of these knows them: both
  // estimates of the loop differ by them, but for what a start with a wrong loop has. Gains of which the
  // poles are known are those of the start, and its scale is that of the estimate.
  out.loop_C = statistics.loop_C;
  if (found.output_error && found.output_error->loop.empty() && problem.iv().chi_0.size() == 0) {
    const Vector shift = out.chi - found.output_error->start;
    out.uncertainty.C += shift * shift.transpose();
    if (found.start) {
      out.uncertainty.C += statistics_of(problem, *found.start).uncertainty.C;
    }
  }
  if (found.unfiltered) {
    out.unfiltered = statistics_of(problem, *found.unfiltered).uncertainty;
  }
  if (!found.iv && !estimate.loss && problem.factors == nullptr) {
    out.noise_bias = noise_bias(problem, estimate, estimate.chi);
  }
  tie_twins(problem, estimate, out);
  if (out.tie.size() > 0) {
    Estimated those;
    those.status = found.status;
    those.estimate = problem.estimation.physical ? tied(estimate, out.tie) : estimate;
    add_physical(problem, those, {}, out);
    return out;
  }
  add_physical(problem, found, statistics.blocks, out);
  add_essential(problem, estimate, out);
  return out;
}

Fit fit_to(const Robot& robot, const RowFactors& data, const Vector& chi, Index estimated,
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
    // A joint that stands still has no row.
    const double mean_square = r.rows > 0 ? qr.y_sum() * qr.y_sum() / rows : 0.0;
    const double y_centred = std::sqrt(std::max(r.y_norm * r.y_norm - mean_square, 0.0));
    centred = std::hypot(centred, y_centred);
    fit.joints.push_back({.name = robot.joints[j].name,
                          .unit = robot.joints[j].type == JointType::revolute ? "N·m" : "N",
                          .rows = r.rows,
                          .left_out = data.left_out[j],
                          .velocity_threshold = data.thresholds[j],
                          .relative_error = relative(r.norm, r.y_norm),
                          .centred_relative_error = relative(r.norm, y_centred),
                          .sigma_rho = deviation(r, rows * freedom_share, convention)});
  }
  fit.centred_relative_error = relative(all.norm, centred);
  return fit;
}

}  // namespace detail

Validation validate(const Robot& robot, const Identification& identification, const Log& log, int threads) {
  detail::expect_values("validate", identification);
  const SignalOptions& signal = identification.estimation.signal;
  const auto rows = [&](const BaseParameters& base) { return factors(robot, base, log, signal, threads); };
  const RowFactors data = rows(identification.base);
  const bool own_load = has_load(robot);
  const auto fit = [&](const Vector& chi) {
    return own_load
               ? detail::fit_to(robot, rows(at_load(identification.base, chi)), chi, 0, signal.convention)
               : detail::fit_to(robot, data, chi, 0, signal.convention);
  };
  Validation out{log.source, fit(identification.chi), {}, {}, {}};
  out.forecast =
      detail::expected_error(data.groups, identification.answer_covariance(), identification.answer_fit());
  detail::ThreadTeam team(threads);
  out.fit.reference_error =
      detail::reference_error(robot, identification.base, std::span(&log, 1), identification.chi, team);
  if (identification.physical) {
    out.physical = fit(identification.physical->parameters.chi);
  }
  if (identification.essential) {
    out.essential = fit(identification.essential->parameters.chi);
  }
  return out;
}

}  // namespace rivid
