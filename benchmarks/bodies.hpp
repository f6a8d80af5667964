#pragma once

#include <array>
#include <random>
#include <vector>

#include "rivid/simulate/dynamic_model.hpp"

#if defined(RIVID_WITH_PINOCCHIO)
#include "pinocchio_aba.hpp"
#endif

namespace rivid::benchmarks {

/// A body of some kilograms for every link, a rotor for every joint.
inline Robot with_bodies(Robot robot) {
  std::mt19937_64 random(41);
  std::uniform_real_distribution<double> positive(0.5, 2.0);
  std::uniform_real_distribution<double> symmetric(-0.1, 0.1);
  for (std::size_t j = 0; j < robot.inertials.size(); ++j) {
    const Eigen::Vector3d com(symmetric(random), symmetric(random), symmetric(random));
    const Eigen::Vector3d I(positive(random), positive(random), positive(random));
    robot.inertials[j] =
        inertial_from_com(3.0 * positive(random), com,
                          Eigen::Matrix3d((0.02 * (I.sum() * Eigen::Vector3d::Ones() - I)).asDiagonal()));
    robot.joints[j].Ia = 0.1 * positive(random);
    robot.joints[j].friction = Friction::none;
  }
  return robot;
}

#if defined(RIVID_WITH_PINOCCHIO)
inline PinocchioAba pinocchio_of(const Robot& robot, const DynamicModel& model) {
  std::vector<PinocchioAba::Link> links;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Chain::Link& link = robot.chain.links[j];
    PinocchioAba::Link out{.revolute = link.type == JointType::revolute, .Ia = robot.joints[j].Ia};
    Eigen::Matrix3d::Map(out.R.data()) = link.R;
    Eigen::Vector3d::Map(out.p.data()) = link.p;
    constexpr std::array<Index, 10> ours = {9, 6, 7, 8, 0, 1, 3, 2, 4, 5};
    for (std::size_t k = 0; k < ours.size(); ++k) {
      out.dynamic_parameters[k] = model.inertials()[j][ours[k]];
    }
    links.push_back(out);
  }
  const Eigen::Vector3d& g = robot.chain.gravity;
  return PinocchioAba(links, {g.x(), g.y(), g.z()});
}
#endif

}  // namespace rivid::benchmarks
