#include "rivid/online/contact_observer.hpp"

#include <gtest/gtest.h>

#include <kdl/chaindynparam.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <vector>

#include "rivid/model/kdl.hpp"
#include "support/complaint.hpp"
#include "support/mallocs.hpp"
#include "support/normal.hpp"
#include "support/online.hpp"
#include "support/random_chain.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

KDL::JntArray joint_array(const Vector& x) {
  KDL::JntArray out(static_cast<unsigned>(x.size()));
  for (Index j = 0; j < x.size(); ++j) {
    out(static_cast<unsigned>(j)) = x[j];
  }
  return out;
}

// M q̇, by KDL.
Vector kdl_momentum(KDL::ChainDynParam& dynamics, const Vector& q, const Vector& qd) {
  KDL::JntSpaceInertiaMatrix M(static_cast<int>(q.size()));
  dynamics.JntToMass(joint_array(q), M);
  return M.data * qd;
}

TEST(Momentum, IsThatOfKdlAndItsKineticEnergyHasTheSlopes) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::RandomChain draw(seed);
    const KDL::Chain chain = draw.chain();
    Robot robot = robot_from(chain, {1.0, -2.0, -9.0});
    for (Joint& joint : robot.joints) {
      joint.friction = Friction::none;
    }
    const Index n = robot.size();
    const BaseParameters base = base_parameters(robot);
    detail::Momentum<double> momentum(DynamicModel(robot, base, base.from_standard(robot.chi_st())));
    KDL::ChainDynParam kdl(chain, KDL::Vector(1.0, -2.0, -9.0));
    const Vector q = draw.positions(n);
    const Vector qd = draw.positions(n);
    Vector p(n);
    Vector rate(n);
    momentum(q.data(), qd.data(), p.data(), rate.data());
    const Vector expected = kdl_momentum(kdl, q, qd);
    const double scale =
        expected.cwiseAbs().maxCoeff() + base.from_standard(robot.chi_st()).cwiseAbs().maxCoeff();
    EXPECT_LE((p - expected).cwiseAbs().maxCoeff(), 1e-12 * scale);
    KDL::JntArray gravity(static_cast<unsigned>(n));
    kdl.JntToGravity(joint_array(q), gravity);
    for (Index j = 0; j < n; ++j) {
      // Central difference of ½ q̇ᵀ M q̇ by q_j.
      constexpr double step = 1e-5;
      const Vector by = step * Vector::Unit(n, j);
      const double slope =
          (qd.dot(kdl_momentum(kdl, q + by, qd)) - qd.dot(kdl_momentum(kdl, q - by, qd))) / (4.0 * step);
      EXPECT_NEAR(rate[j], slope - gravity.data[j], 1e-7 * (scale + std::abs(slope))) << "joint " << j;
    }
  }
}

struct Scene {
  Robot robot;
  DynamicModel model;
  Motion motion;
  Matrix tau;
};

constexpr double f_m = 1000.0;

Scene scene(int joints, std::uint64_t seed, double seconds, bool revolute = false) {
  std::mt19937_64 random(seed);
  Robot robot = test::random_robot(joints, random);
  for (Index j = 0; j < robot.size(); ++j) {
    Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    joint.friction = Friction::viscous;
    if (revolute) {
      robot.chain.links[static_cast<std::size_t>(j)].type = joint.type = JointType::revolute;
    }
  }
  DynamicModel model(robot, robot.chi_st());
  const Motion motion = test::Wandering(joints, seed).at(test::ticks(seconds, f_m));
  Matrix tau = test::torques(model, motion);
  return {std::move(robot), std::move(model), motion, std::move(tau)};
}

// Torque from the last tick to this one: the mean of both, of a smooth one.
Vector held(const Matrix& tau, Index k) {
  return 0.5 * (tau.row(k) + tau.row(std::max<Index>(k - 1, 0))).transpose();
}

