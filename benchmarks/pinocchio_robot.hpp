#pragma once

#include <array>
#include <vector>

#include "pinocchio_regressor.hpp"
#include "rivid/model/robot.hpp"

namespace rivid::benchmarks {

inline PinocchioRegressor pinocchio_of(const Robot& robot) {
  std::vector<PinocchioRegressor::Link> links;
  for (const Chain::Link& link : robot.chain.links) {
    PinocchioRegressor::Link out{.revolute = link.type == JointType::revolute};
    Eigen::Matrix3d::Map(out.R.data()) = link.R;
    Eigen::Vector3d::Map(out.p.data()) = link.p;
    links.push_back(out);
  }
  const Eigen::Vector3d& g = robot.chain.gravity;
  return PinocchioRegressor(links, {g.x(), g.y(), g.z()});
}

/// Column of an inertial parameter in Pinocchio's regressor.
inline Index pinocchio_column(const StandardParameter& p) {
  constexpr std::array<Index, 10> theirs = {4, 5, 7, 6, 8, 9, 1, 2, 3, 0};
  return 10 * p.joint + theirs[static_cast<std::size_t>(p.kind)];
}

}  // namespace rivid::benchmarks
