#include "rivid/simulate/inverse_dynamics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfenv>
#include <cmath>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <limits>
#include <type_traits>

#include "rivid/model/kdl.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "support/complaint.hpp"
#include "support/mallocs.hpp"
#include "support/random_chain.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// Same quantity by another algorithm, relative to the largest torque.
constexpr double tolerance = 1e-12;

struct State3 {
  Vector q, qd, qdd;
};

State3 random_state(Index n, std::mt19937_64& random) {
  const Motion motion = test::random_motion(1, n, random);
  return {motion.q.transpose(), motion.qd.transpose(), motion.qdd.transpose()};
}

void expect_close(const Vector& found, const Vector& expected, double scale) {
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), tolerance * scale)
      << found.transpose() << "\nbut should be\n"
      << expected.transpose();
}

Vector torque(InverseDynamics& dynamics, const State3& state) {
  Vector tau(dynamics.size());
  dynamics.torque(state.q, state.qd, state.qdd, tau);
  return tau;
}

// KDL's recursive Newton-Euler knows rotors and no friction.
Vector kdl_torque(const KDL::Chain& chain, const Eigen::Vector3d& g, const State3& state) {
  const auto n = static_cast<unsigned>(state.q.size());
  KDL::ChainIdSolver_RNE solver(chain, KDL::Vector(g.x(), g.y(), g.z()));
  KDL::JntArray q(n), qd(n), qdd(n), tau(n);
  for (unsigned j = 0; j < n; ++j) {
    q(j) = state.q[j];
    qd(j) = state.qd[j];
    qdd(j) = state.qdd[j];
  }
  EXPECT_EQ(solver.CartToJnt(q, qd, qdd, KDL::Wrenches(chain.getNrOfSegments()), tau), 0);
  Vector out(state.q.size());
  for (unsigned j = 0; j < n; ++j) {
    out[j] = tau(j);
  }
  return out;
}

TEST(InverseDynamics, OfBaseParametersGivesTheTorquesOfKdl) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::RandomChain draw(seed);
    const KDL::Chain chain = draw.chain();
    Robot robot = robot_from(chain, {1.0, -2.0, -9.0});
    for (Joint& joint : robot.joints) {
      joint.friction = Friction::none;
    }
    const BaseParameters base = base_parameters(robot);
    InverseDynamics dynamics(DynamicModel(robot, base, base.from_standard(robot.chi_st())));
    InverseDynamics of_all(DynamicModel(robot, robot.chi_st()));
    std::mt19937_64 random(seed);
    const State3 state = random_state(robot.size(), random);
    const Vector expected = kdl_torque(chain, robot.chain.gravity, state);
    // Torques of single links cancel each other in what a joint feels.
    const double scale =
        expected.cwiseAbs().maxCoeff() + base.from_standard(robot.chi_st()).cwiseAbs().maxCoeff();
    expect_close(torque(dynamics, state), expected, scale);
    expect_close(torque(of_all, state), expected, scale);
  }
}

TEST(InverseDynamics, GivesTheTorquesOfTheRegressorForEveryFrictionLaw) {
  for (const FrictionRow& row : friction_rows) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      SCOPED_TRACE(std::string(row.name) + ", seed " + std::to_string(seed));
      std::mt19937_64 random(seed);
      Robot robot = test::random_robot(5, random);
      for (Joint& joint : robot.joints) {
        joint.friction = row.law;
      }
      robot.joints[1].sign_speed = 0.7;
      robot.joints[3].sign_speed = 2.0;
      const Motion motion = test::random_motion(1, 5, random);
      const BaseParameters base = base_parameters(robot);
      Vector chi = base.from_standard(test::distinct_friction(robot));
      const Vector expected = observation(robot, at_load(base, chi), motion).dense() * chi;
      const DynamicModel model(robot, base, chi);
      InverseDynamics dynamics(model);
      expect_close(torque(dynamics, {motion.q.transpose(), motion.qd.transpose(), motion.qdd.transpose()}),
                   expected, expected.cwiseAbs().maxCoeff());
    }
  }
}

