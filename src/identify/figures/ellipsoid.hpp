#pragma once

#include <optional>

#include "rivid/model/parameters.hpp"

namespace rivid::detail {

// A solid ellipsoid of uniform density.
struct SolidEllipsoid {
  double mass = 0.0;  // [kg]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();  // semi-axes as columns
};

// With the mass and the inertia of a link, in its frame; nothing for a link without mass, or whose inertia no
// body can have.
[[nodiscard]] std::optional<SolidEllipsoid> solid_ellipsoid(const Inertial& inertial);

}  // namespace rivid::detail
