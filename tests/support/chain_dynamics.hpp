#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "rivid/model/robot.hpp"

namespace rivid::test {

/// Poses of frames 1…n in the base frame at joint positions q.
inline std::vector<Eigen::Isometry3d> forward_kinematics(const Chain& chain, const Vector& q) {
  std::vector<Eigen::Isometry3d> out;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (Index j = 0; j < chain.joints(); ++j) {
    const Chain::Link& link = chain.links[static_cast<std::size_t>(j)];
    Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
    step.linear() = link.R;
    step.translation() = link.p;
    if (link.type == JointType::revolute) {
      step.rotate(Eigen::AngleAxisd(q[j], Eigen::Vector3d::UnitZ()));
    } else {
      step.translate(q[j] * Eigen::Vector3d::UnitZ());
    }
    pose = pose * step;
    out.push_back(pose);
  }
  return out;
}

/// Inertial parameters of link j in frame j, through the column map that the regressor uses.
inline Inertial in_frame(const Chain::Link& link, const Inertial& inertial) {
  Inertial out = Inertial::Zero();
  for (int k = 0; k < inertial_count; ++k) {
    const InertialColumn column = inertial_column(link, static_cast<ParameterKind>(k));
    out[column.index] += column.sign * inertial[k];
  }
  return out;
}

/// Linear velocity of a point of the base frame and angular velocity, for a unit velocity of joint i.
struct Screw {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();  ///< of the body's point at the base origin
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
};

inline std::vector<Screw> screws(const Chain& chain, const Vector& q) {
  std::vector<Screw> out;
  const std::vector<Eigen::Isometry3d> poses = forward_kinematics(chain, q);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d z = poses[i].linear().col(2);
    if (chain.links[i].type == JointType::revolute) {
      out.push_back({poses[i].translation().cross(z), z});
    } else {
      out.push_back({z, Eigen::Vector3d::Zero()});
    }
  }
  return out;
}

/// Mass matrix and gravity torque from the kinetic and the potential energy of each body, without recursion.
struct EnergyTerms {
  Matrix M;
  Vector gravity_torque;
};

inline EnergyTerms energy_terms(const Robot& robot, const Vector& q) {
  const Index n = robot.size();
  EnergyTerms out{Matrix::Zero(n, n), Vector::Zero(n)};
  const std::vector<Eigen::Isometry3d> poses = forward_kinematics(robot.chain, q);
  const std::vector<Screw> S = screws(robot.chain, q);
  for (Index j = 0; j < n; ++j) {
    const auto body = static_cast<std::size_t>(j);
    const Eigen::Isometry3d& pose = poses[body];
    const Inertial base = transformed(in_frame(robot.chain.links[body], robot.inertials[body]), pose.linear(),
                                      pose.translation());
    Eigen::Matrix3d I;
    I << base[0], base[1], base[2], base[1], base[3], base[4], base[2], base[4], base[5];
    const Eigen::Vector3d h = base.segment<3>(6);
    for (Index a = 0; a <= j; ++a) {
      const Screw& sa = S[static_cast<std::size_t>(a)];
      out.gravity_torque[a] -= robot.chain.gravity.dot(base[9] * sa.v + sa.w.cross(h));
      for (Index b = 0; b <= j; ++b) {
        const Screw& sb = S[static_cast<std::size_t>(b)];
        out.M(a, b) +=
            base[9] * sa.v.dot(sb.v) + sa.v.dot(sb.w.cross(h)) + sb.v.dot(sa.w.cross(h)) + sa.w.dot(I * sb.w);
      }
    }
    out.M(j, j) += robot.joints[body].Ia;
  }
  return out;
}

}  // namespace rivid::test
