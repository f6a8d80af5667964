#include "rivid/model/parameters.hpp"

namespace rivid {

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