TEST(InverseDynamics, IsTheSumOfItsParts) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    Robot robot = test::random_robot(6, random);
    Coupling coupling;
    coupling.motor = 5;
    coupling.joints = {4};
    coupling.ratios = {-1.0};
    coupling.Iam = 0.2;
    coupling.Fvm = 0.1;
    coupling.Fcm = 0.3;
    robot.couplings = {coupling};
    const DynamicModel model(robot, robot.chi_st());
    InverseDynamics dynamics(model);
    const State3 state = random_state(6, random);
    const Vector tau = torque(dynamics, state);
    Matrix M(6, 6);
    Vector gravity(6), coriolis(6), bias(6), friction(6);
    dynamics.M(state.q, M);
    dynamics.gravity(state.q, gravity);
    dynamics.coriolis(state.q, state.qd, coriolis);
    dynamics.bias(state.q, state.qd, bias);
    dynamics.friction(state.qd, friction);
    const double scale = tau.cwiseAbs().maxCoeff();
    expect_close(M * state.qdd + coriolis + gravity + friction, tau, scale);
    expect_close(coriolis + gravity, bias, scale);
    expect_close(bias, rivid::bias(model, state.q, state.qd), scale);
    expect_close(friction, friction_torque(model, state.qd), scale);
    expect_close(tau, inverse_dynamics(model, state.q, state.qd, state.qdd), scale);
    EXPECT_TRUE(M.isApprox(M.transpose()));
  }
}

TEST(InverseDynamics, SmoothsTheSignOfAVelocity) {
  Robot robot = test::slider(Friction::asymmetric);
  robot.joints[0].Fv = 0.0;
  Vector chi_st = robot.chi_st();
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ParameterKind kind = parameters[i].kind;
    chi_st[static_cast<Index>(i)] = kind == ParameterKind::Fc_plus    ? 3.0
                                    : kind == ParameterKind::Fc_minus ? 1.0
                                                                      : 0.0;
  }
  const double v_s = 0.02;
  InverseDynamics smooth(DynamicModel(robot, chi_st), {.smoothing_speed = Vector::Constant(1, v_s)});
  const auto friction = [&](double qd) {
    Vector tau(1);
    smooth.friction(Vector::Constant(1, qd), tau);
    return tau[0];
  };
  EXPECT_DOUBLE_EQ(friction(0.0), 1.0);  // half-way between −1 and 3
  EXPECT_DOUBLE_EQ(friction(v_s), 1.0 + 2.0 * std::tanh(1.0));
  EXPECT_DOUBLE_EQ(friction(1.0), 3.0);
  EXPECT_DOUBLE_EQ(friction(-1.0), -1.0);
  InverseDynamics sharp{DynamicModel(robot, chi_st)};
  Vector tau(1);
  sharp.friction(Vector::Constant(1, 1e-9), tau);
  EXPECT_EQ(tau[0], 3.0);
  sharp.friction(Vector::Zero(1), tau);
  EXPECT_EQ(tau[0], 0.0);
}

TEST(InverseDynamics, LeavesASignThatWasIdentifiedSmoothAsItIs) {
  Robot robot = test::slider(Friction::coulomb);
  robot.joints[0].sign_speed = 0.5;
  robot.joints[0].Fc = 3.0;
  InverseDynamics dynamics(DynamicModel(robot, robot.chi_st()),
                           {.smoothing_speed = Vector::Constant(1, 0.01)});
  Vector tau(1);
  dynamics.friction(Vector::Constant(1, 0.2), tau);
  EXPECT_DOUBLE_EQ(tau[0], 3.0 * std::tanh(0.4));
}

TEST(InverseDynamics, DoesNotAllocateOnceItIsMade) {
  std::mt19937_64 random(5);
  const Robot robot = test::random_robot(7, random);
  InverseDynamics dynamics(DynamicModel(robot, robot.chi_st()),
                           {.smoothing_speed = Vector::Constant(7, 0.01)});
  const State3 state = random_state(7, random);
  const Motion columns = test::random_motion(7, 3, random);
  Vector tau(7);
  Matrix M(7, 7);
  const long count = test::allocations_of([&] {
    dynamics.torque(state.q, state.qd, state.qdd, tau);
    dynamics.torque(columns.q.col(0), columns.qd.col(1), columns.qdd.col(2), tau);
    dynamics.gravity(state.q, tau);
    dynamics.bias(state.q, state.qd, tau);
    dynamics.coriolis(state.q, state.qd, tau);
    dynamics.friction(state.qd, tau);
    dynamics.M(state.q, M);
  });
  EXPECT_EQ(count, 0);
  EXPECT_GT(test::allocations_of([&] { const InverseDynamics copy(dynamics); }), 0);
}

