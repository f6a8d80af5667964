#pragma once

#include <span>

#include "rivid/data/log.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/robot.hpp"

namespace rivid::detail {

// Verdict and advice of out.parameters, from their deviations, their correlations in out.C_chi, and what the regressor
// says about the motion that shows them.
//
// logs  that the estimate is from: joints that hardly move there are named
void judge_parameters(const Robot& robot, std::span<const Log> logs, Identification& out);

}  // namespace rivid::detail
