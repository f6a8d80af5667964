#include "odd/simulation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <numbers>

#include "odd/draw_arm.hpp"
#include "odd/user_folder.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/regressor/load.hpp"
#include "rivid/simulate/dynamic_model.hpp"

// The simulator of the odd experiments shares no code with rivid's, and is held against closed forms, KDL and
// rivid.
namespace rivid::odd {
namespace {

constexpr std::uint64_t seed = 2026;

KDL::Vector in_kdl(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

KDL::Chain kdl_chain(const Arm& arm) {
  KDL::Chain out;
  for (const ArmJoint& joint : arm.joints) {
    const Matrix3d R = rotation(joint.rpy);
    const KDL::Frame tip(KDL::Rotation::RPY(joint.rpy.x(), joint.rpy.y(), joint.rpy.z()), in_kdl(joint.xyz));
    const auto type = joint.prismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
    // KDL takes it about the centre of mass.
    const Matrix3d& I = joint.body.inertia_com;
    const KDL::RigidBodyInertia body(
        joint.body.mass, in_kdl(joint.body.com),
        KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
    out.addSegment(
        KDL::Segment(KDL::Joint("joint", in_kdl(joint.xyz), in_kdl(R * joint.axis), type), tip, body));
  }
  return out;
}

KDL::JntArray in_kdl(const Numbers& values) {
  KDL::JntArray out(static_cast<unsigned>(values.size()));
  for (Index i = 0; i < values.size(); ++i) {
    out(static_cast<unsigned>(i)) = values[i];
  }
  return out;
}

Numbers random_numbers(Index size, double scale, Random& random) {
  Numbers out(size);
  for (double& value : out) {
    value = random.uniform(-scale, scale);
  }
  return out;
}

TEST(OddDynamics, AreThoseOfKdl) {
  // Two recursions of some hundred roundings each.
  constexpr double tolerance = 1e-12;
  for (std::uint64_t k = 0; k < 50; ++k) {
    Random random(seed, "kdl", k);
    Recipe recipe;
    recipe.joints = random.integer(1, most_joints);
    const Arm arm = drawn_arm(recipe, random);
    const ArmDynamics dynamics(arm);
    const KDL::Chain chain = kdl_chain(arm);
    const auto n = static_cast<unsigned>(arm.size());
    const Numbers q = random_numbers(arm.size(), 3.0, random);
    const Numbers qd = random_numbers(arm.size(), 3.0, random);
    const Numbers qdd = random_numbers(arm.size(), 10.0, random);
    KDL::ChainIdSolver_RNE inverse(chain, in_kdl(arm.gravity));
    KDL::JntArray tau(n);
    inverse.CartToJnt(in_kdl(q), in_kdl(qd), in_kdl(qdd), KDL::Wrenches(chain.getNrOfSegments()), tau);
    const Numbers ours = dynamics.torques(q, qd, qdd);
    EXPECT_LE((ours - Numbers(tau.data)).cwiseAbs().maxCoeff(), tolerance * ours.cwiseAbs().maxCoeff())
        << "arm " << k;
    KDL::ChainDynParam parameters(chain, in_kdl(arm.gravity));
    KDL::JntSpaceInertiaMatrix M(static_cast<int>(n));
    parameters.JntToMass(in_kdl(q), M);
    const SquareMatrix our_M = dynamics.mass(q);
    EXPECT_LE((our_M - SquareMatrix(M.data)).cwiseAbs().maxCoeff(), tolerance * our_M.cwiseAbs().maxCoeff())
        << "arm " << k;
  }
}

// One joint about the vertical.
Machine wheel(double J, double Fc, double Fv) {
  Machine out;
  out.arm.joints.resize(1);
  out.arm.joints[0].body.mass = 1.0;
  out.arm.joints[0].body.inertia_com = J * Matrix3d::Identity();
  out.Ia = Numbers::Zero(1);
  out.friction.resize(1);
  out.friction[0].Fc_plus = out.friction[0].Fc_minus = Fc;
  out.friction[0].Fv_plus = out.friction[0].Fv_minus = Fv;
  return out;
}

Numbers one(double value) { return Numbers::Constant(1, value); }

TEST(OddStiction, AWheelStopsWhereTheClosedFormHasIt) {
  constexpr double tolerance = 1e-9;
  const double J = 0.4;
  const double Fc = 0.7;
  const double Fv = 0.3;
  const double v = 2.0;
  const Plant plant(wheel(J, Fc, Fv));
  Simulation simulation(plant, 1e-3);
  simulation.start(0.0, one(0.5), one(v));
  const Simulation::Torque none = [](double, const Numbers&, const Numbers&) { return one(0.0); };
  for (int k = 1; k <= 300; ++k) {
    simulation.advance(0.01 * k, none, one(0.0));
  }
  const double stop = J / Fv * std::log(1.0 + Fv * v / Fc);
  const double way = J / Fv * v - Fc / Fv * stop;
  ASSERT_LT(stop, 3.0);
  EXPECT_TRUE(simulation.sticks(0));
  EXPECT_EQ(simulation.velocities()[0], 0.0);
  EXPECT_NEAR(simulation.positions()[0], 0.5 + way, tolerance);
}

TEST(OddStiction, ARampBreaksAwayAtItsLevel) {
  constexpr double tolerance = 1e-9;
  const double J = 0.4;
  const double Fc = 0.7;
  const double ramp = 1.3;
  const Plant plant(wheel(J, Fc, 0.0));
  Simulation simulation(plant, 1e-3);
  simulation.start(0.0, one(0.0), one(0.0));
  const Simulation::Torque torque = [&](double t, const Numbers&, const Numbers&) { return one(ramp * t); };
  const double end = 1.0;
  simulation.advance(end, torque, one(0.0));
  const double since = end - Fc / ramp;
  EXPECT_FALSE(simulation.sticks(0));
  EXPECT_NEAR(simulation.velocities()[0], ramp * since * since / (2.0 * J), tolerance);
  EXPECT_NEAR(simulation.positions()[0], ramp * since * since * since / (6.0 * J), tolerance);
}

// Between turning points a spring with dry friction swings about ±Fc / k: each swing is shorter by 2 Fc / k.
TEST(OddStiction, ASpringLosesTwoLevelsASwing) {
  constexpr double tolerance = 1e-8;
  const double J = 0.5;
  const double Fc = 0.8;
  const double k_p = 20.0;
  const Plant plant(wheel(J, Fc, 0.0));
  Simulation simulation(plant, 5e-4);
  double q = 1.0;
  simulation.start(0.0, one(q), one(0.0));
  const Simulation::Torque spring = [&](double, const Numbers& at, const Numbers&) {
    return Numbers(-k_p * at);
  };
  const double half = std::numbers::pi / std::sqrt(k_p / J);
  double t = 0.0;
  while (std::abs(k_p * q) > Fc) {
    q = -(q - std::copysign(2.0 * Fc / k_p, q));
    t += half;
    simulation.advance(t, spring, one(0.0));
    EXPECT_NEAR(simulation.positions()[0], q, tolerance);
  }
  simulation.advance(t + 1.0, spring, one(0.0));
  EXPECT_TRUE(simulation.sticks(0));
  EXPECT_NEAR(simulation.positions()[0], q, tolerance);
}

// Motor and link as two free masses with a spring between: their centre is pushed, and they swing about it.
TEST(OddElasticity, SwingsAsTwoMasses) {
  constexpr double tolerance = 1e-9;
  const double J = 0.4;
  const double Ia = 0.1;
  const double k = 300.0;
  const double tau = 0.9;
  Machine machine = wheel(J, 0.0, 0.0);
  machine.Ia = one(Ia);
  machine.stiffness = one(k);
  machine.damping = one(0.0);
  const Plant plant(machine);
  Simulation simulation(plant, 2.5e-4);
  simulation.start(0.0, one(0.0), one(0.0));
  const Simulation::Torque push = [&](double, const Numbers&, const Numbers&) { return one(tau); };
  const double reduced = Ia * J / (Ia + J);
  for (int i = 1; i <= 50; ++i) {
    const double t = 0.01 * i;
    simulation.advance(t, push, one(0.0));
    const double ahead = tau * reduced / (Ia * k) * (1.0 - std::cos(std::sqrt(k / reduced) * t));
    const double centre = tau * t * t / (2.0 * (Ia + J));
    EXPECT_NEAR(simulation.positions()[0], centre + J / (Ia + J) * ahead, tolerance);
  }
}

// Level of friction that a torque has to exceed, and what is left of it for the acceleration, both by their
// formulas.
TEST(OddFriction, IsWhatItsFormulasSay) {
  constexpr double tolerance = 1e-12;
  const double t = 3.0;
  const double v = 0.2;
  const double q = 0.7;
  const double tau = 5.0;
  Machine machine = wheel(0.4, 0.0, 0.0);
  JointFriction& friction = machine.friction[0];
  friction = {.Fv_plus = 0.5, .Fv_minus = 0.3, .Fc_plus = 0.9, .Fc_minus = 0.6, .offset = 0.1};
  friction.stribeck = 0.4;
  friction.stribeck_speed = 0.1;
  friction.load = 0.05;
  machine.drift = 0.3;
  machine.drift_time = 2.0;
  machine.ripple = one(0.2);
  machine.ripple_cycles = one(3.0);
  Equation equation;
  Plant(machine).equation(t, one(q), one(v), one(tau), one(0.25), one(1.0), equation);
  const double warm = 1.0 - 0.3 * (1.0 - std::exp(-t / 2.0));
  const double beside = 0.4 * std::exp(-4.0) + 0.05 * tau;
  EXPECT_NEAR(equation.F_plus[0], warm * (0.9 + beside), tolerance);
  EXPECT_NEAR(equation.F_minus[0], warm * (0.6 + beside), tolerance);
  const double ripple = 0.2 * std::sin(2.0 * std::numbers::pi * 3.0 * q);
  EXPECT_NEAR(equation.b[0], tau + 0.25 - 0.1 - warm * 0.5 * v - ripple, tolerance);
  EXPECT_NEAR(equation.M(0, 0), 0.4, tolerance);
}

TEST(OddDynamics, APayloadIsABodyAtTheLastLinkFromItsTimeOn) {
  constexpr double tolerance = 1e-12;
  Random random(seed, "payload", 0);
  Recipe recipe;
  recipe.joints = 4;
  Machine machine;
  machine.arm = drawn_arm(recipe, random);
  // The same arm with the point mass in its last body.
  const double m = 2.0;
  const Vector3d at(0.1, -0.2, 0.05);
  machine.payload = Machine::Payload{.body = {.mass = m, .com = at}, .from = 1.0};
  Arm loaded = machine.arm;
  Body& last = loaded.joints.back().body;
  const double whole = last.mass + m;
  const Vector3d between = at - last.com;
  last.inertia_com +=
      last.mass * m / whole * (between.squaredNorm() * Matrix3d::Identity() - between * between.transpose());
  last.com += m / whole * between;
  last.mass = whole;
  const Plant plant(machine);
  const Numbers q = random_numbers(4, 2.0, random);
  const Numbers qd = random_numbers(4, 2.0, random);
  const Numbers before = ArmDynamics(machine.arm).torques(q, qd, q);
  const Numbers after = ArmDynamics(loaded).torques(q, qd, q);
  EXPECT_LE((plant.dynamics(0.9).torques(q, qd, q) - before).norm(), tolerance * before.norm());
  EXPECT_LE((plant.dynamics(1.0).torques(q, qd, q) - after).norm(), tolerance * after.norm());
  EXPECT_GT((after - before).norm(), 0.01 * before.norm());
}

// Error of the energy after a second of falling.
double energy_error(const Arm& arm, double step, std::uint64_t number) {
  Machine machine;
  machine.arm = arm;
  machine.Ia = Numbers::Zero(arm.size());
  machine.friction.resize(arm.joints.size());
  const Plant plant(machine);
  const ArmDynamics& dynamics = plant.dynamics(0.0);
  Random random(seed, "fall", number);
  const Numbers q = random_numbers(arm.size(), 1.0, random);
  const Numbers qd = random_numbers(arm.size(), 1.0, random);
  Simulation simulation(plant, step);
  simulation.start(0.0, q, qd);
  const Index n = arm.size();
  const Simulation::Torque none = [n](double, const Numbers&, const Numbers&) {
    return Numbers(Numbers::Zero(n));
  };
  const auto kinetic = [&](const Numbers& at, const Numbers& v) {
    return 0.5 * v.dot(dynamics.mass(at) * v);
  };
  const double before = kinetic(q, qd) + dynamics.potential(q);
  simulation.advance(1.0, none, Numbers::Zero(n));
  const double moving = kinetic(simulation.positions(), simulation.velocities());
  return std::abs(moving + dynamics.potential(simulation.positions()) - before) / moving;
}

TEST(OddSimulation, KeepsTheEnergyOfAFallingArm) {
  for (std::uint64_t k = 0; k < 5; ++k) {
    Random random(seed, "falling arm", k);
    Recipe recipe;
    recipe.joints = 3;
    const Arm arm = drawn_arm(recipe, random);
    const double coarse = energy_error(arm, 2e-3, k);
    const double fine = energy_error(arm, 1e-3, k);
    EXPECT_LT(fine, 1e-6) << "arm " << k;
    // Fourth order: sixteen times less, were there no roundings.
    EXPECT_LT(fine, 0.1 * coarse + 1e-13) << "arm " << k;
  }
}

// M q̈ + N + friction − τ by rivid's model and the truth as base parameters, along a motion of ours with
// rivid's URDF reader between the two.
TEST(OddSimulation, ObeysRividsModelWithTheTrueBaseParameters) {
  // What differences of fourth order over 1e-3 s leave of controlled motions, over the torques of a joint.
  constexpr double tolerance = 1e-6;
  constexpr double h = 1e-3;
  for (std::uint64_t k = 0; k < 10; ++k) {
    Random random(seed, "model", k);
    Recipe recipe;
    recipe.joints = random.integer(2, most_joints);
    const bool all_friction = k % 2 == 1;
    recipe.Fl = all_friction ? 0.08 : 0.0;
    recipe.Fr = all_friction ? 0.6 : 0.0;
    const Arm arm = drawn_arm(recipe, random);
    const RandomMotion motion(recipe, arm, random);
    Truth truth{.recipe = recipe, .machine = drawn_machine(recipe, arm, motion, random)};
    const Index n = arm.size();
    Robot robot = parse_urdf(urdf_of(arm, Numbers::Ones(n)), "odd.urdf");
    for (Joint& joint : robot.joints) {
      joint.friction = all_friction ? Friction::load_root : joint.friction;
    }
    BaseParameters base = base_parameters(robot);
    base = at_load(base, truth.base_values(base));
    const DynamicModel model(robot, base, truth.base_values(base));
    const Plant plant(truth.machine);
    const Load load = load_of(arm, truth.machine.Ia, motion);
    const Simulation::Torque torque = [&](double t, const Numbers& q, const Numbers& qd) {
      const ReferencePoint r = motion.at(t);
      const Numbers gravity = plant.dynamics(t).torques(r.q, Numbers::Zero(n), Numbers::Zero(n));
      return Numbers(gravity + load.inertia.cwiseProduct(100.0 * (r.q - q) + 20.0 * (r.qd - qd)));
    };
    Simulation simulation(plant, h);
    const ReferencePoint begin = motion.at(0.0);
    simulation.start(0.0, begin.q, begin.qd);
    constexpr Index samples = 3000;
    Matrix q(samples, n);
    Matrix qd(samples, n);
    Matrix tau(samples, n);
    std::vector<long> events;
    for (Index i = 0; i < samples; ++i) {
      simulation.advance(h * static_cast<double>(i), torque, Numbers::Zero(n));
      q.row(i) = simulation.positions().transpose();
      qd.row(i) = simulation.velocities().transpose();
      tau.row(i) = torque(simulation.time(), simulation.positions(), simulation.velocities()).transpose();
      events.push_back(simulation.events());
    }
    Vector worst = Vector::Zero(n);
    Index judged = 0;
    for (Index i = 2; i + 2 < samples; ++i) {
      const bool smooth = events[static_cast<std::size_t>(i) + 2] == events[static_cast<std::size_t>(i) - 2];
      if (!smooth || qd.row(i).cwiseAbs().minCoeff() == 0.0) {
        continue;
      }
      const Vector qdd = (8.0 * (qd.row(i + 1) - qd.row(i - 1)) - qd.row(i + 2) + qd.row(i - 2)) / (12.0 * h);
      if (all_friction) {
        // Away from the kinks of both laws, across which differences say less.
        const Numbers gear = plant.dynamics(0.0).torques(q.row(i).transpose(), qd.row(i).transpose(), qdd) +
                             truth.machine.Ia.cwiseProduct(Numbers(qdd));
        if (qd.row(i).cwiseAbs().minCoeff() < 0.1 ||
            gear.cwiseQuotient(load.rms).cwiseAbs().minCoeff() < 0.1) {
          continue;
        }
      }
      const Vector expected = inverse_dynamics(model, q.row(i).transpose(), qd.row(i).transpose(), qdd);
      worst = worst.cwiseMax((expected - tau.row(i).transpose()).cwiseAbs());
      ++judged;
    }
    EXPECT_GT(judged, samples / (all_friction ? 20 : 3)) << "arm " << k;
    EXPECT_LE(worst.cwiseQuotient(Vector(load.rms + load.inertia)).maxCoeff(), tolerance) << "arm " << k;
  }
}

// Where joints hold each other, the held ones need no more than their level, and moving ones are braked by
// all of it.
TEST(OddStiction, HoldsWithinTheLevelAndNoLonger) {
  Random random(seed, "hold", 0);
  Recipe recipe;
  recipe.joints = 6;
  recipe.friction = 4.0;
  const Arm arm = drawn_arm(recipe, random);
  const RandomMotion motion(recipe, arm, random);
  const Machine machine = drawn_machine(recipe, arm, motion, random);
  const Plant plant(machine);
  const Index n = arm.size();
  Simulation simulation(plant, 1e-3);
  simulation.start(0.0, motion.at(0.0).q, Numbers::Zero(n));
  Numbers held;
  const Simulation::Torque torque = [&](double, const Numbers&, const Numbers&) { return held; };
  long sticking = 0;
  for (int k = 1; k <= 400; ++k) {
    const Numbers q = simulation.positions();
    held = plant.dynamics(0.0).torques(q, Numbers::Zero(n), Numbers::Zero(n));
    for (Index j = 0; j < n; ++j) {
      held[j] += 1.5 * random.uniform(-1.0, 1.0) * machine.friction[static_cast<std::size_t>(j)].Fc_plus;
    }
    const Numbers v0 = simulation.velocities();
    constexpr double short_time = 1e-7;
    simulation.advance(simulation.time() + short_time, torque, Numbers::Zero(n));
    const Numbers qdd = (simulation.velocities() - v0) / short_time;
    const Numbers needed = held - plant.dynamics(0.0).torques(q, v0, qdd) - machine.Ia.cwiseProduct(qdd);
    for (Index j = 0; j < n; ++j) {
      const JointFriction& friction = machine.friction[static_cast<std::size_t>(j)];
      const double dry = needed[j] - friction.offset - friction.Fv_plus * v0[j];
      if (simulation.sticks(j)) {
        ++sticking;
        EXPECT_EQ(simulation.velocities()[j], 0.0);
        EXPECT_LE(std::abs(dry), friction.Fc_plus * (1.0 + 1e-4));
      } else if (v0[j] * simulation.velocities()[j] > 0.0) {
        EXPECT_NEAR(dry, std::copysign(friction.Fc_plus, v0[j]), 1e-4 * friction.Fc_plus);
      }
    }
    simulation.advance(0.01 * k, torque, Numbers::Zero(n));
  }
  EXPECT_GT(sticking, 100);
}

TEST(OddMotions, JoggingMovesOneJointAtATimeAndRastersTheFirstByTurns) {
  for (const Way& way : ways()) {
    Random random(seed, way.name, 1);
    const Recipe recipe = drawn_recipe(kinds().front(), &way, random);
    const RandomMotion motion(recipe, drawn_arm(recipe, random), random);
    int several = 0;
    int first_and_others = 0;
    for (double t = 0.0; t < motion.duration(); t += 0.01) {
      const Numbers qd = motion.at(t).qd;
      several += (qd.array() != 0.0).count() > 1 ? 1 : 0;
      first_and_others += qd[0] != 0.0 && (qd.tail(qd.size() - 1).array() != 0.0).any() ? 1 : 0;
    }
    EXPECT_EQ(several == 0, way.name == "jogging") << way.name;
    EXPECT_EQ(first_and_others == 0, way.name == "jogging" || way.name == "raster") << way.name;
  }
}

}  // namespace
}  // namespace rivid::odd
