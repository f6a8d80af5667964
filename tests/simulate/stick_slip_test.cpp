#include "rivid/simulate/stick_slip.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "rivid/simulate/dynamic_model.hpp"
#include "support/robots.hpp"
#include "support/tx40.hpp"

namespace {

using rivid::DryFriction;
using rivid::DynamicModel;
using rivid::Dynamics;
using rivid::FrictionMode;
using rivid::Index;
using rivid::Robot;
using rivid::StickSlip;
using rivid::Vector;

std::span<double> all(Vector& v) { return {v.data(), static_cast<std::size_t>(v.size())}; }

struct AtRest {
  DynamicModel model;
  Dynamics<double> dynamics;
  StickSlip friction;
  Vector q;
  Vector qd;

  AtRest(const Robot& robot, const Vector& chi_st, Vector at)
      : model(robot, chi_st), dynamics(model), friction(model), q(std::move(at)), qd(Vector::Zero(q.size())) {
    EXPECT_TRUE(dynamics.set_state(all(q), all(qd)));
    friction.reset(all(qd));
  }

  // Modes that the torques f bring about, and the accelerations in them.
  Vector settled(Vector f) {
    Vector net = f;
    friction.settle(dynamics, -1, all(qd), all(net));
    Vector qdd(q.size());
    friction.accelerate(dynamics, all(qd), all(f), all(qdd));
    return qdd;
  }

  // Coulomb's law, element by element: held within the limits, or driven off against the limit.
  void expect_lawful(const Vector& qdd) const {
    const double scale = 1e-8 * (1.0 + qdd.cwiseAbs().maxCoeff());
    for (Index e = 0; e < friction.size(); ++e) {
      const DryFriction& law = model.dry_friction()[static_cast<std::size_t>(e)];
      const double acceleration = law.direction.dot(qdd);
      const double lambda = friction.lambda(e);
      switch (friction.mode(e)) {
        case FrictionMode::stick:
          EXPECT_NEAR(acceleration, 0.0, scale) << law.name;
          EXPECT_LE(lambda, law.Fc_plus * (1 + 1e-9)) << law.name;
          EXPECT_GE(lambda, -law.Fc_minus * (1 + 1e-9)) << law.name;
          break;
        case FrictionMode::slip_plus:
          EXPECT_GE(acceleration, -scale) << law.name;
          EXPECT_EQ(lambda, law.Fc_plus) << law.name;
          break;
        case FrictionMode::slip_minus:
          EXPECT_LE(acceleration, scale) << law.name;
          EXPECT_EQ(lambda, -law.Fc_minus) << law.name;
          break;
      }
    }
  }
};

// Any torques on any robot at rest: which joints stay and which go is decided for all together.
TEST(StickSlip, DecidesAllJointsAtRestByCoulombsLaw) {
  std::mt19937_64 random(41);
  std::normal_distribution<double> normal;
  int stuck = 0;
  int slipping = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 1 + trial % 7;
    const Robot robot = rivid::test::random_robot(n, random);
    AtRest at_rest(robot, robot.chi_st(), Vector::NullaryExpr(n, [&] { return normal(random); }));
    const Vector qdd = at_rest.settled(Vector::NullaryExpr(n, [&] { return 2.0 * normal(random); }));
    at_rest.expect_lawful(qdd);
    stuck += static_cast<int>(at_rest.friction.sticking());
    slipping += n - static_cast<int>(at_rest.friction.sticking());
  }
  EXPECT_GT(stuck, 100);
  EXPECT_GT(slipping, 100);
}

