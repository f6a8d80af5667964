#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/AutoDiff>

#include "rivid/error.hpp"
#include "rivid/model/kdl.hpp"
#include "rivid/model/mdh.hpp"
#include "rivid/online/contact_observer.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/dynamics_batch.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/allocations.hpp"
#include "support/chain_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"
#include "support/tx40.hpp"

namespace rivid {
namespace {

// Same quantity by another algorithm, relative to the largest entry.
constexpr double tolerance = 1e-12;

double relative_difference(const Matrix& found, const Matrix& expected) {
  return (found - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

Robot without_friction(Robot robot) {
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::none;
  }
  return robot;
}

DynamicModel model_of(const Robot& robot) { return {robot, robot.chi_st()}; }

// Chains of 1 to 12 joints of mixed types.
void for_random_robots(std::uint64_t seed, const std::function<void(const Robot&, std::mt19937_64&)>& check) {
  for (int n = 1; n <= 12; ++n) {
    for (std::uint64_t k = 0; k < 4; ++k) {
      std::mt19937_64 random(seed + 100 * k + static_cast<std::uint64_t>(n));
      SCOPED_TRACE(std::to_string(n) + " joints, seed " + std::to_string(seed + 100 * k) + " + n");
      check(without_friction(test::random_robot(n, random)), random);
    }
  }
}

// Every way that neighbouring frames can lie in a table of modified Denavit-Hartenberg parameters.
std::vector<Robot> tables() {
  constexpr double quarter = std::numbers::pi / 2.0;
  std::vector<Robot> out;
  std::mt19937_64 random(71);
  for (const double alpha : {0.0, quarter, -quarter, 0.4}) {
    for (unsigned offsets = 0; offsets < 8; ++offsets) {
      for (const double theta : {0.0, 0.7}) {
        std::vector<MdhRow> rows;
        for (int j = 0; j < 4; ++j) {
          rows.push_back({.alpha = alpha, .theta = theta});
        }
        Robot robot = without_friction(robot_from(rows, {2.0, -3.0, -9.0}));
        for (std::size_t j = 0; j < 4; ++j) {
          for (unsigned k = 0; k < 3; ++k) {
            robot.chain.links[j].p[k] = (offsets >> k & 1U) != 0U ? 0.2 + 0.1 * k : 0.0;
          }
          robot.inertials[j] = test::random_inertial(random);
        }
        robot.name = "alpha " + std::to_string(alpha) + ", offsets " + std::to_string(offsets) + ", theta " +
                     std::to_string(theta);
        out.push_back(robot);
      }
    }
  }
  return out;
}

struct KdlTerms {
  Matrix M;
  Vector N;
};

KdlTerms kdl_terms(const Robot& robot, const Vector& q, const Vector& qd) {
  const KDL::Chain chain = kdl_chain(robot);
  const Eigen::Vector3d& g = robot.chain.gravity;
  const KDL::Vector gravity(g.x(), g.y(), g.z());
  const auto n = static_cast<unsigned>(robot.size());
  KDL::JntArray positions(n);
  KDL::JntArray velocities(n);
  const KDL::JntArray accelerations(n);
  KDL::JntArray torques(n);
  for (unsigned j = 0; j < n; ++j) {
    positions(j) = q[j];
    velocities(j) = qd[j];
  }
  KDL::JntSpaceInertiaMatrix M(static_cast<int>(n));
  KDL::ChainDynParam parameters(chain, gravity);
  EXPECT_EQ(parameters.JntToMass(positions, M), 0);
  KDL::ChainIdSolver_RNE inverse(chain, gravity);
  EXPECT_EQ(inverse.CartToJnt(positions, velocities, accelerations, KDL::Wrenches(chain.getNrOfSegments()),
                              torques),
            0);
  return {Matrix(M.data), Vector(torques.data)};
}

TEST(Dynamics, HasTheMassMatrixAndTheBiasOfKdl) {
  for_random_robots(1000, [](const Robot& robot, std::mt19937_64& random) {
    const Motion motion = test::random_motion(10, robot.size(), random);
    const DynamicModel model = model_of(robot);
    for (Index k = 0; k < motion.samples(); ++k) {
      const Vector q = motion.q.row(k);
      const Vector qd = motion.qd.row(k);
      const KdlTerms expected = kdl_terms(robot, q, qd);
      EXPECT_LT(relative_difference(mass_matrix(model, q), expected.M), tolerance);
      EXPECT_LT(relative_difference(bias(model, q, qd), expected.N), tolerance);
    }
  });
}

TEST(Dynamics, KnowsEveryGeometryThatItTakesAShortWayFor) {
  std::mt19937_64 random(72);
  for (const Robot& robot : tables()) {
    const Motion motion = test::random_motion(2, robot.size(), random);
    const DynamicModel model = model_of(robot);
    for (Index k = 0; k < motion.samples(); ++k) {
      const Vector q = motion.q.row(k);
      const Vector qd = motion.qd.row(k);
      const KdlTerms expected = kdl_terms(robot, q, qd);
      EXPECT_LT(relative_difference(mass_matrix(model, q), expected.M), tolerance) << robot.name;
      EXPECT_LT(relative_difference(bias(model, q, qd), expected.N), tolerance) << robot.name;
    }
  }
}

TEST(Dynamics, HasTheBiasOfTheRegressor) {
  for_random_robots(2000, [](const Robot& robot, std::mt19937_64& random) {
    Motion motion = test::random_motion(10, robot.size(), random);
    motion.qdd.setZero();
    const BaseParameters base = base_parameters(robot);
    const Vector tau = observation(robot, base, motion).dense() * base.from_standard(robot.chi_st());
    const DynamicModel model = model_of(robot);
    Matrix found(motion.samples(), robot.size());
    for (Index k = 0; k < motion.samples(); ++k) {
      found.row(k) = bias(model, motion.q.row(k).transpose(), motion.qd.row(k).transpose()).transpose();
    }
    EXPECT_LT(relative_difference(found.reshaped(), tau), tolerance);
  });
}

TEST(Dynamics, OfBaseParametersAloneIsTheSame) {
  // The numerical base parameters themselves are good to about 1e-12 of the largest.
  constexpr double regrouped = 1e-10;
  for_random_robots(3000, [&](const Robot& robot, std::mt19937_64& random) {
    const Motion motion = test::random_motion(1, robot.size(), random);
    const Vector q = motion.q.row(0);
    const Vector qd = motion.qd.row(0);
    const BaseParameters base = base_parameters(robot);
    const DynamicModel whole = model_of(robot);
    const DynamicModel model(robot, base, base.from_standard(robot.chi_st()));
    EXPECT_LT(relative_difference(mass_matrix(model, q), mass_matrix(whole, q)), regrouped);
    EXPECT_LT(relative_difference(bias(model, q, qd), bias(whole, q, qd)), regrouped);
  });
}

TEST(Dynamics, IsTheInverseOfTheInverseDynamics) {
  for (int n = 1; n <= 12; ++n) {
    std::mt19937_64 random(static_cast<std::uint64_t>(4000 + n));
    Robot robot = test::random_robot(n, random);
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      robot.joints[j].friction = friction_rows[(j + static_cast<std::size_t>(n)) % friction_rows.size()].law;
      robot.joints[j].sign_speed = j % 3 == 2 ? 0.4 : 0.0;
    }
    const Motion motion = test::random_motion(10, n, random);
    const DynamicModel model(robot, test::distinct_friction(robot));
    for (Index k = 0; k < motion.samples(); ++k) {
      const Vector q = motion.q.row(k);
      const Vector qd = motion.qd.row(k);
      const Vector qdd = motion.qdd.row(k);
      const Vector tau = inverse_dynamics(model, q, qd, qdd);
      EXPECT_LT(relative_difference(direct_dynamics(model, q, qd, tau), qdd), 1e-10) << n << " joints";
    }
  }
}

TEST(Dynamics, HasTheSmoothedSignsOfTheRegressor) {
  std::mt19937_64 random(4100);
  Robot robot = test::random_robot(4, random);
  robot.joints[0].friction = Friction::asymmetric;
  robot.joints[1].friction = Friction::coulomb;
  robot.joints[0].sign_speed = 0.7;
  robot.joints[1].sign_speed = 0.4;
  robot.joints[3].sign_speed = 0.5;
  for (Coupling::Coulomb coulomb : {Coupling::Coulomb::sum, Coupling::Coulomb::single}) {
    robot.joints[2].friction = robot.joints[3].friction = Friction::symmetric;
    robot.couplings = {{.motor = 3, .joints = {2}, .ratios = {0.5}, .coulomb = coulomb, .Fcm = 0.3}};
    const Motion motion = test::random_motion(10, 4, random);
    const BaseParameters base = base_parameters(robot);
    const Vector tau = observation(robot, base, motion).dense() * base.from_standard(robot.chi_st());
    const DynamicModel model = model_of(robot);
    Matrix found(motion.samples(), robot.size());
    for (Index k = 0; k < motion.samples(); ++k) {
      found.row(k) = inverse_dynamics(model, motion.q.row(k).transpose(), motion.qd.row(k).transpose(),
                                      motion.qdd.row(k).transpose())
                         .transpose();
    }
    EXPECT_LT(relative_difference(found.reshaped(), tau), tolerance) << name(coulomb);
  }
}

TEST(Dynamics, OfACoupledMotorHasItsRotorOffTheDiagonal) {
  for (const Coupling& wrist : {test::tx40_wrist(), test::tx40_wrist_of_birdy()}) {
    Robot robot = test::tx40(Friction::symmetric);
    std::mt19937_64 random(73);
    for (std::size_t j = 0; j < robot.inertials.size(); ++j) {
      robot.inertials[j] = test::random_inertial(random);
      robot.joints[j].Ia = 0.4;
    }
    const Vector q = test::random_vector(random).replicate(2, 1);
    const Matrix alone = mass_matrix(model_of(robot), q);
    robot.couplings = {wrist};
    robot.couplings[0].Iam = 0.25;
    const double coupled = wrist.inertia == Coupling::Inertia::tied ? 0.4 : 0.25;
    Matrix expected = alone;
    expected(4, 5) += coupled;
    expected(5, 4) += coupled;
    EXPECT_LT(relative_difference(mass_matrix(model_of(robot), q), expected), tolerance);
  }
}

// State of a motion without friction and torques, and one step of the classical Runge-Kutta method.
struct FreeMotion {
  explicit FreeMotion(const DynamicModel& model)
      : dynamics(model), q(Vector::Zero(model.size())), qd(Vector::Zero(model.size())) {}

