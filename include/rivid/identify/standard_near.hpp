#pragma once

#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"

namespace rivid {

/// The standard parameters nearest to the robot's a-priori ones that have given base parameters:
///
///   min ‖D⁻¹ (χ_st − χ_st,0)‖  subject to  B χ_st = χ,   χ = χ_leading + K χ_dependent of Eq. (6) of [RIV].
///
/// D makes changes comparable: M L² for inertias, M L for first moments, M for masses, with the a-priori mass M and
/// radius of gyration L of the link (those of the mean link where it has none; 1 kg and 0.1 m where no link has any);
/// rotor inertias count as inertias. Friction is no matter of choice: it is in χ itself.
///
/// Torques are those of χ. Nothing keeps a link from becoming what no body can be, see body_complaint().
///
/// @param base  base_parameters(robot)
/// @param chi   (b)
/// @return      χ_st, (N_s)
/// @throws InputError  where `base` are the parameters of another robot; chi of a wrong size or not finite
[[nodiscard]] Vector standard_near(const Robot& robot, const BaseParameters& base,
                                   const Eigen::Ref<const Vector>& chi);

}  // namespace rivid