TEST(ContactObserver, FollowsAnExternalTorqueThroughItsLowPass) {
  const Scene s = scene(6, 3, 2.0);
  ContactObserver<double> observer(s.model, {.f_m = f_m, .bandwidth = 40.0});
  const Vector push = Vector::LinSpaced(6, 1.0, 6.0);
  constexpr Index from = 1000;
  double silent = 0.0;
  for (Index k = 0; k < s.tau.rows(); ++k) {
    const Vector tau = held(s.tau, k) - (k > from ? push : Vector(Vector::Zero(6)));
    observer.update(s.motion.q.row(k).transpose(), s.motion.qd.row(k).transpose(), tau);
    if (k <= from) {
      silent = std::max(silent, observer.residual().cwiseAbs().maxCoeff());
    } else {
      const double part = 1.0 - std::exp(-40.0 * static_cast<double>(k - from) / f_m);
      // The trapezoid's error on a smooth motion, as large as that of the silent time.
      EXPECT_LE((observer.residual() - part * push).cwiseAbs().maxCoeff(), 2.0 * silent + 1e-9);
    }
  }
  EXPECT_LE(silent, 1e-4 * s.tau.cwiseAbs().maxCoeff());
}

TEST(ContactObserver, KnowsThePayloadThatItIsTold) {
  const Scene s = scene(6, 3, 1.0);
  const Inertial body =
      inertial_from_com(3.0, {0.1, -0.05, 0.2}, Eigen::Vector3d(0.02, 0.03, 0.04).asDiagonal());
  const DynamicModel loaded(s.robot, test::loaded(s.robot, s.robot.chi_st(), body));
  ContactObserver<double> given(s.model, {.f_m = f_m});
  given.set_payload(body);
  ContactObserver<double> knows(loaded, {.f_m = f_m});
  double largest = 0.0;
  for (Index k = 0; k < s.tau.rows(); ++k) {
    given.update(s.motion.q.row(k).transpose(), s.motion.qd.row(k).transpose(), s.tau.row(k).transpose());
    knows.update(s.motion.q.row(k).transpose(), s.motion.qd.row(k).transpose(), s.tau.row(k).transpose());
    largest = std::max(largest, knows.residual().cwiseAbs().maxCoeff());
    ASSERT_LE((given.residual() - knows.residual()).cwiseAbs().maxCoeff(), 1e-9 * (1.0 + largest));
  }
  EXPECT_GE(largest, 1.0);
}

TEST(ContactObserver, LearnsThresholdsAndNamesTheLinkAndTheForce) {
  const Scene s = scene(6, 4, 60.0);
  ContactObserver<double> observer(s.model, {.f_m = f_m});
  std::mt19937_64 random(4);
  test::Normal noise(0.0, 0.5);
  const auto tick = [&](Index k, const Vector& external, auto mode) {
    Vector tau = held(s.tau, k) - external;
    for (double& x : tau) {
      x += noise(random);
    }
    return observer.update(s.motion.q.row(k).transpose(), s.motion.qd.row(k).transpose(), tau, mode);
  };
  using Mode = ContactObserver<double>::Mode;
  const Vector none = Vector::Zero(6);
  EXPECT_TRUE(std::isinf(observer.threshold(0)));
  EXPECT_FALSE(observer.learned(0));
  for (Index k = 0; k < 40000; ++k) {
    EXPECT_FALSE(tick(k, none, Mode::learn));
    for (Index j = 0; j < 6; ++j) {
      ASSERT_EQ(observer.learned(j), std::isfinite(observer.threshold(j)));
    }
  }
  EXPECT_TRUE(observer.learned(0));
  Index alarms = 0;
  for (Index k = 40000; k < 55000; ++k) {
    alarms += tick(k, none, Mode::observe) ? 1 : 0;
  }
  EXPECT_EQ(alarms, 0);
  // A force on a point of link 4, by KDL's Jacobian.
  const KDL::Chain chain = kdl_chain(s.robot);
  constexpr Index link = 3;
  const Eigen::Vector3d force(60.0, -80.0, 40.0);
  for (Index k = 55000; k < 55500; ++k) {
    KDL::Chain part;
    for (unsigned i = 0; i <= link; ++i) {
      part.addSegment(chain.getSegment(i));
    }
    KDL::ChainJntToJacSolver solver(part);
    KDL::Jacobian J(link + 1);
    ASSERT_GE(solver.JntToJac(joint_array(s.motion.q.row(k).head(link + 1).transpose()), J), 0);
    Vector external = none;
    external.head(link + 1) = J.data.topRows<3>().transpose() * force;
    tick(k, external, Mode::observe);
  }
  EXPECT_TRUE(observer.contact());
  EXPECT_LE(observer.link(), link);
  const Eigen::Vector3d found = observer.force(link, Eigen::Vector3d::Zero());
  EXPECT_LE((found - force).norm(), 0.1 * force.norm()) << found.transpose();
}

