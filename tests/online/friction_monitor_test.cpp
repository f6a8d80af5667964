#include "rivid/online/friction_monitor.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/mallocs.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr double f_m = 200.0;
constexpr Index joints = 4;

struct Scene {
  Robot robot;
  Vector chi_st;
  OnlineModel model;
};

Scene scene_of(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Scene out{test::random_robot(joints, random), {}, {}};
  for (Joint& joint : out.robot.joints) {
    joint.friction = Friction::symmetric;
    joint.Fc = 4.0;
    joint.Fv = 2.0;
  }
  out.chi_st = out.robot.chi_st();
  out.model = test::known_model(out.robot, out.chi_st, 0.2);
  return out;
}

FrictionMonitorOptions options_of() { return {.rows = {.f_m = f_m, .stride = 5, .torque_held = false}}; }

// Calls tick(q, τ, θ) with dry friction of joint 1 times 1 + part(t) and noise.
template <typename Part, typename Tick>
void drive(const Scene& scene, double seconds, const Part& part, const Tick& tick) {
  std::mt19937_64 random(17);
  std::normal_distribution<double> noise(0.0, 0.3);
  InverseDynamics dynamics{DynamicModel(scene.robot, scene.chi_st)};
  const Motion motion = test::Wandering(joints, 5, 0.5, 1.2).at(test::ticks(seconds, f_m));
  const Matrix q = motion.q.transpose();
  const Matrix qd = motion.qd.transpose();
  const Matrix qdd = motion.qdd.transpose();
  Vector tau(joints);
  for (Index k = 0; k < q.cols(); ++k) {
    dynamics.torque(q.col(k), qd.col(k), qdd.col(k), tau);
    tau[1] += scene.robot.joints[1].Fc * part(static_cast<double>(k) / f_m) * sign(qd(1, k));
    for (double& x : tau) {
      x += noise(random);
    }
    tick(q.col(k), tau);
  }
}

Index coefficient(const FrictionMonitor<double>& monitor, const std::string& name) {
  for (std::size_t i = 0; i < monitor.coefficients().size(); ++i) {
    if (monitor.coefficients()[i].name() == name) {
      return static_cast<Index>(i);
    }
  }
  return -1;
}

TEST(FrictionMonitor, FollowsADriftThatLeavesInertiasAlone) {
  const Scene scene = scene_of(3);
  FrictionMonitor<double> monitor(scene.model, options_of());
  const Index Fc2 = coefficient(monitor, "Fc2");
  ASSERT_GE(Fc2, 0);
  constexpr double seconds = 600.0;
  const double Fc = scene.robot.joints[1].Fc;
  double t = 0.0;
  double worst = 0.0;
  drive(
      scene, seconds, [&](double at) { return 0.3 * at / seconds; },
      [&](const auto& q, const Vector& tau) {
        monitor.update(q, tau);
        t += 1.0 / f_m;
        if (t > 60.0) {
          worst = std::max(worst, std::abs(monitor.value(Fc2) / (Fc * (1.0 + 0.3 * t / seconds)) - 1.0));
        }
      });
  EXPECT_LE(worst, 0.05);
  EXPECT_GE(monitor.drift(Fc2), 5.0);
  EXPECT_NEAR(monitor.torque_error(1), 0.3 * Fc, 0.1 * Fc);
  EXPECT_TRUE(monitor.identify_anew(1));
  EXPECT_FALSE(monitor.identify_anew(0));
  monitor.finish();
  const Vector chi = monitor.chi();
  for (Index i = 0; i < chi.size(); ++i) {
    const BaseParameter& p = scene.model.base.parameters[static_cast<std::size_t>(i)];
    if (!is_friction(p.leading.kind)) {
      EXPECT_LE(std::abs(chi[i] - scene.model.chi[i]), 1.96 * std::sqrt(scene.model.C_chi(i, i))) << p.name;
    }
  }
}

TEST(FrictionMonitor, StaysQuietWhileNothingDrifts) {
  const Scene scene = scene_of(4);
  FrictionMonitor<double> monitor(scene.model, options_of());
  drive(
      scene, 120.0, [](double) { return 0.0; },
      [&](const auto& q, const Vector& tau) { monitor.update(q, tau); });
  for (Index j = 0; j < joints; ++j) {
    EXPECT_FALSE(monitor.identify_anew(j));
  }
  for (Index i = 0; i < static_cast<Index>(monitor.coefficients().size()); ++i) {
    EXPECT_LE(std::abs(monitor.drift(i)), 4.0) << monitor.coefficients()[static_cast<std::size_t>(i)].name();
  }
}

