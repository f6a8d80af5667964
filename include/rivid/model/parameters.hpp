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

/// Inertial parameters from those of a CAD system or a URDF.
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
/// with the inertia tensor I about the frame's origin, the first moments h and the mass m. Some body has
/// these inertial parameters if and only if P has no negative eigenvalue.
[[nodiscard]] Eigen::Matrix4d pseudo_inertia(const Inertial& inertial);

/// The inertial parameters that a pseudo-inertia stands for; the inverse of pseudo_inertia().
///
/// @param P  symmetric
[[nodiscard]] Inertial inertial_from_pseudo_inertia(const Eigen::Matrix4d& P);

#ifdef RIVID_DEFINITIONS

namespace detail {

// Products of three by three, written out in the order of Eigen's, which would cost users of rivid::headers
// as much time to compile as all of this.
inline Eigen::Vector3d applied(const Eigen::Matrix3d& A, const Eigen::Vector3d& b) {
  Eigen::Vector3d out;
  for (Index i = 0; i < 3; ++i) {
    out[i] = A(i, 0) * b[0] + (A(i, 1) * b[1] + A(i, 2) * b[2]);
  }
  return out;
}
inline Eigen::Matrix3d product(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  Eigen::Matrix3d out;
  for (Index j = 0; j < 3; ++j) {
    out.col(j) = applied(A, B.col(j));
  }
  return out;
}

inline Inertial packed(const Eigen::Matrix3d& I, const Eigen::Vector3d& first_moment, double mass) {
  Inertial out;
  out << I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2), first_moment, mass;
  return out;
}

// Parallel-axis term: inertia of a point mass m at c about the origin.
inline Eigen::Matrix3d point_mass(double m, const Eigen::Vector3d& c) {
  Eigen::Matrix3d out;
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) {
      out(i, j) = m * ((i == j ? c.squaredNorm() : 0.0) - c[i] * c[j]);
    }
  }
  return out;
}

}  // namespace detail

RIVID_INLINE Inertial inertial_from_com(double mass, const Eigen::Vector3d& com,
                                        const Eigen::Matrix3d& I_com) {
  return detail::packed(I_com + detail::point_mass(mass, com), mass * com, mass);
}

RIVID_INLINE Inertial transformed(const Inertial& inertial, const Eigen::Matrix3d& R,
                                  const Eigen::Vector3d& p) {
  Eigen::Matrix3d I;
  I << inertial[0], inertial[1], inertial[2], inertial[1], inertial[3], inertial[4], inertial[2], inertial[4],
      inertial[5];
  const double m = inertial[9];
  const Eigen::Vector3d h = detail::applied(R, inertial.segment<3>(6));
  I = detail::product(detail::product(R, I), R.transpose());
  // ∫(|r + p|² 1 − (r + p)(r + p)ᵀ) dm, opened so that a body without mass (m = 0, h ≠ 0) transforms as well.
  const double twice = 2.0 * p.dot(h);
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) {
      I(i, j) += (i == j ? twice : 0.0) - p[i] * h[j] - h[i] * p[j];
    }
  }
  return detail::packed(I + detail::point_mass(m, p), h + m * p, m);
}

RIVID_INLINE Eigen::Matrix4d pseudo_inertia(const Inertial& inertial) {
  const Inertial& p = inertial;
  Eigen::Matrix3d I;
  I << p[0], p[1], p[2], p[1], p[3], p[4], p[2], p[4], p[5];
  Eigen::Matrix4d P;
  P.topLeftCorner<3, 3>() = 0.5 * I.trace() * Eigen::Matrix3d::Identity() - I;
  P.topRightCorner<3, 1>() = p.segment<3>(6);
  P.bottomLeftCorner<1, 3>() = p.segment<3>(6).transpose();
  P(3, 3) = p[9];
  return P;
}

RIVID_INLINE Inertial inertial_from_pseudo_inertia(const Eigen::Matrix4d& P) {
  const Eigen::Matrix3d second = P.topLeftCorner<3, 3>();
  const Eigen::Matrix3d I = second.trace() * Eigen::Matrix3d::Identity() - second;
  Inertial p;
  p.head<6>() << I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2);
  p.segment<3>(6) = P.topRightCorner<3, 1>();
  p[9] = P(3, 3);
  return p;
}

#endif

}  // namespace rivid
