#pragma once

#include "identify/estimate/estimate.hpp"
#include "identify/infer/scores.hpp"

// The third of three stages: rows → estimate → infer. Once for all methods; each function fills what its name says of the
// result.
namespace rivid::detail {

// All three stages of a problem that leaves nothing open.
[[nodiscard]] Identification identified(const EstimationProblem& problem);

// The model against the rows, unweighted. Each joint is charged its share of the `estimated` parameters; a validation
// charges none.
[[nodiscard]] Fit judged(const Robot& robot, const RowFactors& data, const Vector& chi, Index estimated,
                         Convention convention);

// Verdict and advice of out.parameters, from their deviations, their correlations in out.C_chi, and what the regressor
// says about the motion that shows them.
//
// velocities  of the logs that the estimate is from: joints that hardly move there are named
void judge_parameters(const Robot& robot, const SquaredVelocities& velocities, Identification& out);

// Of differences over so long a time that the noise of encoders does not count.
[[nodiscard]] SquaredVelocities squared_velocities(std::span<const Log> logs, Index n);

// out.essential, where it is wanted: the parameters that the estimate can not do without, and their fit.
void add_essential(const EstimationProblem& problem, const Estimate& estimate, Identification& out);

// out.physical of an estimate with all its statistics, where it is asked for; else a warning where the data leave much
// open that it would settle.
//
// blocks  of time that the weight of the prior is validated on, one by one; none leave it to what the prior costs
void add_physical(const EstimationProblem& problem, const Estimate& estimate,
                  std::span<const BlockSums> blocks, Identification& out);

// Warnings, and what reports have to say of out.parameters.
void judge_noise(Identification& out);
void judge_robust(Identification& out);
void judge_torque_lag(Identification& out);
void judge_instruments(Identification& out);  // a status as well
void judge_prefilter(Identification& out);
// with_V  relative error with the simulated motion; that with the measured one is out.fit's
void judge_loop(double with_V, Identification& out);

}  // namespace rivid::detail
