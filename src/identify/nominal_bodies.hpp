#pragma once

#include <string>
#include <vector>

#include "rivid/model/robot.hpp"

namespace rivid::detail {

// A body for every link.
struct NominalBodies {
  std::vector<Eigen::Matrix4d> pseudo_inertias;  // positive definite
  std::vector<std::string> notes;                // what was put in where the values belong to no body
};

// The bodies that inertial parameters tell, mended where they tell none:
// - a link without mass gets the mean mass of the others (1 kg without any), half-way to the next joint, with their mean
//   radius of gyration (0.1 m without any);
// - second moments about the centre of mass that are negative, or next to nothing beside the largest, are raised to a
//   tenth of the largest; a point mass becomes a small ball.
[[nodiscard]] NominalBodies nominal_bodies(const Robot& robot, const std::vector<Inertial>& inertials);

}  // namespace rivid::detail
