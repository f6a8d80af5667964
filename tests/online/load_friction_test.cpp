// Estimators of a control loop on robots whose friction follows the load.

#include <gtest/gtest.h>

#include <vector>

#include "rivid/identify/identification.hpp"
#include "rivid/online/contact_observer.hpp"
#include "rivid/online/friction_monitor.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/recursive_identifier.hpp"
#include "support/normal.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

struct Scene {
  Robot robot;
  Vector chi_st;
  OnlineModel model;
};

// A random arm of revolute joints, with Fl of 0.1 or more.
Scene arm(int joints, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Scene out{test::random_robot(joints, random), {}, {}};
  out.robot.chain.gravity = {0.0, 0.0, -9.81};
  for (std::size_t j = 0; j < out.robot.joints.size(); ++j) {
    out.robot.chain.links[j].type = out.robot.joints[j].type = JointType::revolute;
    out.robot.joints[j].friction = Friction::load;
  }
  out.chi_st = test::distinct_friction(out.robot);
  out.model = test::known_model(out.robot, out.chi_st, 0.1);
  return out;
}

struct Ticks {
  Matrix q, tau;  // a column a tick
};

Ticks ticks(const Scene& scene, const Vector& chi_st, double f_m, double seconds, double noise) {
  const auto n = static_cast<int>(scene.robot.size());
  const Motion motion = test::Wandering(n, 5, 0.5, 1.2).at(test::ticks(seconds, f_m));
  Ticks out{motion.q.transpose(), test::torques(DynamicModel(scene.robot, chi_st), motion).transpose()};
  std::mt19937_64 random(6);
  test::Normal normal(0.0, noise);
  for (double& x : out.tau.reshaped()) {
    x += normal(random);
  }
  return out;
}

// The body on the last link that the tests hang there.
Inertial brick() {
  return inertial_from_com(6.0, {0.03, -0.05, 0.1}, Eigen::Vector3d(0.02, 0.03, 0.025).asDiagonal());
}

// Values of one kind of friction, by joint, times factor.
Vector scaled(const Scene& scene, ParameterKind kind, double factor) {
  Vector out = scene.chi_st;
  const std::vector<StandardParameter> all = scene.robot.standard_parameters();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].kind == kind) {
      out[static_cast<Index>(i)] *= factor;
    }
  }
  return out;
}

TEST(LoadFrictionOnline, IsTheBatchIdentificationThatTheRowsAreLinearAt) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    constexpr double f_m = 200.0;
    Scene scene = arm(4, seed);
    const Ticks run = ticks(scene, scene.chi_st, f_m, 40.0, 0.2);
    Log log;
    log.source = "wandering";
    log.f_m = f_m;
    log.t = test::ticks(40.0, f_m);
    log.q = run.q.transpose();
    log.tau = run.tau.transpose();
    Estimation estimation;
    estimation.method = Wls{};
    estimation.signal.decimation = {8};
    estimation.signal.torque_held = false;
    const Identification batch = identify(scene.robot, log, estimation);
    ASSERT_TRUE(batch.chi.allFinite());
    scene.model.chi = batch.chi;
    RecursiveIdentifierOptions options;
    options.rows = {.f_m = f_m, .stride = 8, .torque_held = false, .velocity_span = 1};
    options.rows.velocity_threshold = Vector(4);
    for (Index j = 0; j < 4; ++j) {
      const JointFit& fit = batch.fit.joints[static_cast<std::size_t>(j)];
      options.rows.velocity_threshold[j] = fit.velocity_threshold;
      scene.model.sigma_rho[j] = fit.sigma_rho;
    }
    options.prior = false;
    RecursiveIdentifier<double> identifier(scene.model, options);
    for (Index k = 0; k < run.q.cols(); ++k) {
      identifier.update(run.q.col(k), run.tau.col(k));
    }
    identifier.finish();
    EXPECT_NEAR(static_cast<double>(identifier.rows()), static_cast<double>(batch.fit.rows), 4.0);
    // The batch has one more row of each joint, at the end of the log, and another width of the kink: a part
    // of a deviation.
    const Vector off = (identifier.chi() - batch.chi).cwiseQuotient(batch.C_chi.diagonal().cwiseSqrt());
    EXPECT_LE(off.norm() / std::sqrt(static_cast<double>(off.size())), 0.2) << off.transpose();
  }
}

