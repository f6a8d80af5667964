#pragma once

#include <Eigen/Geometry>
#include <random>
#include <string>

#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"
#include "support/normal.hpp"

namespace rivid::test {

/// The paper's planar SCARA, L = 0.5 m, its frames at the joints; eight base parameters.
inline Robot scara() {
  Robot robot;
  robot.name = "scara";
  robot.chain.links.resize(2);
  robot.chain.links[1].p = {0.5, 0.0, 0.0};
  for (int j = 0; j < 2; ++j) {
    Joint joint;
    joint.name = "joint_" + std::to_string(j + 1);
    joint.link = "link_" + std::to_string(j + 1);
    joint.friction = Friction::coulomb;
    joint.rotor_inertia = j == 0;  // ZZ2R = ZZ2 + Ia2 in the paper: one parameter
    robot.joints.push_back(joint);
  }
  robot.inertials.assign(2, Inertial::Zero());
  return robot;
}

/// One prismatic joint, as EMPS.
inline Robot slider(Friction friction = Friction::symmetric, bool rotor_inertia = false) {
  Robot robot;
  robot.name = "slider";
  robot.chain.links.resize(1);
  robot.chain.links[0].type = JointType::prismatic;
  // Horizontal: z of the frame along x of the base.
  robot.chain.links[0].R << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  Joint joint;
  joint.name = "joint_1";
  joint.link = "carriage";
  joint.type = JointType::prismatic;
  joint.friction = friction;
  joint.rotor_inertia = rotor_inertia;
  robot.joints = {joint};
  robot.inertials.assign(1, Inertial::Zero());
  return robot;
}

inline Eigen::Vector3d random_vector(std::mt19937_64& random, double scale = 1.0) {
  std::uniform_real_distribution<double> symmetric(-scale, scale);
  const double x = symmetric(random);
  const double y = symmetric(random);
  const double z = symmetric(random);
  return {x, y, z};
}

inline Eigen::Matrix3d random_rotation(std::mt19937_64& random) {
  Normal normal;
  Eigen::Quaterniond q;
  for (double* x : {&q.z(), &q.y(), &q.x(), &q.w()}) {
    *x = normal(random);
  }
  return q.normalized().toRotationMatrix();
}

/// A body of some kilograms with a positive-definite inertia that fulfils the triangle inequality.
inline Inertial random_inertial(std::mt19937_64& random) {
  std::uniform_real_distribution<double> positive(0.5, 3.0);
  // Each draw is a statement of its own: the order of a call's arguments is the compiler's choice.
  Eigen::Vector3d second_moments;
  for (double& moment : second_moments.reverse()) {
    moment = positive(random) * 0.02;
  }
  const Eigen::Matrix3d R = random_rotation(random);
  const Eigen::Matrix3d principal =
      (second_moments.sum() * Eigen::Vector3d::Ones() - second_moments).asDiagonal();
  const Eigen::Vector3d centre = random_vector(random, 0.2);
  return inertial_from_com(positive(random), centre, R * principal * R.transpose());
}

/// A serial robot of n joints of mixed types, with any axis and offset and with axes renamed at random.
inline Robot random_robot(int n, std::mt19937_64& random) {
  Robot robot;
  robot.name = "random_" + std::to_string(n);
  robot.chain.gravity = random_vector(random, 9.81);
  std::bernoulli_distribution prismatic(0.25);
  for (int j = 0; j < n; ++j) {
    Chain::Link link;
    link.type = prismatic(random) ? JointType::prismatic : JointType::revolute;
    link.R = random_rotation(random);
    link.p = random_vector(random, 0.5);
    constexpr unsigned two_bits = 62;  // above: std::uniform_int_distribution is not the same everywhere
    switch (random() >> two_bits) {
      case 1:
        link.axes = {2, 0, 1};
        break;
      case 2:
        link.axes = {1, 2, 0};
        break;
      case 3:
        link.signs = {1, -1, -1};
        break;
      default:
        break;
    }
    robot.chain.links.push_back(link);
    Joint joint;
    joint.name = "joint_" + std::to_string(j + 1);
    joint.link = "link_" + std::to_string(j + 1);
    joint.type = link.type;
    std::uniform_real_distribution<double> positive(0.1, 2.0);
    joint.Ia = positive(random);
    joint.Fv = positive(random);
    joint.Fc = positive(random);
    robot.joints.push_back(joint);
    robot.inertials.push_back(random_inertial(random));
  }
  return robot;
}

/// Standard parameters with friction that differs from kind to kind, all of it braking.
inline Vector distinct_friction(const Robot& robot) {
  Vector chi_st = robot.chi_st();
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (is_friction(parameters[i].kind)) {
      // Little of a coupled motor: its friction lies beside that of the joints it couples.
      const double scale = about(parameters[i].kind).coupled ? 0.1 : 1.0;
      const bool load = about(parameters[i].kind).basis == Basis::load;
      // Where gravity may act along a joint, its offset is part of the load that the base parameters know.
      const auto j = static_cast<std::size_t>(parameters[i].joint);
      const bool weight = parameters[i].kind == ParameterKind::off &&
                          has(robot.joints[j].friction, Basis::load) &&
                          robot.chain.links[j].type == JointType::prismatic;
      chi_st[static_cast<Index>(i)] = (weight ? 0.0
                                       : load ? 0.05
                                              : scale) *
                                      (2.0 + 0.1 * static_cast<double>(i % 17));
    }
  }
  return chi_st;
}

/// A motion of independent random samples.
inline Motion random_motion(Index samples, Index joints, std::mt19937_64& random) {
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  const auto matrix = [&](double scale) {
    return Matrix(Matrix::NullaryExpr(samples, joints, [&] { return scale * symmetric(random); }));
  };
  Motion motion;
  motion.q = matrix(3.0);
  motion.qd = matrix(2.0);
  motion.qdd = matrix(5.0);
  return motion;
}

}  // namespace rivid::test
