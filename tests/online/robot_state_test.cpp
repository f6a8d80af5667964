#include "rivid/online/robot_state.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "support/complaint.hpp"
#include "support/normal.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr double f_m = 500.0;
constexpr Index joints = 6;

struct Scene {
  Robot robot;
  Vector chi_st;
  OnlineModel model;
  Inertial body = inertial_from_com(2.0, {0.03, -0.05, 0.1}, Eigen::Vector3d(0.02, 0.03, 0.025).asDiagonal());
  std::mt19937_64 random{3};

  Scene() {
    robot = test::random_robot(joints, random);
    robot.chain.gravity = {0.0, 0.0, -9.81};
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      robot.chain.links[j].type = robot.joints[j].type = JointType::revolute;
      robot.joints[j].friction = Friction::symmetric;
    }
    chi_st = robot.chi_st();
    model = test::known_model(robot, chi_st, 0.1);
    model.C_chi *= 0.1;
  }
  [[nodiscard]] RobotState<double> state(double learn) const {
    RobotStateOptions options;
    options.payload.rows = {.f_m = f_m, .stride = 12, .torque_held = false};
    options.learn = learn;
    return {model, DynamicModel(robot, chi_st), options};
  }
  // Standard parameters with dry friction times a factor.
  [[nodiscard]] Vector worn(double factor) const {
    Vector out = chi_st;
    const std::vector<StandardParameter> all = robot.standard_parameters();
    for (std::size_t i = 0; i < all.size(); ++i) {
      out[static_cast<Index>(i)] *= role(all[i].kind) == Role::dry ? factor : 1.0;
    }
    return out;
  }
  // Noisy ticks of a motion: (t, q, τ) to take(k, t, q, τ), which may spoil them.
  template <typename Take>
  void run(const Motion& motion, const Vector& truth, double noise, const Take& take) {
    const Matrix tau = test::torques(DynamicModel(robot, truth), motion).transpose();
    test::Normal normal;
    for (Index k = 0; k < motion.samples(); ++k) {
      Vector q = motion.q.row(k).transpose();
      Vector torque = tau.col(k);
      for (Index j = 0; j < joints; ++j) {
        q[j] += 2e-6 * normal(random);
        torque[j] += noise * normal(random);
      }
      take(k, static_cast<double>(k) / f_m, q, torque);
    }
  }
};

TEST(RobotState, FindsAPayloadThoughTicksAreLostRepeatedLateAndWrong) {
  Scene s;
  RobotState<double> state = s.state(40.0);
  const Motion motion = test::Wandering(joints, 3, 0.5, 1.2).at(test::ticks(30.0, f_m));
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Vector before_q;
  Vector before_tau;
  s.run(motion, test::loaded(s.robot, s.chi_st, s.body), 0.3,
        [&](Index /*k*/, double t, Vector q, Vector tau) {
          const double x = unit(s.random);
          const Vector good_q = q;
          const Vector good_tau = tau;
          if (x < 0.01 && before_q.size() > 0) {
            q = before_q;
            tau = before_tau;
          } else if (x < 0.02) {
            q[3] += 0.05;
          } else if (x < 0.03) {
            tau[1] -= 80.0;
          } else if (x < 0.04) {
            t += 0.6 / f_m;
          }
          if (x < 0.99) {
            state.update(t, q, tau);
          }
          before_q = good_q;
          before_tau = good_tau;
        });
  EXPECT_GE(state.counts().lost, 300);
  EXPECT_GE(state.counts().glitches, 200);
  EXPECT_TRUE(state.payload().good);
  EXPECT_LE(std::abs(state.payload().mass - 2.0), 2.0 * state.payload().mass_half_width());
  EXPECT_LE(state.payload().mass_half_width(), 0.1);
}

TEST(RobotState, BringsWhatItLearnsIntoTheFeedForwardWithoutAJump) {
  Scene s;
  RobotState<double> state = s.state(1.0);
  const Vector loaded = test::loaded(s.robot, s.worn(0.8), s.body);
  const DynamicModel truth(s.robot, loaded);
  const Motion motion = test::Wandering(joints, 3, 0.5, 1.2).at(test::ticks(60.0, f_m));
  InverseDynamics known{DynamicModel(s.robot, s.chi_st)};
  Vector before = Vector::Zero(joints);
  double largest = 0.0;
  double error = 0.0;
  double size = 0.0;
  s.run(motion, loaded, 0.3, [&](Index k, double t, const Vector& q, const Vector& tau) {
    state.update(t, q, tau);
    const Vector at = motion.q.row(0).transpose();
    const Vector rest = Vector::Zero(joints);
    if (k < 25000) {  // the same pose, so that nothing but what is learned moves it
      Vector plain(joints);
      known.torque(at, rest, rest, plain);
      const Vector more = state.feedforward(at, rest, rest) - plain;
      largest = std::max(largest, (more - before).cwiseAbs().maxCoeff());
      before = more;
      return;
    }
    const Vector wanted = inverse_dynamics(truth, motion.q.row(k).transpose(), motion.qd.row(k).transpose(),
                                           motion.qdd.row(k).transpose());
    const Vector found = state.feedforward(motion.q.row(k).transpose(), motion.qd.row(k).transpose(),
                                           motion.qdd.row(k).transpose());
    Vector plain(joints);
    known.torque(motion.q.row(k).transpose(), motion.qd.row(k).transpose(), motion.qdd.row(k).transpose(),
                 plain);
    error += (found - wanted).squaredNorm();
    size += (plain - wanted).squaredNorm();
  });
  EXPECT_GT(before.cwiseAbs().maxCoeff(), 1.0);
  EXPECT_LE(largest, 50.0 * 0.1 / f_m * 1.0001);
  EXPECT_LE(std::sqrt(error / size), 0.15) << "of what the model alone leaves";
}

