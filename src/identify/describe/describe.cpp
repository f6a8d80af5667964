#include "identify/describe/describe.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "identify/choose/row_choice.hpp"
#include "identify/rows/factors.hpp"
#include "identify/rows/row_source.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// The part of a bias by noise that the estimate at twice the window shows: nearly all of the bias is gone
// there. Two deviations more, so that it is all where the bias is small.
double borne_out(const Vector& bias, const Vector& change, const Vector& sigma) {
  const Vector expected = -bias.cwiseQuotient(sigma);
  const Vector found = change.cwiseQuotient(sigma);
  const double squares = expected.squaredNorm();
  const double part = found.dot(expected) / squares;
  const double deviation =
      (found - part * expected).norm() / std::sqrt(squares * static_cast<double>(bias.size()));
  return squares > 0.0 ? std::clamp(std::max(part, 0.0) + 2.0 * deviation, 0.0, 1.0) : 1.0;
}

// By what the choice of the rows moves the parameters, (b × shifts): the bias that noise is expected to
// leave, and estimates at neighbouring windows where these are too far away for chance. Instruments see no
// such noise, and have windows of their own.
Matrix row_shifts(const Answer& answer, Findings& out) {
  const EstimationProblem& problem = *answer.problem;
  const Inference& inference = answer.inference;
  const Index b = problem.base.size();
  Matrix shifts(b, 0);
  const bool knows_model = inference.uncertainty.report.kind == CovarianceKind::blocks;
  if (!answer.rows || answer.found.iv || !knows_model) {
    return shifts;
  }
  const auto add = [&](const Vector& shift) {
    shifts.conservativeResize(b, shifts.cols() + 1);
    shifts.col(shifts.cols() - 1) = shift;
  };
  const Vector sigma = inference.uncertainty.C.diagonal().cwiseSqrt();
  std::string moved;
  double most_moved = 0.0;
  if (inference.noise_bias.size() > 0) {
    const Vector& change = answer.rows->at_double.change;
    add(change.size() == b ? borne_out(inference.noise_bias, change, sigma) * inference.noise_bias
                           : inference.noise_bias);
  }
  for (const auto& [window, where] :
       {std::pair(&answer.rows->at_half, "half"), {&answer.rows->at_double, "double"}}) {
    constexpr double beyond_chance = 3.0;  // σ of the parameter; a choice: intervals of 2 σ do not cover it
    if (window->beyond_noise.size() != b) {
      continue;
    }
    const Vector& shift = window->beyond_noise;
    Index most = 0;
    if (const double largest = shift.cwiseAbs().cwiseQuotient(sigma).maxCoeff(&most);
        largest > beyond_chance) {
      add(shift);
      if (largest > most_moved) {
        most_moved = largest;
        moved = std::string("rows at ") + where + " their spacing move " +
                problem.base.parameters[static_cast<std::size_t>(most)].name + " by " + number(largest, 2) +
                " σ more than noise does: intervals are that much wider";
      }
    }
  }
  if (!moved.empty()) {
    out.add("window_shift", {}, std::move(moved));
  }
  return shifts;
}

std::vector<ParameterEstimate> parameters_of(const Answer& answer, const Matrix& C, const Vector& by_rows,
                                             const Alternatives& alternatives) {
  const Vector& shift = alternatives.shift;
  const EstimationProblem& problem = *answer.problem;
  const Inference& inference = answer.inference;
  const Vector a_priori = problem.base.from_standard(problem.robot.chi_st());
  const double t = inference.uncertainty.report.quantile_975;
  const Vector& plain = inference.uncertainty.plain_sigma;
  std::string codes;
  for (const ModelTest& test : alternatives.believed) {
    if (diagnostic_code(test.code)->severity == Severity::warning &&
        codes.find(test.code) == std::string::npos) {
      codes += (codes.empty() ? "" : ", ") + test.code;
    }
  }
  std::vector<ParameterEstimate> out;
  for (Index i = 0; i < problem.base.size(); ++i) {
    const BaseParameter& p = problem.base.parameters[static_cast<std::size_t>(i)];
    const double sigma = std::sqrt(C(i, i));
    const double value = std::isfinite(sigma) ? inference.chi[i] : std::numeric_limits<double>::quiet_NaN();
    ParameterEstimate& one = out.emplace_back();
    one.name = p.name;
    one.unit = p.unit;
    one.regrouped = p.regrouped;
    one.value = value;
    one.sigma = sigma;
    one.relative_sigma_percent = 100.0 * sigma / std::abs(value);
    one.plain_sigma = plain.size() > 0 ? plain[i] : std::sqrt(inference.uncertainty.C(i, i));
    one.interval_95 = {value - t * sigma, value + t * sigma};
    one.a_priori = a_priori[i];
    if (inference.noise_bias.size() > 0) {
      one.noise_bias = inference.noise_bias[i] / std::sqrt(inference.uncertainty.C(i, i));
    }
    one.row_shift = by_rows[i];
    if (shift.size() > 0) {
      one.model_shift = shift[i];
      one.widened_by = codes;
    }
  }
  const SquaredVelocities velocities = problem.factors != nullptr
                                           ? problem.factors->velocities
                                           : squared_velocities(problem.logs, problem.joints());
  judge_parameters(problem.robot, problem.base, C, velocities, out);
  return out;
}

