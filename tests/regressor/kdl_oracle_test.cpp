#include <gtest/gtest.h>

#include <cmath>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>

#include "rivid/model/kdl.hpp"
#include "rivid/regressor/batch.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// Same quantity by another algorithm, relative to the largest torque.
constexpr double tolerance = 1e-12;

// KDL's solver knows rotor inertia, but neither friction nor offset.
Robot without_friction(Robot robot) {
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::none;
  }
  return robot;
}

Matrix kdl_torques(const Robot& robot, const Motion& motion) {
  const KDL::Chain chain = kdl_chain(robot);
  const Eigen::Vector3d& g = robot.chain.gravity;
  KDL::ChainIdSolver_RNE solver(chain, KDL::Vector(g.x(), g.y(), g.z()));
  const auto n = static_cast<unsigned>(robot.size());
  KDL::JntArray q(n);
  KDL::JntArray qd(n);
  KDL::JntArray qdd(n);
  KDL::JntArray tau(n);
  const KDL::Wrenches no_forces(chain.getNrOfSegments());
  Matrix out(motion.samples(), robot.size());
  for (Index k = 0; k < motion.samples(); ++k) {
    for (unsigned j = 0; j < n; ++j) {
      q(j) = motion.q(k, j);
      qd(j) = motion.qd(k, j);
      qdd(j) = motion.qdd(k, j);
    }
    EXPECT_EQ(solver.CartToJnt(q, qd, qdd, no_forces, tau), 0);
    for (unsigned j = 0; j < n; ++j) {
      out(k, j) = tau(j);
    }
  }
  return out;
}

TEST(Observation, TimesBaseParametersIsTheInverseDynamicsOfKdl) {
  for (int n = 1; n <= 12; ++n) {
    const auto seed = static_cast<std::uint64_t>(500 + n);
    std::mt19937_64 random(seed);
    const Robot robot = without_friction(test::random_robot(n, random));
    const BaseParameters base = base_parameters(robot);
    const Motion motion = test::random_motion(50, n, random);
    const Vector tau = observation(robot, base, motion).dense() * base.from_standard(robot.chi_st());
    const Matrix expected = kdl_torques(robot, motion);
    EXPECT_LT((tau - expected.reshaped()).cwiseAbs().maxCoeff(), tolerance * expected.cwiseAbs().maxCoeff())
        << n << " joints, seed " << seed;
  }
}

TEST(Observation, HasTheFrictionOfItsLawOnTopOfTheInverseDynamics) {
  std::mt19937_64 random(600);
  Robot robot = test::random_robot(4, random);
  robot.joints[0].friction = Friction::viscous;
  robot.joints[1].friction = Friction::coulomb;
  robot.joints[2].friction = Friction::symmetric;
  robot.joints[3].friction = Friction::asymmetric;
  const BaseParameters base = base_parameters(robot);
  const Motion motion = test::random_motion(50, 4, random);
  const Vector tau = observation(robot, base, motion).dense() * base.from_standard(robot.chi_st());
  Matrix expected = kdl_torques(without_friction(robot), motion);
  for (Index j = 0; j < 4; ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    expected.col(j) += joint.Fv * motion.qd.col(j);
    if (joint.friction != Friction::viscous) {
      expected.col(j) += joint.Fc * motion.qd.col(j).cwiseSign();
    }
  }
  EXPECT_LT((tau - expected.reshaped()).cwiseAbs().maxCoeff(), tolerance * expected.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace rivid
