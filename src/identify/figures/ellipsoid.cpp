#include "identify/figures/ellipsoid.hpp"

#include "dense.hpp"

namespace rivid::detail {

std::optional<SolidEllipsoid> solid_ellipsoid(const Inertial& inertial) {
  const Eigen::Matrix4d P = pseudo_inertia(inertial);
  const double mass = P(3, 3);
  if (!(mass > 0.0)) {
    return std::nullopt;
  }
  const Eigen::Vector3d centre = P.topRightCorner<3, 1>() / mass;
  const Eigen::Matrix3d moments = P.topLeftCorner<3, 3>() - mass * centre * centre.transpose();
  const SymmetricEigen principal = symmetric_eigen(moments);
  if (principal.values.minCoeff() < -1e-9 * principal.values.cwiseAbs().maxCoeff()) {
    return std::nullopt;
  }
  // ∫ x² dm of an ellipsoid with semi-axis a is m a² / 5.
  const Eigen::Vector3d along = principal.values;
  const Eigen::Matrix3d directions = principal.vectors;
  const Eigen::Vector3d axes = (5.0 / mass * along.cwiseMax(0.0)).cwiseSqrt();
  return SolidEllipsoid{mass, centre, directions * axes.asDiagonal()};
}

}  // namespace rivid::detail
