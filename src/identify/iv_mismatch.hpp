#pragma once

#include "identify/closed_loops.hpp"

namespace rivid::detail {

// Where the assumed loop and the actual one part.

// out.reasons: joints that their friction holds throughout the simulation, which gives no instruments.
void explain_locked(const IvProblem& problem, const SimulatedLoops& loops, Identification& out);

// How well the assumed controller explains the logs, with out.warnings where it does not.
//
// loops  simulated with the estimate
[[nodiscard]] LoopDiagnosis diagnosed_loop(const IvProblem& problem, const ClosedLoops& all,
                                           const SimulatedLoops& loops, Identification& out);

// out.warnings: the bandwidth shows in the residual with V alone.
//
// with_V  relative error with the simulated motion; that with the measured one is out.fit's
void diagnose_bandwidth(double with_V, Identification& out);

}  // namespace rivid::detail
