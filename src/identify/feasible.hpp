#pragma once

#include "rivid/regressor/base.hpp"

namespace rivid::detail {

// Base parameters near `chi` that belong to a robot of physical bodies, so that M(q) is positive definite everywhere:
// alternating projections between the standard parameters with these base parameters and those whose pseudo-inertias
// [½ tr(I) 1 − I, h; hᵀ, m] have no negative eigenvalues and whose rotors have some inertia. What comes out is physical,
// and as near as that allows.
[[nodiscard]] Vector feasible_near(const Robot& robot, const BaseParameters& base, const Vector& chi);

}  // namespace rivid::detail
