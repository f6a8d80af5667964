#include "identify/iv.hpp"

#include <limits>
#include <utility>

#include "identify/iv_prefilter.hpp"
#include "identify/iv_result.hpp"
#include "identify/iv_robust.hpp"

namespace rivid::detail {

void instrumental_fit(const Robot& robot, std::span<const Log> logs, const Estimation& method,
                      Identification& out) {
  const IvProblem problem(robot, logs, method);
  ThreadTeam team(method.threads);
  IvSolver solver(problem, team, out);
  const bool settled = solver.iterate(solver.start());
  const double with_V = solver.history().empty() ? std::numeric_limits<double>::quiet_NaN()
                                                 : solver.history().back().relative_error;
  if (settled && problem.method.prefilter) {
    prefilter(problem, solver, out);
  }
  if (settled && method.robust) {
    make_robust(problem, solver, out);
  }
  conclude(problem, solver, with_V, out);
}

}  // namespace rivid::detail