TEST(LoadFrictionOnline, FeelsThePayloadThatIsEstimated) {
  constexpr double f_m = 500.0;
  Scene scene = arm(6, 3);
  scene.model.C_chi *= 0.01;
  const PayloadEstimatorOptions options{.rows = {.f_m = f_m, .stride = 12, .torque_held = false},
                                        .friction_change = 0.0};
  const Ticks run = ticks(scene, test::loaded(scene.robot, scene.chi_st, brick()), f_m, 20.0, 0.1);
  PayloadEstimator<double> estimator(scene.model, options);
  for (Index k = 0; k < run.q.cols(); ++k) {
    estimator.update(run.q.col(k), run.tau.col(k));
  }
  estimator.finish();
  const auto& found = estimator.payload();
  EXPECT_LE(found.mass_half_width(), 0.05);
  EXPECT_LE(std::abs(found.mass - 6.0), 2.0 * found.mass_half_width());
  for (Index i = 0; i < 3; ++i) {
    EXPECT_LE(std::abs(found.com[i] - Eigen::Vector3d(0.03, -0.05, 0.1)[i]), 4.0 * found.com_sigma[i]);
  }
  // Errors of the rows are noise: no load is left in them.
  for (Index j = 0; j < 6; ++j) {
    EXPECT_LE(estimator.row_sigma(j, 1.0), 0.1) << "joint " << j;
  }
}

TEST(LoadFrictionOnline, MonitorFollowsItsDriftUnderAPayload) {
  constexpr double f_m = 200.0;
  const Scene scene = arm(4, 4);
  const Vector worn = test::loaded(scene.robot, scaled(scene, ParameterKind::Fl, 1.3), brick());
  const Ticks run = ticks(scene, worn, f_m, 120.0, 0.2);
  FrictionMonitor<double> monitor(scene.model, {.rows = {.f_m = f_m, .stride = 5, .torque_held = false}});
  monitor.set_payload(brick());
  for (Index k = 0; k < run.q.cols(); ++k) {
    monitor.update(run.q.col(k), run.tau.col(k));
  }
  monitor.finish();
  int seen = 0;
  for (std::size_t i = 0; i < monitor.coefficients().size(); ++i) {
    const auto& c = monitor.coefficients()[i];
    if (c.kind == ParameterKind::Fl) {
      const auto at = static_cast<Index>(i);
      EXPECT_LE(std::abs(monitor.value(at) - 1.3 * c.identified),
                4.0 * monitor.sigma(at) + 0.01 * c.identified)
          << c.name();
      ++seen;
    }
  }
  EXPECT_EQ(seen, 4);
}

TEST(LoadFrictionOnline, IsNoContactAndAPushIsThePushItself) {
  constexpr double f_m = 1000.0;
  const Scene scene = arm(6, 5);
  const DynamicModel model(scene.robot, scene.chi_st);
  const Motion motion = test::Wandering(6, 5).at(test::ticks(2.0, f_m));
  const Vector push = Vector::LinSpaced(6, 3.0, 18.0);
  constexpr Index from = 1000;
  constexpr double bandwidth = 40.0;
  Matrix tau(6, motion.samples());
  double largest = 0.0;
  for (Index k = 0; k < motion.samples(); ++k) {
    const Vector q = motion.q.row(k);
    const Vector qd = motion.qd.row(k);
    const Vector external = k > from ? push : Vector(Vector::Zero(6));
    // What the gears carry on this motion, and what the drives have to give for it.
    const Vector carried = mass_matrix(model, q) * Vector(motion.qdd.row(k)) + bias(model, q, qd) - external;
    tau.col(k) = carried + friction_torque(model, qd);
    for (const DryFriction& element : model.dry_friction()) {
      const double load = element.load * std::abs(carried[element.joint()]);
      tau(element.joint(), k) += load * sign(qd[element.joint()]);
      largest = std::max(largest, load);
    }
  }
  ContactObserver<double> observer(
      model, {.f_m = f_m, .bandwidth = bandwidth, .smoothing_speed = Vector::Constant(6, 1e-6)});
  double silent = 0.0;
  for (Index k = 0; k < motion.samples(); ++k) {
    const Vector held = 0.5 * (tau.col(k) + tau.col(std::max<Index>(k - 1, 0)));
    observer.update(motion.q.row(k).transpose(), motion.qd.row(k).transpose(), held);
    const double part = 1.0 - std::exp(-bandwidth * static_cast<double>(std::max<Index>(k - from, 0)) / f_m);
    silent = std::max(silent, (observer.residual() - part * push).cwiseAbs().maxCoeff());
  }
  // At a reversal a tick has half of each direction: of its friction this part passes the low-pass.
  EXPECT_LE(silent, 3.0 * bandwidth / f_m * largest);
  EXPECT_GE(largest, 5.0);
}

}  // namespace
}  // namespace rivid
