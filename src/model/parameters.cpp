#include "rivid/model/parameters.hpp"

namespace rivid {

namespace {

// Parallel-axis term: inertia of a point mass m at c about the origin.
Eigen::Matrix3d point_mass(double m, const Eigen::Vector3d& c) {
  return m * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
}

Inertial packed(const Eigen::Matrix3d& I, const Eigen::Vector3d& first_moment, double mass) {
  Inertial out;
  out << I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2), first_moment, mass;
  return out;
}

}  // namespace

Inertial inertial_from_com(double mass, const Eigen::Vector3d& com, const Eigen::Matrix3d& I_com) {
  return packed(I_com + point_mass(mass, com), mass * com, mass);
}

Inertial transformed(const Inertial& inertial, const Eigen::Matrix3d& R, const Eigen::Vector3d& p) {
  Eigen::Matrix3d I;
  I << inertial[0], inertial[1], inertial[2], inertial[1], inertial[3], inertial[4], inertial[2], inertial[4],
      inertial[5];
  const double m = inertial[9];
  const Eigen::Vector3d h = R * inertial.segment<3>(6);
  // ∫(|r + p|² 1 − (r + p)(r + p)ᵀ) dm, opened so that a body without mass (m = 0, h ≠ 0) transforms as well.
  const Eigen::Matrix3d cross =
      2.0 * p.dot(h) * Eigen::Matrix3d::Identity() - p * h.transpose() - h * p.transpose();
  return packed(R * I * R.transpose() + cross + point_mass(m, p), h + m * p, m);
}

Eigen::Matrix4d pseudo_inertia(const Inertial& inertial) {
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

Inertial inertial_from_pseudo_inertia(const Eigen::Matrix4d& P) {
  const Eigen::Matrix3d second = P.topLeftCorner<3, 3>();
  const Eigen::Matrix3d I = second.trace() * Eigen::Matrix3d::Identity() - second;
  Inertial p;
  p.head<6>() << I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2);
  p.segment<3>(6) = P.topRightCorner<3, 1>();
  p[9] = P(3, 3);
  return p;
}

}  // namespace rivid
