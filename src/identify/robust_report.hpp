#pragma once

#include <span>

#include "identify/reweighting.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/robot.hpp"

namespace rivid::detail {

// out.robust of an M-estimate, its title, and its status where it did not settle.
//
// chi  estimate of the rows as they are
void tell_robust(const Robot& robot, const Robust& options, const RowLoss& loss,
                 std::span<const RobustSums> sums, int rounds, bool settled, const Vector& chi,
                 Identification& out);

// What out.robust, where there is one, has to say of out.parameters, with out.warnings where outliers decide.
void judge_robust(Identification& out);

}  // namespace rivid::detail
