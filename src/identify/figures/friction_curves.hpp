#pragma once

#include "identify/figures/joint_rows.hpp"
#include "rivid/identify/friction_curves.hpp"

namespace rivid::detail {

// The law alone, without what the rows have.
//
// @param load  |τ| of the gear that friction in proportion to the load is shown at [N·m | N]
[[nodiscard]] FrictionCurve friction_law(const Robot& robot, const Identification& result, std::size_t joint,
                                         double most_speed, double load);

// @param rows  of the joint, at least one
[[nodiscard]] FrictionCurve friction_curve(const Robot& robot, const Identification& result,
                                           std::size_t joint, const StackedRows& rows);

}  // namespace rivid::detail
