#pragma once

#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "rivid/model/parameters.hpp"
#include "rivid/model/robot.hpp"

// What arms of the studies are made of, and what a force on them does.
namespace rivid::benchmarks {

// Friction that arms of this size have, and links of a few kilograms that get lighter towards the tip.
inline void give_bodies(Robot& robot, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto n = robot.joints.size();
  for (std::size_t j = 0; j < n; ++j) {
    const double part = 1.0 - static_cast<double>(j) / static_cast<double>(n);
    const double mass = 1.0 + 7.0 * part;
    const Eigen::Vector3d com(0.1 * unit(random) - 0.05, 0.1 * unit(random) - 0.05,
                              0.1 * unit(random) - 0.05);
    const Eigen::Vector3d second =
        mass * 0.006 * Eigen::Vector3d(0.5 + unit(random), 0.5 + unit(random), 0.5 + unit(random));
    robot.inertials[j] = inertial_from_com(
        mass, com, Eigen::Matrix3d((second.sum() * Eigen::Vector3d::Ones() - second).asDiagonal()));
    Joint& joint = robot.joints[j];
    joint.friction = Friction::symmetric;
    joint.Ia = 0.05 + 0.8 * part * part;
    joint.Fv = 1.0 + 9.0 * part;
    joint.Fc = 1.0 + 7.0 * part;
  }
}

// Torques of a force on a point of a link, by the chain itself: geometry that no estimator has.
inline Vector torques_of_force(const Robot& robot, const Vector& q, Index link,
                               const Eigen::Vector3d& force) {
  std::vector<Eigen::Vector3d> axes;
  std::vector<Eigen::Vector3d> origins;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (Index j = 0; j <= link; ++j) {
    const Chain::Link& l = robot.chain.links[static_cast<std::size_t>(j)];
    p += R * l.p;
    R = R * l.R * Eigen::AngleAxisd(q[j], Eigen::Vector3d::UnitZ()).toRotationMatrix();
    axes.emplace_back(R.col(2));
    origins.push_back(p);
  }
  const Eigen::Vector3d at = p + R * Eigen::Vector3d(0.05, 0.05, 0.1);
  Vector out = Vector::Zero(q.size());
  for (Index j = 0; j <= link; ++j) {
    out[j] = axes[static_cast<std::size_t>(j)].cross(at - origins[static_cast<std::size_t>(j)]).dot(force);
  }
  return out;
}

}  // namespace rivid::benchmarks