  Vector acceleration(const Vector& at_q, const Vector& at_qd) {
    const auto n = static_cast<std::size_t>(at_q.size());
    EXPECT_TRUE(dynamics.set_state({at_q.data(), n}, {at_qd.data(), n}));
    Vector qdd = -Vector::Map(dynamics.N().data(), at_q.size());
    dynamics.solve({qdd.data(), n});
    return qdd;
  }

  void step(double h) {
    const Vector a1 = acceleration(q, qd);
    const Vector v2 = qd + 0.5 * h * a1;
    const Vector a2 = acceleration(q + 0.5 * h * qd, v2);
    const Vector v3 = qd + 0.5 * h * a2;
    const Vector a3 = acceleration(q + 0.5 * h * v2, v3);
    const Vector v4 = qd + h * a3;
    const Vector a4 = acceleration(q + h * v3, v4);
    q += h / 6.0 * (qd + 2.0 * v2 + 2.0 * v3 + v4);
    qd += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }

  Dynamics<double> dynamics;
  Vector q;
  Vector qd;
};

TEST(Dynamics, KeepsTheEnergyOfAFreeMotion) {
  std::mt19937_64 random(74);
  Robot robot = without_friction(test::random_robot(4, random));
  // A free sliding joint falls ever faster: turning ones alone.
  for (std::size_t j = 0; j < 4; ++j) {
    robot.chain.links[j].type = robot.joints[j].type = JointType::revolute;
  }
  const DynamicModel model = model_of(robot);
  const auto energies = [&](const FreeMotion& motion) {
    double potential = 0.0;
    const auto poses = test::forward_kinematics(robot.chain, motion.q);
    for (std::size_t j = 0; j < poses.size(); ++j) {
      const Inertial body = test::in_frame(robot.chain.links[j], robot.inertials[j]);
      potential -=
          robot.chain.gravity.dot(body[9] * poses[j].translation() + poses[j].linear() * body.segment<3>(6));
    }
    const double kinetic = 0.5 * motion.qd.dot(mass_matrix(model, motion.q) * motion.qd);
    return std::array<double, 2>{kinetic, potential};
  };
  FreeMotion motion(model);
  motion.q << 0.3, -0.8, 1.2, 0.5;
  motion.qd << 1.0, -2.0, 0.5, 1.5;
  const auto [kinetic, potential] = energies(motion);
  constexpr double h = 1e-4;
  double largest_kinetic = kinetic;
  for (int k = 0; k < 30000; ++k) {
    motion.step(h);
    if (k % 100 == 99) {
      const auto [now_kinetic, now_potential] = energies(motion);
      largest_kinetic = std::max(largest_kinetic, now_kinetic);
      // The method's own error over three seconds.
      EXPECT_NEAR(now_kinetic + now_potential, kinetic + potential, 1e-9 * largest_kinetic);
    }
  }
  EXPECT_GT(largest_kinetic, 2.0 * kinetic);
}

TEST(Dynamics, SwingsAPendulumInTheTimeOfTheEllipticIntegral) {
  constexpr double m = 1.7;
  constexpr double l = 0.35;
  constexpr double g = 9.81;
  constexpr double amplitude = 2.0;
  Robot robot = without_friction(robot_from(std::array{MdhRow{}}, {g, 0.0, 0.0}));  // hangs along x at q = 0
  robot.inertials[0] =
      inertial_from_com(m, {l, 0.0, 0.0}, Eigen::Vector3d(0.01, 0.02, 0.03).asDiagonal().toDenseMatrix());
  robot.joints[0].Ia = 0.05;
  const double I = m * l * l + 0.03 + 0.05;
  // By Gauss's mean of arithmetic and geometric means: libc++ has no std::comp_ellint_1().
  double arithmetic = 1.0;
  double geometric = std::cos(0.5 * amplitude);
  for (int k = 0; k < 8; ++k) {
    const double mean = 0.5 * (arithmetic + geometric);
    geometric = std::sqrt(arithmetic * geometric);
    arithmetic = mean;
  }
  const double expected = 2.0 * std::numbers::pi * std::sqrt(I / (m * g * l)) / arithmetic;

  FreeMotion motion(model_of(robot));
  motion.q[0] = amplitude;
  constexpr double h = 1e-4;
  double t = 0.0;
  double before = 0.0;
  // A quarter of the period, to the lowest point, where the acceleration vanishes.
  while (motion.q[0] > 0.0) {
    before = motion.q[0];
    motion.step(h);
    t += h;
  }
  t -= h * motion.q[0] / (motion.q[0] - before);
  EXPECT_NEAR(4.0 * t, expected, 1e-10 * expected);
}

std::vector<Simd> sets() {
  std::vector<Simd> out;
  for (const Simd simd : {Simd::baseline, Simd::avx2, Simd::avx512}) {
    if (supported(simd)) {
      out.push_back(simd);
    }
  }
  return out;
}

Matrix accelerations_one_by_one(const DynamicModel& model, const Motion& motion, const Matrix& tau) {
  Dynamics<double> one(model);
  const auto n = static_cast<std::size_t>(model.size());
  Matrix out(motion.samples(), model.size());
  for (Index k = 0; k < motion.samples(); ++k) {
    const Vector q = motion.q.row(k);
    const Vector qd = motion.qd.row(k);
    EXPECT_TRUE(one.set_state({q.data(), n}, {qd.data(), n}));
    Vector qdd = tau.row(k).transpose() - Vector::Map(one.N().data(), model.size());
    one.solve({qdd.data(), n});
    out.row(k) = qdd;
  }
  return out;
}

TEST(DynamicsBatch, IsTheDynamicsOfEachSampleByEveryInstructionSet) {
  // Other sines and fused operations, through the condition of M.
  constexpr double rounding = 1e-10;
  const auto check = [&](const Robot& robot, std::mt19937_64& random) {
    Motion motion = test::random_motion(21, robot.size(), random);
    motion.q(3, 0) = 2e5;  // beyond the vector kernels' own sines
    const Matrix tau = test::random_motion(21, robot.size(), random).qdd;
    const DynamicModel model = model_of(robot);
    const Matrix expected = accelerations_one_by_one(model, motion, tau);
    for (const Simd simd : sets()) {
      DynamicsBatch batch(model, simd);
      EXPECT_EQ(batch.simd(), simd);
      Matrix found(21, robot.size());
      EXPECT_FALSE(batch.accelerations(motion.q, motion.qd, tau, found));
      EXPECT_LT(relative_difference(found, expected), rounding) << name(simd);
    }
  };
  for_random_robots(5000, check);
  std::mt19937_64 random(75);
  for (const Robot& robot : tables()) {
    SCOPED_TRACE(robot.name);
    check(robot, random);
  }
}

TEST(DynamicsBatch, DoesNotDependOnWhereABatchEnds) {
  std::mt19937_64 random(76);
  const DynamicModel model = model_of(without_friction(test::random_robot(6, random)));
  const Motion motion = test::random_motion(21, 6, random);
  for (const Simd simd : sets()) {
    DynamicsBatch batch(model, simd);
    Matrix all(21, 6);
    EXPECT_FALSE(batch.accelerations(motion.q, motion.qd, motion.qdd, all));
    for (Index count = 1; count < 21; ++count) {
      Matrix some(21, 6);
      EXPECT_FALSE(batch.accelerations(motion.q.topRows(count), motion.qd.topRows(count),
                                       motion.qdd.topRows(count), some.topRows(count)));
      EXPECT_EQ(some.topRows(count), all.topRows(count)) << name(simd) << ", " << count;
    }
  }
}

template <typename Scalar>
std::vector<Scalar> as(const Vector& values) {
  std::vector<Scalar> out;
  for (const double value : values) {
    out.push_back(static_cast<Scalar>(value));
  }
  return out;
}

TEST(Dynamics, OfPacksIsThatOfEachLane) {
  std::mt19937_64 random(77);
  for (const int n : {1, 6, 9}) {
    const DynamicModel model = model_of(without_friction(test::random_robot(n, random)));
    const Motion motion = test::random_motion(Pack::lanes, n, random);
    std::vector<Pack> q;
    std::vector<Pack> qd;
    std::vector<Pack> b;
    for (Index j = 0; j < n; ++j) {
      q.push_back(Pack::load(motion.q.col(j).data()));
      qd.push_back(Pack::load(motion.qd.col(j).data()));
      b.push_back(Pack::load(motion.qdd.col(j).data()));
    }
    Dynamics<Pack> packs(model);
    ASSERT_TRUE(packs.set_state(q, qd));
    packs.solve(b);
    Dynamics<double> one(model);
    for (int lane = 0; lane < Pack::lanes; ++lane) {
      const auto N = static_cast<std::size_t>(n);
      const Vector position = motion.q.row(lane);
      const Vector velocity = motion.qd.row(lane);
      ASSERT_TRUE(one.set_state({position.data(), N}, {velocity.data(), N}));
      Vector x = motion.qdd.row(lane);
      one.solve({x.data(), N});
      for (Index j = 0; j < n; ++j) {
        const auto at = static_cast<std::size_t>(j);
        EXPECT_NEAR(packs.N()[at][lane], one.N()[at], 1e-12 * Vector::Map(one.N().data(), n).norm());
        EXPECT_NEAR(packs.M(j, j)[lane], one.M(j, j), 1e-12 * one.M(0, 0));
        EXPECT_NEAR(b[at][lane], x[j], 1e-10 * x.norm());
      }
    }
  }
}

TEST(Dynamics, WorksInSinglePrecision) {
  std::mt19937_64 random(78);
  const DynamicModel model = model_of(without_friction(test::random_robot(5, random)));
  const Motion motion = test::random_motion(1, 5, random);
  Dynamics<float> dynamics(model);
  const std::vector<float> q = as<float>(motion.q.row(0));
  ASSERT_TRUE(dynamics.set_state(q, as<float>(motion.qd.row(0))));
  const Vector expected = bias(model, motion.q.row(0).transpose(), motion.qd.row(0).transpose());
  for (Index j = 0; j < 5; ++j) {
    EXPECT_NEAR(static_cast<double>(dynamics.N()[static_cast<std::size_t>(j)]), expected[j],
                1e-4 * expected.norm());
  }
}

TEST(Dynamics, CanBeDifferentiated) {
  constexpr int n = 3;
  using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, n, 1>>;
  std::mt19937_64 random(79);
  const DynamicModel model = model_of(without_friction(test::random_robot(n, random)));
  const Motion motion = test::random_motion(1, n, random);
  const Vector q = motion.q.row(0);
  const Vector qd = motion.qd.row(0);
  const auto acceleration = [&](const Vector& at) { return direct_dynamics(model, at, qd, Vector::Zero(n)); };
  std::vector<Dual> positions;
  std::vector<Dual> velocities;
  for (int j = 0; j < n; ++j) {
    positions.emplace_back(q[j], n, j);
    velocities.emplace_back(qd[j]);
  }
  Dynamics<Dual> dynamics(model);
  ASSERT_TRUE(dynamics.set_state(positions, velocities));
  std::vector<Dual> qdd;
  for (const Dual& value : dynamics.N()) {
    qdd.push_back(-value);
  }
  dynamics.solve(qdd);
  constexpr double h = 1e-5;
  for (int j = 0; j < n; ++j) {
    const Vector step = h * Vector::Unit(n, j);
    const Vector slope = (acceleration(q + step) - acceleration(q - step)) / (2.0 * h);
    for (int i = 0; i < n; ++i) {
      // Error of central differences.
      EXPECT_NEAR(qdd[static_cast<std::size_t>(i)].derivatives()[j], slope[i], 1e-6 * (1.0 + slope.norm()));
    }
  }
}

TEST(Dynamics, AllocatesNothingForASample) {
  std::mt19937_64 random(80);
  for (const int n : {1, 6, 12}) {
    const DynamicModel model = model_of(without_friction(test::random_robot(n, random)));
    const Motion motion = test::random_motion(21, n, random);
    Dynamics<double> one(model);
    DynamicsBatch batch(model);
    Matrix qdd(21, n);
    std::vector<double> b(static_cast<std::size_t>(n), 1.0);
    const std::vector<double> q(static_cast<std::size_t>(n), 0.3);
    const long before = test::allocations;
    const bool definite = one.set_state(q, q);
    one.solve(b);
    const auto fault = batch.accelerations(motion.q, motion.qd, motion.qdd, qdd);
    EXPECT_EQ(test::allocations, before);
    EXPECT_TRUE(definite && !fault && std::isfinite(b[0]) && qdd.allFinite());
  }
}

// The SCARA with a link that is lighter than nothing: joint 2 loses its inertia where it is, joint 1 where
// the arm is stretched.
TEST(Dynamics, TellsWhichJointLosesItsInertia) {
  Robot robot = test::scara();
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::none;
  }
  constexpr Index ZZ = 5;
  constexpr Index MX = 6;
  robot.inertials[0][ZZ] = 1.0;
  robot.inertials[1][ZZ] = -0.2;
  const DynamicModel second = model_of(robot);
  Dynamics<double> dynamics(second);
  const std::array q = {0.3, 0.5};
  EXPECT_FALSE(dynamics.set_state(q, q));
  EXPECT_EQ(dynamics.failed_joint(), 1);
  EXPECT_EQ(dynamics.M(1, 1), -0.2);
  EXPECT_TRUE(std::isfinite(dynamics.N()[0]));
  EXPECT_EQ(test::complaint_of<NumericsError>([&] {
              return direct_dynamics(second, Eigen::Vector2d(0.3, 0.5), Eigen::Vector2d::Zero(),
                                     Eigen::Vector2d::Zero());
            }),
            "direct_dynamics: M(q) is not positive definite, its smallest eigenvalue is -0.239; joint "
            "\"joint_2\" would have no positive inertia while those behind it are free");

