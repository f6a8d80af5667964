#pragma once

#include <span>

#include "rivid/identify/identification.hpp"

// Before the three stages rows → estimate → infer: what the caller left open.
namespace rivid::detail {

// Chooses window, velocity threshold and, where it is open, whether torques are held, and writes them into the signal of `estimation`.
//
// The window is the shortest with which noise of the positions, as far as they show it, moves no parameter by
// more than a small part of its σ and makes up no more than a small part of any joint's residual.
[[nodiscard]] RowChoice choose_rows(const Robot& robot, std::span<const Log> logs, Estimation& estimation);

// Fills in what the result with these rows says of their noise, and the sentence.
void report_noise(const Identification& result, RowChoice& choice);

}  // namespace rivid::detail
