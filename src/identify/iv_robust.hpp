#pragma once

#include "identify/iv_solver.hpp"

namespace rivid::detail {

// The M-estimate by instruments, Σ V_tᵀ ω² s ψ_t = 0, with out.robust: weights on rows and instruments in turn.
//
// solver  that has settled; its estimate is replaced
void make_robust(const IvProblem& problem, IvSolver& solver, Identification& out);

}  // namespace rivid::detail
