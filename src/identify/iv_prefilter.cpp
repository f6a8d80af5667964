#include "identify/iv_prefilter.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "identify/iv_result.hpp"
#include "identify/prefilter.hpp"
#include "identify/row_source.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr int most_rounds = 10;

// The noise models that the residual of `chi` tells, one a joint.
std::vector<NoiseModel> noise_models(const IvProblem& problem, const IvSolver& solver, const Vector& chi) {
  const std::vector<RowGroup>& joints = problem.data.groups;
  const Instruments& instruments = solver.instruments();
  const Index order = problem.method.prefilter_order;
  const std::vector<Motion> V = instruments.motions(solver.last_loops().motions);
  std::vector<StreamingQr> lagged(joints.size(), StreamingQr(order > 0 ? order : Iv::most_prefilter_order));
  for (std::size_t k = 0; k < problem.logs.size(); ++k) {
    RowSource source(problem.robot, problem.base, problem.logs[k], instruments.signals()[k],
                     instruments.team());
    std::vector<LaggedResidualSink> own_sinks;
    own_sinks.reserve(lagged.size());
    std::vector<RowSink*> sinks;
    sinks.reserve(lagged.size());
    for (std::size_t j = 0; j < lagged.size(); ++j) {
      sinks.push_back(&own_sinks.emplace_back(lagged[j], chi(joints[j].columns), instruments.signs()[j]));
    }
    source.send(sinks, std::span(&V[k], 1));
  }
  std::vector<NoiseModel> out;
  out.reserve(lagged.size());
  for (std::size_t j = 0; j < lagged.size(); ++j) {
    Autoregression model = autoregression(lagged[j], order);
    out.push_back({problem.robot.joints[j].name, std::move(model.ar), model.innovation});
  }
  return out;
}

}  // namespace

void prefilter(const IvProblem& problem, IvSolver& solver, Identification& out) {
  const std::optional<IvEstimate>& unfiltered = solver.estimate();
  if (!unfiltered) {
    return;
  }
  PrefilterReport& report = out.prefilter.emplace();
  tell_uncertainty(problem, solver.instruments(), *unfiltered, out);
  report.chi = solver.history().back().chi;
  report.sigma = out.C_chi.diagonal().cwiseSqrt();
  report.covariance = out.covariance;
  solver.instruments().keep_every_row();
  while (report.rounds < most_rounds) {
    ++report.rounds;
    const Vector before = solver.history().back().chi;
    report.noise = noise_models(problem, solver, before);
    std::vector<Vector> ar;
    ar.reserve(report.noise.size());
    for (const NoiseModel& model : report.noise) {
      ar.push_back(model.ar);
    }
    solver.instruments().whiten(std::move(ar));
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

void judge_prefilter(Identification& out) {
  if (!out.prefilter) {
    return;
  }
  const PrefilterReport& report = *out.prefilter;
  std::string moved;
  for (Index i = 0; i < out.base.size(); ++i) {
    const ParameterEstimate& p = out.parameters[static_cast<std::size_t>(i)];
    const double half_width =
        std::max(report.covariance.quantile_975 * report.sigma[i], out.covariance.quantile_975 * p.sigma);
    if (std::abs(p.value - report.chi[i]) > half_width) {
      moved += (moved.empty() ? "" : ", ") + p.name + " (" + number(report.chi[i], 4) + " to " +
               number(p.value, 4) + ")";
    }
  }
  if (!moved.empty()) {
    out.warnings.push_back(
        Finding{"prefilter_shift",
                {},
                "the prefilter moves " + moved +
                    " by more than the 95 % intervals: the model of the robot is not right at the "
                    "frequencies that whitening amplifies; prefer the estimate without prefilter"});
  }
}

}  // namespace rivid::detail