// Half a second of forces that no gripper makes, every four seconds, on an arm whose friction fades by a
// fifth.
TEST(RobotState, PushesAreContactsAndNoPayload) {
  Scene s;
  RobotState<double> state = s.state(30.0);
  const Motion motion = test::Wandering(joints, 3, 0.5, 1.2).at(test::ticks(90.0, f_m));
  const Matrix worn = test::torques(DynamicModel(s.robot, s.worn(0.8)), motion).transpose();
  const Matrix fresh = test::torques(DynamicModel(s.robot, s.chi_st), motion).transpose();
  int pushes = 0;
  int felt = 0;
  int silent = 0;
  bool seen = false;
  s.run(motion, s.chi_st, 0.3, [&](Index k, double t, const Vector& q, Vector tau) {
    tau += (worn.col(k) - fresh.col(k)) * t / 90.0;
    const double phase = std::fmod(t, 4.0);
    const bool push = t > 32.0 && phase < 0.5;
    if (push) {
      tau -= Vector::LinSpaced(joints, 1.0, 6.0) * (pushes % 2 == 0 ? 1.0 : -1.0);
    }
    state.update(t, q, tau);
    if (t > 32.0) {
      seen = seen || state.contact();
      if (phase > 1.5 && state.contact()) {
        ++silent;
      }
      if (k % 2000 == 1999) {
        ++pushes;
        felt += seen ? 1 : 0;
        seen = false;
      }
    }
  });
  EXPECT_GE(pushes, 14);
  EXPECT_EQ(felt, pushes);
  EXPECT_EQ(silent, 0) << "ticks of a contact that is none";
  EXPECT_EQ(state.payload_changes(), 0);
  EXPECT_TRUE(state.payload().good);
  EXPECT_LE(state.payload().mass, 2.0 * state.payload().mass_half_width());
}

// The weight of what the gripper holds is no contact, from the moment that this is said.
TEST(RobotState, BelievesTheGripper) {
  Scene s;
  RobotState<double> state = s.state(30.0);
  const Motion motion = test::Wandering(joints, 3, 0.5, 1.2).at(test::ticks(60.0, f_m));
  const Matrix loaded =
      test::torques(DynamicModel(s.robot, test::loaded(s.robot, s.chi_st, s.body)), motion).transpose();
  const Matrix empty = test::torques(DynamicModel(s.robot, s.chi_st), motion).transpose();
  int touched = 0;
  s.run(motion, s.chi_st, 0.3, [&](Index k, double t, const Vector& q, const Vector& tau) {
    const bool holds = std::fmod(t, 10.0) > 5.0 && t > 30.0;
    if (t > 30.0 && k % 2500 == 1) {
      state.gripper(!holds);
    }
    state.update(t, q, holds ? Vector(tau + loaded.col(k) - empty.col(k)) : tau);
    touched += state.contact() || state.collision() ? 1 : 0;
    if (t > 30.0 && k % 2500 == 2400) {
      EXPECT_TRUE(state.payload().good);
      EXPECT_NEAR(state.payload().mass, holds ? 2.0 : 0.0, 2.0 * state.payload().mass_half_width());
    }
  });
  EXPECT_EQ(state.payload_changes(), 6);
  EXPECT_EQ(touched, 0);
}

TEST(RobotState, SaysWhatIsWrong) {
  const Scene s;
  const auto complaint = [&](const RobotStateOptions& options) {
    return test::complaint_of([&] { RobotState<double>(s.model, DynamicModel(s.robot, s.chi_st), options); });
  };
  RobotStateOptions options;
  options.learn = -1.0;
  EXPECT_EQ(complaint(options), "RobotState: learn is -1 s, must not be negative");
  options = {};
  options.feedforward_rate = Vector::Ones(2);
  EXPECT_EQ(complaint(options), "RobotState: feedforward_rate must have 6 positive values, one a joint");
}

}  // namespace
}  // namespace rivid
