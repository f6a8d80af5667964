#include "rivid/identify/iv.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "identify/iv_prefilter.hpp"
#include "identify/iv_result.hpp"
#include "identify/iv_robust.hpp"

namespace rivid {

Identification identify(const Robot& robot, std::span<const Log> logs, const Iv& method) {
  const detail::IvProblem problem(robot, logs, method);
  detail::ThreadTeam team(std::max(method.threads, 1));
  Identification out;
  out.method = "iv";
  out.title = "IDIM-IV";
  out.signal = method.signal;
  out.base = problem.base;
  out.columns = problem.base.size();
  if (auto doubt = problem.base.doubt()) {
    out.warnings.push_back(Warning{"base_doubt", std::move(*doubt)});
  }
  detail::IvSolver solver(problem, team, out);
  const bool settled = solver.iterate(solver.start());
  const double with_V = solver.history().empty() ? std::numeric_limits<double>::quiet_NaN()
                                                 : solver.history().back().relative_error;
  if (settled && method.prefilter) {
    detail::prefilter(problem, solver, out);
  }
  if (settled && method.robust) {
    detail::make_robust(problem, solver, out);
  }
  detail::conclude(problem, solver, with_V, out);
  return out;
}

}  // namespace rivid