// The processor's own word: a result smaller than a normal number raises the flag of underflow.
bool has_denormal_numbers(InverseDynamics& dynamics, const State3& state) {
  Vector tau(dynamics.size());
  std::feclearexcept(FE_ALL_EXCEPT);
  dynamics.torque(state.q, state.qd, state.qdd, tau);
  return std::fetestexcept(FE_UNDERFLOW) != 0;
}

TEST(InverseDynamics, TakesDenormalNumbersForZeroAndNeverComputesOne) {
  std::mt19937_64 random(6);
  const Robot robot = test::random_robot(6, random);
  InverseDynamics dynamics(DynamicModel(robot, robot.chi_st()));
  const Vector zero = Vector::Zero(robot.size());
  const Vector q = Vector::Constant(robot.size(), 0.3);
  const Vector expected = torque(dynamics, {q, zero, zero});
  const Vector smallest = Vector::Constant(robot.size(), 1.01e-102);
  EXPECT_NE(torque(dynamics, {q, smallest, zero}), expected) << "has friction";
  EXPECT_FALSE(has_denormal_numbers(dynamics, {q, smallest, -smallest}));
  for (const double trace : {0.99e-102, 1e-110, 1e-160, 1e-300, 1e-310, 5e-324}) {
    const Vector x = Vector::Constant(robot.size(), trace);
    EXPECT_EQ(torque(dynamics, {q, x, -x}), expected) << trace;
    EXPECT_FALSE(has_denormal_numbers(dynamics, {q, x, -x})) << trace;
  }
}

TEST(InverseDynamics, CopiesShareNoScratch) {
  std::mt19937_64 random(6);
  const Robot robot = test::random_robot(4, random);
  InverseDynamics one(DynamicModel(robot, robot.chi_st()));
  InverseDynamics other = one;
  const State3 a = random_state(4, random);
  const State3 b = random_state(4, random);
  const Vector of_a = torque(one, a);
  static_cast<void>(torque(other, b));
  EXPECT_EQ(torque(one, a), of_a);
  EXPECT_EQ(torque(other, a), of_a);
}

TEST(InverseDynamics, FillsAnOutputOfUnfitInputsWithNan) {
  std::mt19937_64 random(7);
  const Robot robot = test::random_robot(3, random);
  InverseDynamics dynamics(DynamicModel(robot, robot.chi_st()));
  const Vector three = Vector::Ones(3);
  const Vector two = Vector::Ones(2);
  Vector tau = three;
  dynamics.torque(three, two, three, tau);
  EXPECT_TRUE(tau.array().isNaN().all());
  tau = three;
  dynamics.gravity(two, tau);
  EXPECT_TRUE(tau.array().isNaN().all());
  Vector small = two;
  dynamics.coriolis(three, three, small);
  EXPECT_TRUE(small.array().isNaN().all());
  Matrix M = Matrix::Ones(3, 2);
  dynamics.M(three, M);
  EXPECT_TRUE(M.array().isNaN().all());
}

TEST(InverseDynamics, RefusesSmoothingSpeedsThatAreNone) {
  std::mt19937_64 random(8);
  const Robot robot = test::random_robot(2, random);
  const DynamicModel model(robot, robot.chi_st());
  const auto message = [&](const Vector& speeds) -> std::string {
    return test::complaint_of([&] { const InverseDynamics dynamics(model, {.smoothing_speed = speeds}); });
  };
  EXPECT_NE(message(Vector::Ones(3)).find("smoothing_speed has 3 values, the robot has 2 joints"),
            std::string::npos);
  EXPECT_NE(message(Vector::Zero(2)).find("joint \"joint_1\" is 0, must be positive"), std::string::npos);
}

using Values = InverseDynamics::Values;
static_assert(std::is_same_v<decltype(&InverseDynamics::torque),
                             void (InverseDynamics::*)(const Values&, const Values&, const Values&,
                                                       InverseDynamics::Result) noexcept>);

}  // namespace
}  // namespace rivid