TEST(FrictionMonitor, SeparatesWhatFollowsATemperature) {
  const Scene scene = scene_of(5);
  FrictionMonitorOptions options = options_of();
  options.regressor = true;
  FrictionMonitor<double> monitor(scene.model, options);
  // Fc of joint 1 falls by 1 % a degree, the temperature goes up and down by 15.
  double t = 0.0;
  const auto temperature = [](double at) { return 15.0 * std::sin(0.05 * at); };
  drive(
      scene, 300.0, [&](double at) { return -0.01 * temperature(at); },
      [&](const auto& q, const Vector& tau) {
        monitor.update(q, tau, Vector::Constant(joints, temperature(t)));
        t += 1.0 / f_m;
      });
  const Index slope = coefficient(monitor, "Fc2'");
  ASSERT_GE(slope, 0);
  const double Fc = scene.robot.joints[1].Fc;
  EXPECT_NEAR(monitor.value(slope), -0.01 * Fc, 0.002 * Fc);
  EXPECT_NEAR(monitor.value(coefficient(monitor, "Fc2")), Fc, 0.05 * Fc);
}

TEST(FrictionMonitor, KnowsThePayloadThatItIsTold) {
  const Scene scene = scene_of(6);
  const Inertial body = inertial_from_com(3.0, {0.1, 0.0, 0.05}, 0.01 * Eigen::Matrix3d::Identity());
  Scene with = scene;
  with.chi_st = test::loaded(scene.robot, scene.chi_st, body);
  FrictionMonitor<double> given(scene.model, options_of());
  given.set_payload(body);
  drive(
      with, 60.0, [](double) { return 0.0; },
      [&](const auto& q, const Vector& tau) { given.update(q, tau); });
  for (Index j = 0; j < joints; ++j) {
    EXPECT_FALSE(given.identify_anew(j));
  }
}

TEST(FrictionMonitor, NeverAllocatesAndComesBackBitByBit) {
  const Scene scene = scene_of(7);
  FrictionMonitor<double> monitor(scene.model, options_of());
  FrictionMonitor<double> twin = monitor;
  std::vector<std::byte> state(state_size(monitor));
  std::vector<std::pair<Vector, Vector>> ticks;
  drive(
      scene, 20.0, [](double) { return 0.1; },
      [&](const auto& q, const Vector& tau) { ticks.emplace_back(q, tau); });
  const std::size_t half = ticks.size() / 2;
  const long count = test::allocations_of([&] {
    for (std::size_t k = 0; k < ticks.size(); ++k) {
      monitor.update(ticks[k].first, ticks[k].second);
      static_cast<void>(monitor.torque_error(1));
      if (k == half) {
        ASSERT_TRUE(save_state(monitor, state));
      }
    }
  });
  EXPECT_EQ(count, 0);
  ASSERT_TRUE(restore_state(twin, state));
  for (std::size_t k = half + 1; k < ticks.size(); ++k) {
    twin.update(ticks[k].first, ticks[k].second);
  }
  EXPECT_EQ((monitor.chi() - twin.chi()).cwiseAbs().maxCoeff(), 0.0);
}

TEST(FrictionMonitor, SaysWhatIsWrong) {
  Scene scene = scene_of(1);
  FrictionMonitorOptions options = options_of();
  options.limit = Vector::Zero(joints);
  EXPECT_EQ(test::complaint_of([&] { FrictionMonitor<double>(scene.model, options); }),
            "FrictionMonitor: limit must have 4 positive values, one a joint");
  for (Joint& joint : scene.robot.joints) {
    joint.friction = Friction::none;
  }
  const OnlineModel smooth = test::known_model(scene.robot, scene.robot.chi_st(), 0.2);
  EXPECT_EQ(test::complaint_of([&] { FrictionMonitor<double>(smooth, {}); }),
            "FrictionMonitor: the model has no friction");
  OnlineModel short_of = scene_of(1).model;
  short_of.chi.conservativeResize(3);
  EXPECT_TRUE(test::says(test::complaint_of([&] { FrictionMonitor<double>(short_of, {}); }),
                         "chi and C_chi must have"));
}

TEST(FrictionMonitor, HasNoNumberOfWhatIsNone) {
  const Scene scene = scene_of(1);
  const FrictionMonitor<double> monitor(scene.model, options_of());
  const Index count = std::ssize(monitor.coefficients());
  for (const Index i : {Index{-1}, count}) {
    EXPECT_TRUE(std::isnan(monitor.value(i)) && std::isnan(monitor.sigma(i)) && std::isnan(monitor.drift(i)));
  }
  EXPECT_TRUE(std::isnan(monitor.torque_error(joints)));
  EXPECT_FALSE(monitor.identify_anew(-1));
}

}  // namespace
}  // namespace rivid