// A rate that is high enough to be counted.
TEST(ContactObserver, GivesNoMoreFalseAlarmsThanItsThresholdsAreMadeFor) {
  const Scene s = scene(3, 6, 60.0);
  constexpr double per_hour = 360.0;
  ContactObserver<double> observer(s.model, {.f_m = f_m, .alarms_per_hour = per_hour});
  std::mt19937_64 random(6);
  test::Normal noise(0.0, 0.5);
  using Mode = ContactObserver<double>::Mode;
  constexpr double learned = 600.0;
  constexpr double watched = 1200.0;
  int alarms = 0;
  double since = 10.0;
  const auto total = static_cast<Index>((learned + watched) * f_m);
  for (Index k = 0; k < total; ++k) {
    const Index at = k % s.tau.rows();
    if (at == 0) {  // the motion jumps
      observer.reset();
    }
    Vector tau = held(s.tau, at);
    for (double& x : tau) {
      x += noise(random);
    }
    const bool learns = static_cast<double>(k) < learned * f_m;
    const bool on = observer.update(s.motion.q.row(at).transpose(), s.motion.qd.row(at).transpose(), tau,
                                    learns ? Mode::learn : Mode::observe);
    since += 1.0 / f_m;
    alarms += on && since > 1.0 ? 1 : 0;
    since = on ? 0.0 : since;
  }
  const double asked = per_hour * watched / 3600.0;
  EXPECT_LE(alarms, asked);
  // Gumbel's tail is longer than that of normal noise, but not much: thresholds twice as high would give
  // none.
  EXPECT_GE(alarms, asked / 20.0);
}

// Friction that the model has wrong is the mean of its direction.
TEST(ContactObserver, TakesOffWhatWrongFrictionLeaves) {
  const Scene s = scene(3, 7, 60.0);
  ContactObserver<double> observer(s.model, {.f_m = f_m});
  std::mt19937_64 random(7);
  test::Normal noise(0.0, 2.0);
  constexpr double Fc = 3.0;
  using Mode = ContactObserver<double>::Mode;
  int contacts = 0;
  Vector residual = Vector::Zero(3);  // mean along the motion
  Vector relative = Vector::Zero(3);
  constexpr Index learned = 50000;
  const auto watched = static_cast<double>(s.tau.rows() - learned);
  for (Index k = 0; k < s.tau.rows(); ++k) {
    Vector tau = held(s.tau, k);
    Vector direction(3);
    for (Index j = 0; j < 3; ++j) {
      direction[j] = sign(s.motion.qd(k, j));
      tau[j] += Fc * direction[j] + noise(random);
    }
    const Mode mode = k < learned ? Mode::learn : Mode::observe;
    contacts += observer.update(s.motion.q.row(k).transpose(), s.motion.qd.row(k).transpose(), tau, mode);
    if (mode == Mode::observe) {
      residual += observer.residual().cwiseProduct(direction) / watched;
      relative += observer.relative().cwiseProduct(direction) / watched;
    }
  }
  EXPECT_EQ(contacts, 0);
  for (Index j = 0; j < 3; ++j) {
    EXPECT_LE(residual[j], -0.5 * Fc);
    EXPECT_LE(std::abs(relative[j]), 0.15);
  }
}

