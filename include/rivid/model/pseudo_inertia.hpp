#pragma once

#include "rivid/model/parameters.hpp"

namespace rivid {

/// Pseudo-inertia of a link, the second moments of its mass in homogeneous coordinates [Wensing 2018]:
///
///   P = ∫ [r; 1] [r; 1]ᵀ dm = [½ tr(I) 1 − I, h; hᵀ, m]
///
/// with the inertia tensor I about the frame's origin, the first moments h and the mass m. Some body has these inertial
/// parameters if and only if P has no negative eigenvalue.
[[nodiscard]] Eigen::Matrix4d pseudo_inertia(const Inertial& inertial);

/// The inertial parameters that a pseudo-inertia stands for; the inverse of pseudo_inertia().
///
/// @param P  symmetric
[[nodiscard]] Inertial inertial_from_pseudo_inertia(const Eigen::Matrix4d& P);

}  // namespace rivid