// Two joints and the motor that both turn, all at rest: more holding forces than joints.
TEST(StickSlip, HoldsCoupledMotorsAtRest) {
  Robot robot = rivid::test::tx40(rivid::Friction::coulomb);
  robot.couplings = {rivid::test::tx40_wrist()};
  robot.couplings[0].Fcm = 1.6;
  robot.couplings[0].Fvm = 0.1;
  std::mt19937_64 random(42);
  for (std::size_t j = 0; j < 6; ++j) {
    robot.inertials[j] = rivid::test::random_inertial(random);
    robot.joints[j].Ia = 0.5;
    robot.joints[j].Fv = 1.0;
    robot.joints[j].Fc = 2.0;
  }
  std::normal_distribution<double> normal;
  bool all_stuck = false;
  bool motor_alone = false;
  for (int trial = 0; trial < 400; ++trial) {
    AtRest at_rest(robot, robot.chi_st(), Vector::NullaryExpr(6, [&] { return normal(random); }));
    ASSERT_EQ(at_rest.friction.size(), 7);
    const Vector qdd = at_rest.settled(Vector::NullaryExpr(6, [&] { return 2.5 * normal(random); }));
    at_rest.expect_lawful(qdd);
    const auto sticks = [&](Index e) { return at_rest.friction.mode(e) == FrictionMode::stick; };
    all_stuck = all_stuck || at_rest.friction.sticking() == 7;
    motor_alone = motor_alone || (!sticks(4) && !sticks(5) && sticks(6));
  }
  EXPECT_TRUE(all_stuck);
}

// Released in one direction sooner than in the other: how far from either, in parts of both together.
TEST(StickSlip, KnowsHowFarItIsFromBothLimits) {
  const Robot robot = rivid::test::slider(rivid::Friction::asymmetric);
  const rivid::BaseParameters base = rivid::base_parameters(robot);
  Vector chi(5);
  chi << 2.0, 0.0, 3.0, 0.0, 1.0;  // M Fv+ Fc+ Fv− Fc−
  const DynamicModel model(robot, base, chi);
  Dynamics<double> dynamics(model);
  StickSlip friction(model);
  Vector q = Vector::Zero(1);
  Vector qd = Vector::Zero(1);
  ASSERT_TRUE(dynamics.set_state(all(q), all(qd)));
  friction.reset(all(qd));
  for (const auto& [force, margin] :
       {std::pair(0.0, 0.25), std::pair(0.8, 0.45), std::pair(2.6, 0.1), std::pair(-0.8, 0.05)}) {
    Vector net = Vector::Constant(1, force);
    friction.settle(dynamics, -1, all(qd), all(net));
    Vector f = Vector::Constant(1, force);
    Vector qdd(1);
    friction.accelerate(dynamics, all(qd), all(f), all(qdd));
    ASSERT_EQ(friction.mode(0), FrictionMode::stick);
    EXPECT_NEAR(friction.margin(0, all(qd)), margin, 1e-9)
        << force;  // elements give way by 1e-9 of their limits
  }
}

TEST(StickSlip, CountsChangesOfMode) {
  const Robot robot = rivid::test::slider();
  AtRest carriage(robot, robot.chi_st() + (Vector(13) << Vector::Zero(9), 2.0, 0.0, 3.0, 0.0).finished(),
                  Vector::Zero(1));
  EXPECT_EQ(carriage.friction.mode(0), FrictionMode::stick);
  EXPECT_NEAR(carriage.settled(Vector::Constant(1, 5.0))[0], 1.0, 1e-12);
  EXPECT_EQ(carriage.friction.mode(0), FrictionMode::slip_plus);
  EXPECT_EQ(carriage.friction.changes(0), 1);
  carriage.qd[0] = 1e-13;  // what an integrator leaves at a reversal
  Vector f = Vector::Constant(1, -1.0);
  EXPECT_EQ(carriage.friction.settle(carriage.dynamics, 0, all(carriage.qd), all(f)), 1);
  EXPECT_EQ(carriage.friction.mode(0), FrictionMode::stick);
  EXPECT_EQ(carriage.qd[0], 0.0);
  EXPECT_EQ(carriage.friction.changes(0), 2);
}

}  // namespace
