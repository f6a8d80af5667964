#pragma once

#include <span>
#include <vector>

#include "rivid/identify/identification.hpp"

// Before the stages rows → estimate → infer → judge → describe: what the caller left open.
namespace rivid::detail {

// Chooses window, velocity threshold and, where it is open, whether torques are held, and writes them into
// the signal of `estimation`.
//
// The window is the shortest with which noise of the positions, as far as they show it, moves no parameter by
// more than a small part of its σ and makes up no more than a small part of any joint's residual. Where that
// leaves few rows a parameter, or does not determine all, it is the window up to there whose estimate is
// expected to predict torques best.
//
// load  of friction that follows the load: the point that the rows are the tangent at
[[nodiscard]] RowChoice choose_rows(const Robot& robot, std::span<const Log> logs, Estimation& estimation,
                                    const LoadPoint& load = {});

// How an estimate by weighted least squares moves where the windows are half and twice as long.
void compare_windows(const Robot& robot, std::span<const Log> logs, const Estimation& estimation,
                     const LoadPoint& load, RowChoice& choice);

// Fills in what parameters from these rows say of their noise, and the sentence.
void report_noise(const std::vector<ParameterEstimate>& parameters, RowChoice& choice);

}  // namespace rivid::detail
