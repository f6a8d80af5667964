#pragma once

#include <string>

#include "rivid/model/kinds.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Number of inertial parameters of a link: XX XY XZ YY YZ ZZ MX MY MZ M.
inline constexpr int inertial_count = 10;

/// The inertial parameters of one link in the order of Eq. (3): inertia tensor about the ORIGIN of the link's
/// frame (not about its centre of mass) [kg·m²], first moments [kg·m], mass [kg].
using Inertial = Eigen::Matrix<double, inertial_count, 1>;

/// One standard parameter of a robot.
struct StandardParameter {
  ParameterKind kind = ParameterKind::XX;
  int joint = 0;  ///< counted from 0; the name counts from 1, as the field does

  /// "ZZ1", "Ia2", "Fv+1", "Iam6", …
  [[nodiscard]] std::string name() const { return std::string(symbol(kind)) + std::to_string(joint + 1); }
};

/// Inertial parameters from what a CAD system or a URDF tells.
///
/// @param mass    [kg]
/// @param com     centre of mass in the link's frame [m]
/// @param I_com   inertia tensor about the centre of mass, in the axes of the link's frame [kg·m²]
[[nodiscard]] Inertial inertial_from_com(double mass, const Eigen::Vector3d& com,
                                         const Eigen::Matrix3d& I_com);

/// Inertial parameters of the same body in another frame.
///
/// @param R  orientation of the present frame in the new one
/// @param p  origin of the present frame in the new one [m]
[[nodiscard]] Inertial transformed(const Inertial& inertial, const Eigen::Matrix3d& R,
                                   const Eigen::Vector3d& p);

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
