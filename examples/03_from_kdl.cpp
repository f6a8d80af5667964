#include <iostream>
#include <kdl/chain.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>

#include "rivid/model/kdl.hpp"
#include "rivid/rivid.hpp"

// A robot that is made in memory as a KDL::Chain: its base parameters, and the torques that they give.
int main() {
  KDL::Chain chain;
  const auto add = [&](const char* link, const char* joint, KDL::Joint::JointType axis,
                       const KDL::Vector& tip, double mass, const KDL::Vector& com, double inertia) {
    const KDL::RotationalInertia about_com(inertia, inertia, inertia);
    chain.addSegment(KDL::Segment(link, KDL::Joint(joint, axis), KDL::Frame(tip),
                                  KDL::RigidBodyInertia(mass, com, about_com)));
  };
  add("column", "waist", KDL::Joint::RotZ, {0.0, 0.0, 0.4}, 9.0, {0.0, 0.0, -0.1}, 0.08);
  add("arm", "shoulder", KDL::Joint::RotY, {0.5, 0.0, 0.0}, 5.0, {-0.3, 0.0, 0.0}, 0.05);
  add("forearm", "elbow", KDL::Joint::RotY, {0.4, 0.0, 0.0}, 3.0, {-0.2, 0.01, 0.0}, 0.02);

  rivid::Robot robot = rivid::robot_from(chain);
  for (rivid::Joint& joint : robot.joints) {
    joint.friction = rivid::Friction::none;
    joint.rotor_inertia = false;
  }
  const rivid::BaseParameters base = rivid::base_parameters(robot);
  const rivid::Vector chi = base.from_standard(robot.chi_st());
  std::cout << base.size() << " base parameters of " << base.standard.size() << " standard ones\n";
  for (rivid::Index i = 0; i < base.size(); ++i) {
    const rivid::BaseParameter& p = base.parameters[static_cast<std::size_t>(i)];
    std::cout << (p.regrouped == p.name ? p.name : p.name + " = " + p.regrouped) << " = " << chi[i] << ' '
              << p.unit << '\n';
  }
  for (const rivid::Finding& doubt : robot.warnings) {
    std::cout << in_words(doubt) << '\n';
  }

  // One instant: W χ of its three rows is what KDL's recursive Newton-Euler says.
  const Eigen::RowVector3d q(0.3, -0.8, 1.1);
  const Eigen::RowVector3d qd(0.5, -1.2, 0.7);
  const Eigen::RowVector3d qdd(2.0, 1.0, -3.0);
  const rivid::Vector tau = rivid::observation(robot, base, {q, qd, qdd}).dense() * chi;

  const auto array = [](const Eigen::RowVector3d& x) {
    KDL::JntArray out(3);
    for (unsigned int j = 0; j < 3; ++j) {
      out(j) = x[j];
    }
    return out;
  };
  const Eigen::Vector3d& g = robot.chain.gravity;
  KDL::ChainIdSolver_RNE newton_euler(chain, KDL::Vector(g[0], g[1], g[2]));
  KDL::JntArray torques(3);
  newton_euler.CartToJnt(array(q), array(qd), array(qdd), KDL::Wrenches(3, KDL::Wrench::Zero()), torques);

  double difference = 0.0;
  for (unsigned int j = 0; j < 3; ++j) {
    std::cout << robot.joints[j].name << ": " << tau[j] << " N·m, KDL " << torques(j) << " N·m\n";
    difference = std::max(difference, std::abs(tau[j] - torques(j)));
  }
  // The same torques by another algorithm.
  constexpr double tolerance = 1e-12;
  return difference <= tolerance * tau.cwiseAbs().maxCoeff() ? 0 : 1;
}