  // M11 = 0.5 + 0.2 + cos q2 and M22 = 0.2, M12 = 0.2 + cos q2 / 2.
  robot.inertials[0][ZZ] = 0.5;
  robot.inertials[1][ZZ] = 0.2;
  robot.inertials[1][MX] = 1.0;
  const DynamicModel first = model_of(robot);
  Dynamics<double> other(first);
  const std::array stretched = {0.0, 0.0};
  const std::array bent = {0.0, 1.6};
  EXPECT_FALSE(other.set_state(stretched, stretched));
  EXPECT_EQ(other.failed_joint(), 0);
  EXPECT_LT(smallest_eigenvalue(first, Eigen::Vector2d(0.0, 0.0)), 0.0);
  EXPECT_TRUE(other.set_state(bent, stretched));
  EXPECT_EQ(other.failed_joint(), -1);
  EXPECT_GT(smallest_eigenvalue(first, Eigen::Vector2d(0.0, 1.6)), 0.0);

  // The same in packs: the first sample that is stretched.
  Matrix motion = Matrix::Zero(29, 2);
  motion.col(1).setConstant(1.6);
  motion(22, 1) = motion(27, 1) = 0.0;
  const Matrix zero = Matrix::Zero(29, 2);
  for (const Simd simd : sets()) {
    DynamicsBatch batch(first, simd);
    Matrix qdd = Matrix::Zero(29, 2);
    const auto fault = batch.accelerations(motion, zero, motion, qdd);
    ASSERT_TRUE(fault);
    EXPECT_EQ(fault->sample, 22);
    EXPECT_EQ(fault->joint, 0);
    EXPECT_TRUE(qdd.allFinite());
    EXPECT_GT(qdd.row(21).norm(), 0.0);
    EXPECT_EQ(qdd.bottomRows(7).norm(), 0.0);
    const auto late =
        batch.accelerations(motion.bottomRows(3), zero.topRows(3), zero.topRows(3), qdd.topRows(3));
    ASSERT_TRUE(late);
    EXPECT_EQ(late->sample, 1);
  }
}

TEST(Dynamics, TakesAMassMatrixOfRoundingErrorsForSingular) {
  Robot robot = without_friction(test::scara());
  robot.joints[1].rotor_inertia = false;
  robot.inertials[0][5] = 1.0;  // ZZ1 alone: joint 2 moves nothing
  Dynamics<double> dynamics(model_of(robot));
  const std::array q = {0.3, 0.5};
  EXPECT_FALSE(dynamics.set_state(q, q));
  EXPECT_EQ(dynamics.failed_joint(), 1);
}

TEST(Dynamics, SaysWhichSizeIsWrong) {
  const DynamicModel model = model_of(test::scara());
  const Vector two = Vector::Zero(2);
  const Vector three = Vector::Zero(3);
  EXPECT_EQ(test::complaint_of([&] { return mass_matrix(model, three); }),
            "mass_matrix: q has 3 values, the robot has 2 joints");
  EXPECT_EQ(test::complaint_of([&] { return bias(model, two, three); }),
            "bias: qd has 3 values, the robot has 2 joints");
  EXPECT_EQ(test::complaint_of([&] { return direct_dynamics(model, two, two, three); }),
            "direct_dynamics: tau has 3 values, the robot has 2 joints");
  DynamicsBatch batch(model);
  Matrix qdd(4, 2);
  EXPECT_EQ(test::complaint_of([&] {
              return batch.accelerations(Matrix::Zero(4, 2), Matrix::Zero(3, 2), Matrix::Zero(4, 2), qdd);
            }),
            "DynamicsBatch::accelerations: qd is (3 x 2), must be (4 x 2)");
}

TEST(ModelData, OfWhichNoDynamicsCanBeMadeIsRefusedByAllOfThem) {
  struct Case {
    void (*spoil)(ModelData&);
    const char* words;
  };
  for (const auto& [spoil, words] :
       {Case{[](ModelData& m) { m.chain.links.clear(); }, "ModelData: chain has no moving joint"},
        Case{[](ModelData& m) { m.names.clear(); },
             "ModelData: names has 0 entries, must have 2, one a joint"},
        Case{[](ModelData& m) { m.inertials.pop_back(); },
             "ModelData: inertials has 1 entry, must have 2, one a joint"},
        Case{[](ModelData& m) { m.offset = Vector::Zero(1); },
             "ModelData: offset has 1 entry, must have 2, one a joint"},
        Case{[](ModelData& m) { m.rotor = Matrix::Zero(1, 1); },
             "ModelData: rotor is (1 x 1), must be (2 x 2)"},
        Case{[](ModelData& m) { m.viscous = Matrix::Zero(2, 3); },
             "ModelData: viscous is (2 x 3), must be (2 x 2)"},
        Case{[](ModelData& m) { m.offset[1] = std::nan(""); },
             "ModelData: rotor, viscous and offset must be finite"},
        Case{[](ModelData& m) { m.dry_friction[0].direction.resize(1); },
             "ModelData: dry_friction of \"joint_1\": direction has 1 value and torque 2, must have 2, one a "
             "joint"},
        Case{[](ModelData& m) { m.dry_friction[0].direction.setZero(); },
             "ModelData: dry_friction of \"joint_1\": direction and torque must be finite, and direction not "
             "zero"},
        Case{[](ModelData& m) { m.dry_friction[0].load = 1.0; },
             "ModelData: dry_friction of \"joint_1\": load is 1, must be at least 0 and below 1"}}) {
    Robot robot = test::scara();
    robot.joints[0].Fc = 1.0;
    robot.inertials.assign(2, inertial_from_com(1.0, {0.1, 0.0, 0.0}, Eigen::Matrix3d::Identity()));
    ModelData model = DynamicModel(robot, robot.chi_st());
    EXPECT_EQ(model.complaint(), std::nullopt);
    spoil(model);
    EXPECT_EQ(test::complaint_of([&] { return Dynamics<double>(model); }), words);
    EXPECT_EQ(test::complaint_of([&] { return DynamicsBatch(model).joints(); }), words);
    EXPECT_EQ(
        test::complaint_of([&] { return InverseDynamics(model, {.smoothing_speed = Vector::Ones(2)}); }),
        words);
    EXPECT_EQ(test::complaint_of([&] { return ContactObserver<double>(model).size(); }), words);
  }
}

}  // namespace
}  // namespace rivid
