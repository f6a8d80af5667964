// A million ticks of each estimator of a control loop, of a robot with seven joints, without one allocation.

#include <gtest/gtest.h>

#include "rivid/online/contact_observer.hpp"
#include "rivid/online/friction_monitor.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/recursive_identifier.hpp"
#include "rivid/online/robot_state.hpp"
#include "support/mallocs.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr Index ticks = 1'000'000;
constexpr Index joints = 7;
constexpr double f_m = 1000.0;

// Twenty seconds of motion, the second half with a payload, over and over: pick-ups, releases and motion that
// jumps are among the ticks.
struct Loop {
  Robot robot;
  OnlineModel model;
  Matrix q, qd, tau;  // a column a tick

  Loop() {
    std::mt19937_64 random(2);
    robot = test::random_robot(joints, random);
    for (std::size_t j = 0; j < joints; ++j) {
      robot.chain.links[j].type = robot.joints[j].type = JointType::revolute;
      robot.joints[j].friction = j % 2 == 0 ? Friction::symmetric : Friction::load;
    }
    const Vector chi_st = test::distinct_friction(robot);
    model = test::known_model(robot, chi_st, 0.2);
    const Motion motion = test::Wandering(joints, 3).at(test::ticks(20.0, f_m));
    const Inertial body =
        inertial_from_com(3.0, {0.05, 0.0, 0.1}, Eigen::Vector3d(0.02, 0.03, 0.02).asDiagonal());
    q = motion.q.transpose();
    qd = motion.qd.transpose();
    tau = test::torques(DynamicModel(robot, chi_st), motion).transpose();
    const Matrix loaded =
        test::torques(DynamicModel(robot, test::loaded(robot, chi_st, body)), motion).transpose();
    tau.rightCols(tau.cols() / 2) = loaded.rightCols(tau.cols() / 2);
    std::normal_distribution<double> noise(0.0, 0.3);
    for (double& x : tau.reshaped()) {
      x += noise(random);
    }
  }
};

const Loop& loop() {
  static const Loop out;
  return out;
}

template <typename Tick>
long allocations_of_a_million(const Tick& tick) {
  const Index period = loop().q.cols();
  return test::allocations_of([&] {
    for (Index k = 0; k < ticks; ++k) {
      tick(k, k % period);
    }
  });
}

TEST(MillionTicks, OfThePayloadEstimatorAllocateNothing) {
  const Loop& of = loop();
  PayloadEstimator<double> estimator(of.model, {.rows = {.f_m = f_m}});
  Index changes = 0;
  EXPECT_EQ(allocations_of_a_million([&](Index /*k*/, Index i) {
              changes += estimator.update(of.q.col(i), of.tau.col(i)) ? 1 : 0;
            }),
            0);
  EXPECT_GE(changes, 50) << "pick-ups and releases are among the ticks";
}

TEST(MillionTicks, OfTheRobotStateAllocateNothing) {
  const Loop& of = loop();
  RobotStateOptions options;
  options.payload.rows.f_m = f_m;
  RobotState<double> state(of.model, DynamicModel(of.robot, of.model.base, of.model.chi), options);
  Vector none = Vector::Constant(joints, std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(allocations_of_a_million([&](Index k, Index i) {
              if (k % 101 != 0) {
                const Eigen::Map<const Vector> at(k % 103 == 0 ? none.data() : &of.q(0, i), joints);
                state.update(static_cast<double>(k) / f_m, at, of.tau.col(i));
              }
              static_cast<void>(state.feedforward(of.q.col(i), of.qd.col(i), of.qd.col(i)));
              if (i == of.q.cols() / 2) {
                state.gripper(k % 3 == 0);
              }
            }),
            0);
  EXPECT_GE(state.payload_changes(), 50);
  EXPECT_GE(state.counts().lost, ticks / 101);
}

TEST(MillionTicks, OfTheContactObserverAllocateNothing) {
  const Loop& of = loop();
  using Mode = ContactObserver<double>::Mode;
  ContactObserver<double> observer(DynamicModel(of.robot, of.model.base, of.model.chi), {.f_m = f_m});
  Index contacts = 0;
  EXPECT_EQ(allocations_of_a_million([&](Index k, Index i) {
              if (i == 0) {  // the motion jumps
                observer.reset();
              }
              const bool learns = k < 5 * of.q.cols() && i < of.q.cols() / 2;
              const Mode mode = learns ? Mode::learn : Mode::observe;
              if (observer.update(of.q.col(i), of.qd.col(i), of.tau.col(i), mode)) {
                contacts += observer.force(observer.link(), Eigen::Vector3d::Zero()).allFinite() ? 1 : 0;
              }
            }),
            0);
  EXPECT_GE(contacts, 50) << "the payload is a contact for who does not know it";
}

TEST(MillionTicks, OfTheFrictionMonitorAllocateNothing) {
  const Loop& of = loop();
  FrictionMonitor<double> monitor(of.model, {.rows = {.f_m = f_m}});
  EXPECT_EQ(allocations_of_a_million([&](Index /*k*/, Index i) {
              monitor.update(of.q.col(i), of.tau.col(i));
              static_cast<void>(monitor.identify_anew(i % joints));
            }),
            0);
  EXPECT_TRUE(monitor.chi().allFinite());
}

TEST(MillionTicks, OfTheRecursiveIdentifierAllocateNothing) {
  const Loop& of = loop();
  RecursiveIdentifier<double> identifier(of.model, {.rows = {.f_m = f_m}, .forgetting = 20.0});
  EXPECT_EQ(
      allocations_of_a_million([&](Index /*k*/, Index i) { identifier.update(of.q.col(i), of.tau.col(i)); }),
      0);
  EXPECT_TRUE(identifier.chi().allFinite());
  EXPECT_GE(identifier.rows(), ticks / 100);
}

}  // namespace
}  // namespace rivid
