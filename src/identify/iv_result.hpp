#pragma once

#include "identify/iv_solver.hpp"

namespace rivid::detail {

// out.C_chi of an estimate and what comes with a second look at the rows: those that its own instruments were made for, as
// long as no later iterate took their place.
void tell_uncertainty(const IvProblem& problem, const Instruments& instruments, const IvEstimate& estimate,
                      Identification& out);

// Everything in `out` that follows from the iteration.
//
// with_V  relative error with the simulated motion, before any prefilter
void conclude(const IvProblem& problem, const IvSolver& solver, double with_V, Identification& out);

}  // namespace rivid::detail