// In five minutes dry friction grows from nothing to four times what the thresholds were learned for.
TEST(ContactObserver, FollowsFrictionThatDriftsAndStillFeelsATouch) {
  const Scene s = scene(3, 7, 60.0);
  using Mode = ContactObserver<double>::Mode;
  constexpr Index learned = 60'000;
  constexpr Index watched = 300'000;
  for (const Mode mode : {Mode::follow, Mode::observe}) {
    ContactObserver<double> observer(s.model, {.f_m = f_m, .memory = 20.0});
    std::mt19937_64 random(7);
    test::Normal noise(0.0, 0.5);
    const auto tick = [&](Index k, double Fc, const Vector& external, Mode as) {
      const Index at = k % s.tau.rows();
      if (at == 0) {  // the motion jumps
        observer.reset();
      }
      Vector tau = held(s.tau, at) - external;
      for (Index j = 0; j < 3; ++j) {
        tau[j] += Fc * sign(s.motion.qd(at, j)) + noise(random);
      }
      return observer.update(s.motion.q.row(at).transpose(), s.motion.qd.row(at).transpose(), tau, as);
    };
    const Vector none = Vector::Zero(3);
    for (Index k = 0; k < learned; ++k) {
      tick(k, 0.0, none, Mode::learn);
    }
    Index touched = 0;
    for (Index k = 0; k < watched; ++k) {
      touched += tick(k, 2.0 * static_cast<double>(k) / watched, none, mode) ? 1 : 0;
    }
    if (mode == Mode::observe) {
      EXPECT_GE(touched, watched / 20);
      continue;
    }
    EXPECT_EQ(touched, 0);
    const Vector push = Vector::Constant(3, 3.0);
    const double level = observer.level(0);
    for (Index k = 0; k < 2000; ++k) {
      touched += tick(k, 2.0, push, mode) ? 1 : 0;
    }
    EXPECT_GE(touched, 1900);
    EXPECT_EQ(observer.level(0), level) << "nothing is learned of a touch";
  }
}

// A blow of 20 ms is a collision at once; a push that grows slowly is a contact and none. A contact goes on
// until r has been below half of the threshold for `hold`.
TEST(ContactObserver, DistinguishesACollisionFromASlowPush) {
  const Scene s = scene(3, 6, 60.0);
  ContactObserver<double> observer(s.model, {.f_m = f_m, .hold = 0.2});
  std::mt19937_64 random(6);
  test::Normal noise(0.0, 0.5);
  using Mode = ContactObserver<double>::Mode;
  const auto tick = [&](Index k, double external, Mode mode) {
    Vector tau = held(s.tau, k) - Vector::Constant(3, external);
    for (double& x : tau) {
      x += noise(random);
    }
    observer.update(s.motion.q.row(k).transpose(), s.motion.qd.row(k).transpose(), tau, mode);
  };
  Index k = 0;
  for (; k < 50'000; ++k) {
    tick(k, 0.0, Mode::learn);
  }
  Index first = -1;
  for (Index i = 0; i < 20; ++i, ++k) {
    tick(k, 5.0, Mode::observe);
    first = first < 0 && observer.collision() ? i : first;
  }
  EXPECT_GE(first, 0);
  EXPECT_LE(first, 15);
  for (Index i = 0; i < 1000; ++i, ++k) {
    tick(k, 0.0, Mode::observe);
  }
  EXPECT_FALSE(observer.collision() || observer.contact());
  bool collided = false;
  for (Index i = 0; i < 2000; ++i, ++k) {
    tick(k, 5.0 * static_cast<double>(i) / 2000.0, Mode::observe);
    collided = collided || observer.collision();
  }
  EXPECT_FALSE(collided);
  EXPECT_TRUE(observer.contact() && observer.link_settled());
  Index still = 0;
  for (Index i = 0; i < 1000 && observer.contact(); ++i, ++k) {
    tick(k, 0.0, Mode::observe);
    still += std::abs(observer.relative().cwiseAbs().maxCoeff()) < 0.5 ? 1 : 0;
  }
  EXPECT_FALSE(observer.contact());
  EXPECT_GE(still, 200);
  EXPECT_LE(still, 260);
}