// Deviations and intervals of what was estimated of the loop, and where the scale of all is from.
void describe_loop(const Inference& inference, OutputErrorReport& report) {
  // Part of the deviation beforehand that is left of a scale which positions do not show.
  constexpr double unseen = 0.7;
  const Matrix& C = inference.loop_C;
  if (report.loop.empty() || C.size() == 0) {
    return;
  }
  const double t = inference.uncertainty.report.quantile_975;
  Vector in_scale = Vector::Zero(C.rows());
  double before = 0.0;
  for (Index i = 0; i < C.rows(); ++i) {
    LoopEstimate& one = report.loop[static_cast<std::size_t>(i)];
    const double sigma = std::sqrt(C(i, i));
    if (one.joint.empty()) {
      one.sigma = sigma;
      one.interval_95 = {std::max(one.value - t * sigma, 0.0), one.value + t * sigma};
      continue;
    }
    one.sigma = std::abs(one.prior) * sigma;
    one.interval_95 = {one.value - t * one.sigma, one.value + t * one.sigma};
    // Gains in the unit of the control signal.
    if (one.name.front() == 'K' || one.name == "k_v") {
      in_scale[i] = 1.0;
      before += one.prior_sigma * one.prior_sigma / (one.prior * one.prior);
    }
  }
  const double after = in_scale.dot(C * in_scale);
  report.scale =
      before > 0.0 && after > unseen * unseen * before
          ? "positions do not show the scale of gains and parameters: it is that of drive_gain and of the "
            "gains in [control], which gain_sigma has right to " +
                number(100.0 * std::sqrt(after) / in_scale.sum(), 2) +
                " % (σ); a known mass or a data sheet tells more"
          : "the scale of gains and parameters is that of drive_gain and of what is known in [control]: "
            "positions do not show it";
}

// By what weights on the rows move the estimate.
void add_largest_shift(const std::vector<ParameterEstimate>& parameters, RobustReport& report) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ParameterEstimate& p = parameters[i];
    const double shift = std::abs(p.value - report.chi[static_cast<Index>(i)]) / p.sigma;
    if (shift > report.largest_shift) {
      report.largest_shift = shift;
      report.parameter = p.name;
    }
  }
}

// Uncertain by more than a row, or ten samples, a lag says nothing; the rows were chosen with what little it
// does.
bool says_something(const TorqueLag& lag, const SignalOptions& signal) {
  // samples; a choice: a lag with a larger σ tells neither sampling nor filters apart
  constexpr Index few = 10;
  return lag.sigma <= static_cast<double>(std::max(few, stride_of(signal)));
}

// What the numbers of the result say against it, with what the inference had to say.
void find_doubts(const Answer& answer, const Identification& result, Findings& out) {
  if (auto doubt = result.base.doubt()) {
    out.add("base_doubt", {}, std::move(*doubt));
  }
  if (answer.found.estimate) {
    find_noise(result, out);
    find_outliers(result, out);
    find_torque_lag(result, out);
    out.add(answer.inference.warnings);
    find_prefilter(result, out);
    find_loop(answer.found.error_with_V, result, out);
  }
}

}  // namespace

