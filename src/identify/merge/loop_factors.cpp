#include "rivid/identify/loop_factors.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "accept.hpp"
#include "identify/describe/describe.hpp"
#include "identify/estimate/fitting_factors.hpp"
#include "identify/estimate/instruments.hpp"
#include "identify/merge/unknown_to_factors.hpp"
#include "identify/rows/factors.hpp"
#include "rivid/error.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {

namespace {

// What the loops of logs that are elsewhere can not be asked for.
std::optional<std::string> unknown_to_loops(const Robot& robot, const Estimation& estimation) {
  const Iv* const iv = std::get_if<Iv>(&estimation.method);
  if (iv == nullptr) {
    return "the method simulates no loops; factors of the logs serve ordinary and weighted least squares";
  }
  if (iv->compares != Iv::Compares::instruments) {
    return std::string(title(estimation.method)) +
           " needs all samples; identify from the logs themselves, or by instrumental variables";
  }
  if (iv->prefilter) {
    return "prefilter needs the residuals of all rows; identify from the logs themselves";
  }
  if (iv->transient > 0.0) {
    return "transient leaves out samples that factors of the logs have; cut the logs, or identify from these";
  }
  return detail::unknown_to_factors(robot, estimation);
}

void find_speeds(const detail::AuxiliaryLoop& loop, LoopFactors& out) {
  out.mean_speeds = loop.measured().qd.cwiseAbs().colwise().mean().transpose();
  out.mean_squares = loop.measured().qd.cwiseAbs2().colwise().mean().transpose();
}

void find_inertias(const Robot& robot, const detail::AuxiliaryLoop& loop, const LoopRequest& request,
                   LoopFactors& out) {
  try {
    out.J = design_inertia(DynamicModel(robot, request.chi_st), loop.measured().q);
  } catch (const NumericsError& error) {
    out.failure = error.what();
  }
}

void find_rows(const Robot& robot, const Log& log, const Estimation& estimation, const LoopRequest& request,
               int blocks, LoopFactors& out) {
  const detail::EstimationProblem problem(robot, std::span(&log, 1), estimation);
  const detail::ClosedLoops loops(problem);
  const detail::SimulatedLoops simulated = loops.simulated(request);
  out.effort = simulated.effort;
  out.failure = simulated.failure;
  out.gave_up = simulated.gave_up;
  out.simulated_signs = request.simulated_signs;
  if (!out.failure.empty()) {
    return;
  }
  detail::Instruments instruments(problem);
  if (blocks > 1) {
    out.blocks.assign(static_cast<std::size_t>(blocks), instruments.no_rows());
    instruments.divide_into(out.blocks);
  }
  out.groups = instruments.factors(loops, simulated,
                                   request.simulated_signs ? detail::FromV::signs : detail::FromV::none);
  if (blocks == 1) {
    out.blocks = {out.groups};
  }
  if (request.simulated_signs) {
    out.used = instruments.used();
  }
  out.sums = loops.sums_with_control(simulated);
}

// throws InputError where `same` does not hold
void expect_same_request(bool same) {
  if (!same) {
    throw InputError("merge: the factors are of different robots, options or requests");
  }
}

// Adds numbers that may not be there yet.
template <typename Numbers>
void add_numbers(Numbers& into, const Numbers& other) {
  if (into.size() == 0) {
    into = other;
  } else if (other.size() > 0) {
    expect_same_request(into.rows() == other.rows() && into.cols() == other.cols());
    into += other;
  }
}

void add_sums(LoopSums& into, const LoopSums& other) {
  for (const auto part :
       {&LoopSums::off_measured, &LoopSums::measured, &LoopSums::off_reference, &LoopSums::reference}) {
    add_numbers(into.*part, other.*part);
  }
  for (const auto part : {&LoopSums::tracking, &LoopSums::missed, &LoopSums::control, &LoopSums::moving}) {
    add_numbers(into.*part, other.*part);
  }
  into.samples += other.samples;
}

}  // namespace

LoopFactors loop_factors(const Robot& robot, const Log& log, const Estimation& estimation,
                         const LoopRequest& request, int blocks) {
  if (blocks < 1 || blocks > LogFactors::most_blocks) {
    throw InputError("loop_factors: blocks is " + std::to_string(blocks) + ", must lie between 1 and " +
                     std::to_string(LogFactors::most_blocks));
  }
  detail::accept("loop_factors", unknown_to_loops(robot, estimation));
  detail::accept("loop_factors", estimation.complaint(robot));
  if (const auto fault = log.complaint()) {
    throw InputError(*fault);
  }
  detail::require_joints("position", log.q, robot, log);
  const std::size_t standard = request.pass == LoopPass::speeds ? 0 : robot.standard_parameters().size();
  if (request.chi_st.size() != static_cast<Index>(standard) ||
      request.J.size() != (request.pass == LoopPass::rows ? robot.size() : 0)) {
    throw InputError("loop_factors: the request is not of robot \"" + robot.name + "\"");
  }
  LoopFactors out;
  out.logs = 1;
  if (request.pass == LoopPass::rows) {
    find_rows(robot, log, estimation, request, blocks, out);
    return out;
  }
  const detail::AuxiliaryLoop loop(robot, log, estimation.signal, std::get<Iv>(estimation.method));
  if (request.pass == LoopPass::speeds) {
    find_speeds(loop, out);
  } else {
    find_inertias(robot, loop, request, out);
  }
  return out;
}

void merge(LoopFactors& into, const LoopFactors& other) {
  if (other.logs == 0) {
    return;
  }
  if (into.logs == 0) {
    into = other;
    return;
  }
  const bool failed = !into.failure.empty() || !other.failure.empty();
  expect_same_request(failed || into.groups.empty() == other.groups.empty());
  if (!into.groups.empty() && !other.groups.empty()) {
    const std::vector<std::vector<Index>> columns = detail::columns_of(into.groups);
    expect_same_request(detail::fit(into, columns) && detail::fit(other, columns) &&
                        into.simulated_signs == other.simulated_signs &&
                        into.used.size() == other.used.size());
  }
  into.logs += other.logs;
  if (into.failure.empty()) {
    into.failure = other.failure;
    into.gave_up = other.gave_up;
  }
  add_numbers(into.mean_speeds, other.mean_speeds);
  add_numbers(into.mean_squares, other.mean_squares);
  into.J = into.J.size() == other.J.size() ? Vector(into.J.cwiseMax(other.J)) : Vector();
  detail::add(into.effort, other.effort);
  if (!into.failure.empty()) {
    into.groups.clear();
    into.used.clear();
    into.blocks.clear();
    return;
  }
  detail::merge_groups(into.groups, other.groups);
  detail::merge_groups(into.used, other.used);
  into.blocks.insert(into.blocks.end(), other.blocks.begin(), other.blocks.end());
  into.blocks = detail::fewer_blocks(std::move(into.blocks), LogFactors::most_blocks);
  add_sums(into.sums, other.sums);
}

Identification identify(const Robot& robot, const LogFactors& factors, const Estimation& estimation,
                        const LoopAsk& ask) {
  if (!ask) {
    throw InputError("identify: ask is empty, must carry out a pass over the logs");
  }
  detail::accept("identify", unknown_to_loops(robot, estimation));
  return described(
      detail::Answer(std::make_unique<detail::EstimationProblem>(robot, factors, estimation, &ask)), {},
      detail::Widened::whole);
}

}  // namespace rivid