// Force and moment on the last link, by KDL's Jacobian: their errors are as large as they are said to be.
TEST(ContactObserver, KnowsTheSixComponentsOfAWrenchAndTheirDeviations) {
  const Scene s = scene(6, 4, 0.1, true);
  ContactObserver<double> observer(s.model, {.f_m = f_m});
  std::mt19937_64 random(4);
  test::Normal noise(0.0, 0.5);
  using Mode = ContactObserver<double>::Mode;
  const Vector q = s.motion.q.row(0).transpose();
  const Vector rest = Vector::Zero(6);
  KDL::ChainJntToJacSolver solver(kdl_chain(s.robot));
  KDL::Jacobian J(6);
  ASSERT_GE(solver.JntToJac(joint_array(q), J), 0);
  Eigen::Matrix<double, 6, 1> wrench;
  wrench << 20.0, -30.0, 10.0, 2.0, -1.0, 3.0;
  const Vector gravity = inverse_dynamics(s.model, q, rest, rest);
  const Vector external = J.data.transpose() * wrench;
  Eigen::Matrix<double, 6, 1> squares = Eigen::Matrix<double, 6, 1>::Zero();
  constexpr Index learned = 30'000;
  constexpr Index count = 500;
  for (Index k = 0; k < learned + 1000 + 100 * count; ++k) {
    Vector tau = gravity - (k < learned ? rest : external);
    for (double& x : tau) {
      x += noise(random);
    }
    observer.update(q, rest, tau, k < learned ? Mode::learn : Mode::observe);
    if (k >= learned + 1000 && k % 100 == 0) {  // r has forgotten what it was
      const auto found = observer.wrench(5, Eigen::Vector3d::Zero());
      squares += (found.value - wrench).cwiseQuotient(found.sigma).cwiseAbs2();
    }
  }
  for (Index i = 0; i < 6; ++i) {
    EXPECT_NEAR(squares[i] / count, 1.0, 0.3) << "component " << i;  // four deviations of χ² over its mean
  }
}

TEST(ContactObserver, NeverAllocatesAndComesBackBitByBit) {
  const Scene s = scene(7, 5, 3.0);
  ContactObserver<double> observer(s.model, {.f_m = f_m});
  ContactObserver<double> twin = observer;
  std::vector<std::byte> state(state_size(observer));
  const Matrix q = s.motion.q.transpose();
  const Matrix qd = s.motion.qd.transpose();
  const Matrix tau = s.tau.transpose();
  const auto tick = [&](ContactObserver<double>& o, Index k) {
    o.update(q.col(k), qd.col(k), tau.col(k),
             k < 2000 ? ContactObserver<double>::Mode::learn : ContactObserver<double>::Mode::observe);
    return o.force(6, Eigen::Vector3d::Zero());
  };
  const long count = test::allocations_of([&] {
    for (Index k = 0; k < q.cols(); ++k) {
      static_cast<void>(tick(observer, k));
      if (k == 1500) {
        ASSERT_TRUE(save_state(observer, state));
      }
    }
  });
  EXPECT_EQ(count, 0);
  ASSERT_TRUE(restore_state(twin, state));
  for (Index k = 1501; k < q.cols(); ++k) {
    static_cast<void>(tick(twin, k));
  }
  EXPECT_EQ((observer.relative() - twin.relative()).cwiseAbs().maxCoeff(), 0.0);
}

TEST(ContactObserver, SaysWhatIsWrong) {
  const Scene s = scene(3, 5, 0.1);
  const auto complaint = [&](const ContactObserverOptions& options) {
    return test::complaint_of([&] { ContactObserver<double>(s.model, options); });
  };
  EXPECT_EQ(complaint({.f_m = 0.0}), "ContactObserver: f_m is 0 Hz, must be positive");
  EXPECT_EQ(complaint({.f_m = 10.0, .bandwidth = 30.0}),
            "ContactObserver: bandwidth is 30 rad/s, must lie below f_m = 10 Hz");
  EXPECT_EQ(complaint({.smoothing_speed = Vector::Zero(3)}),
            "ContactObserver: smoothing_speed must have 3 positive values, one a joint");
  EXPECT_EQ(complaint({.hold = -1.0}), "ContactObserver: hold is -1 s, must not be negative");
  EXPECT_EQ(complaint({.memory = 0.0}), "ContactObserver: memory is 0 s, must be positive");
  const ContactObserver<double> observer(s.model);
  EXPECT_TRUE(std::isnan(observer.threshold(9)) && std::isnan(observer.level(-1)));
  EXPECT_FALSE(observer.learned(9));
}

}  // namespace
}  // namespace rivid