Identification described(const Answer& answer, const Judgement& judgement, Widened widened) {
  const EstimationProblem& problem = *answer.problem;
  const Estimated& found = answer.found;
  const Inference& inference = answer.inference;
  const auto tied = [&](const Matrix& moves) {
    return inference.tie.size() > 0 && moves.size() > 0 ? Matrix(inference.tie * moves) : moves;
  };
  const Alternatives alternatives = {judgement.alternatives.believed, tied(judgement.alternatives.shift)};
  const Vector& shift = alternatives.shift;
  Identification out;
  out.method = name(problem.estimation.method);
  out.title = std::string(title(problem.estimation.method)) + found.loss;
  out.status = found.status;
  out.reasons = found.reasons;
  out.estimation = problem.estimation;
  out.estimation.progress = {};
  out.base = problem.base;
  out.base.load.width.reset();
  if (has_load(problem.robot) && inference.chi.allFinite()) {
    out.base.load.chi = inference.chi;
  }
  out.chi = inference.chi;
  Findings findings;
  const Matrix by_rows = tied(row_shifts(answer, findings));
  const Vector row_shift = by_rows.rowwise().norm();
  out.C_chi = inference.uncertainty.C + by_rows * by_rows.transpose();
  out.gain_slopes = inference.gain_slopes;
  out.covariance = inference.uncertainty.report;
  out.parameters = parameters_of(answer, out.C_chi, row_shift, {});
  out.fit = inference.fit;
  out.columns = problem.base.size();
  out.condition = inference.condition;
  const RowFactors& data = problem.data;
  const bool plain = data.undecimated.empty() || std::holds_alternative<Iv>(problem.estimation.method);
  const std::vector<double> ones(data.groups.size(), 1.0);
  out.R_diagonal =
      combined(plain ? data.groups : data.undecimated, out.columns, ones).R().diagonal().cwiseAbs();
  out.weights = inference.weights;
  out.validation = answer.validation;
  out.alternatives = judgement.alternatives.believed;
  out.notes = inference.notes;
  out.notes.insert(out.notes.end(), answer.notes.begin(), answer.notes.end());
  out.row_choice = answer.rows;
  out.method_choice = answer.method;
  out.iv = found.iv;
  if (out.iv && found.estimate) {
    out.iv->least_squares = inference.least_squares;
  }
  out.prefilter = found.prefilter;
  if (out.prefilter && inference.unfiltered) {
    out.prefilter->sigma = inference.unfiltered->C.diagonal().cwiseSqrt();
    out.prefilter->covariance = inference.unfiltered->report;
  }
  out.output_error = found.output_error;
  if (out.output_error) {
    describe_loop(inference, *out.output_error);
  }
  out.robust = found.robust;
  out.diagnostics = inference.diagnostics;
  // By the deviations that errors in the rows make, which the other model does not widen.
  find_doubts(answer, out, findings);
  if (out.diagnostics && out.diagnostics->torque_lag &&
      !says_something(*out.diagnostics->torque_lag, out.estimation.signal)) {
    out.diagnostics->torque_lag.reset();
  }
  if (shift.size() > 0) {
    out.C_chi += shift * shift.transpose();
  }
  out.physical = inference.physical;
  if (found.estimate && !problem.logs.empty() && out.chi.allFinite()) {
    std::vector<Log> room;
    const auto logs = within_window(problem.logs, problem.estimation.signal, room);
    out.forecast = expected_error(problem.robot, out.base, logs, out.answer(), out.answer_covariance(),
                                  out.answer_fit());
  }
  if (widened != Widened::for_forecast && inference.of_choice.size() > 0) {
    out.C_chi += inference.of_choice;
  }
  if (widened == Widened::whole && inference.of_geometry.size() > 0) {
    out.C_chi += inference.of_geometry;
  }
  out.parameters = parameters_of(answer, out.C_chi, row_shift, alternatives);
  if (out.robust && found.estimate) {
    add_largest_shift(out.parameters, *out.robust);
  }
  out.essential = inference.essential;
  if (out.essential) {
    EssentialParameters& those = out.essential->parameters;
    those.C_chi = those.from * out.C_chi * those.from.transpose();
  }
  if (out.row_choice) {
    report_noise(out.parameters, *out.row_choice);
  }
  // A later iterate without instruments has reported the reason already.
  if (out.iv && found.estimate && out.status != Status::rank_deficient) {
    if (std::string weak = weakness_of_instruments(*out.iv, out.base); !weak.empty()) {
      out.status = out.status == Status::identified ? Status::weak_instruments : out.status;
      out.reasons.push_back(std::move(weak));
    }
  }
  findings.add(judgement.findings);
  if (findings.has("torque_delay")) {
    findings.drop("torque_lag");
  }
  out.warnings = std::move(findings).sorted();
  std::erase_if(out.warnings,
                [](const Finding& f) { return severity(f) == Severity::note && f.code != "not_tested"; });
  for (const Finding& finding : out.warnings) {
    if (severity(finding) == Severity::error &&
        (out.status == Status::identified || out.status == Status::doubtful)) {
      out.status = Status::doubtful;
      out.reasons.push_back(sentence(finding));
    }
  }
  return out;
}

}  // namespace rivid::detail
