#pragma once

#include "identify/iv_solver.hpp"

namespace rivid::detail {

// IDIM-PIV, out.prefilter: noise models from the estimate and estimates from whitened rows in turn.
//
// solver  that has settled
void prefilter(const IvProblem& problem, IvSolver& solver, Identification& out);

// out.warnings: whitening changes no parameter by much where the model is right.
void judge_prefilter(Identification& out);

}  // namespace rivid::detail
