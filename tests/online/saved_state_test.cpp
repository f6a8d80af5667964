// States of all estimators: one that was saved and put back goes on bit by bit, whatever was called before,
// and one of another arm, rate, flange or option is refused with words.

#include "rivid/online/saved_state.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "rivid/online/contact_observer.hpp"
#include "rivid/online/friction_monitor.hpp"
#include "rivid/online/payload_estimator.hpp"
#include "rivid/online/recursive_identifier.hpp"
#include "rivid/online/robot_state.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr double f_m = 200.0;
constexpr Index joints = 4;

// An arm of which a joint has friction by load, in motion with a body that its model does not have.
struct Scene {
  Robot robot;
  Vector chi_st;
  OnlineModel model;
  Inertial body = inertial_from_com(2.0, {0.03, -0.05, 0.1}, Eigen::Vector3d(0.02, 0.03, 0.025).asDiagonal());
  Matrix q, qd, tau;  // a column a tick

  Scene() {
    std::mt19937_64 random(11);
    robot = test::random_robot(joints, random);
    robot.chain.gravity = {0.0, 0.0, -9.81};
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      robot.chain.links[j].type = robot.joints[j].type = JointType::revolute;
      robot.joints[j].friction = j == 1 ? Friction::load : Friction::symmetric;
    }
    chi_st = test::distinct_friction(robot);
    model = test::known_model(robot, chi_st, 0.1);
    const Motion motion = test::Wandering(joints, 5, 0.5, 1.2).at(test::ticks(20.0, f_m));
    q = motion.q.transpose();
    qd = motion.qd.transpose();
    tau = test::torques(DynamicModel(robot, test::loaded(robot, chi_st, body)), motion).transpose();
    std::normal_distribution<double> noise(0.0, 0.05);
    for (double& x : tau.reshaped()) {
      x += noise(random);
    }
  }
};

template <typename Estimator>
std::vector<std::byte> state_of(const Estimator& estimator) {
  std::vector<std::byte> out(state_size(estimator));
  EXPECT_TRUE(save_state(estimator, out));
  return out;
}

// @param fresh     an estimator at its begin
// @param set       calls all that sets something in it
// @param tick      (estimator, k)
// @param outputs   of it, (…)
template <typename Estimator, typename Set, typename Tick, typename Outputs>
void expect_goes_on_bit_by_bit(const Estimator& fresh, const Set& set, const Tick& tick,
                               const Outputs& outputs) {
  constexpr Index half = 2000;
  constexpr Index all = 4000;
  Estimator estimator = fresh;
  Estimator twin = fresh;
  for (Index k = 0; k < half; ++k) {
    tick(estimator, k);
  }
  set(estimator);
  tick(estimator, half);
  const Restored restored = restore_state(twin, state_of(estimator));
  ASSERT_TRUE(restored) << restored.refusal;
  Vector different = Vector::Zero(outputs(estimator).size());
  for (Index k = half + 1; k < all; ++k) {
    tick(estimator, k);
    tick(twin, k);
    const Vector a = outputs(estimator);
    const Vector b = outputs(twin);
    for (Index i = 0; i < a.size(); ++i) {
      different[i] += a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i])) ? 0.0 : 1.0;
    }
  }
  EXPECT_EQ(different, Vector::Zero(different.size()));
}

template <typename Estimator, typename Count, typename... Of>
Vector values_of(Estimator& estimator, Count count, const Of&... of) {
  std::vector<double> out;
  for (Index i = 0; i < count; ++i) {
    (out.push_back(static_cast<double>(std::invoke(of, estimator, i))), ...);
  }
  return Eigen::Map<const Vector>(out.data(), std::ssize(out));
}

TEST(SavedState, GoesOnBitByBitAfterAnythingThatWasCalled) {
  const Scene s;
  {
    SCOPED_TRACE("ContactObserver");
    using Observer = ContactObserver<double>;
    expect_goes_on_bit_by_bit(
        Observer(DynamicModel(s.robot, s.chi_st), {.f_m = f_m}), [&](Observer& o) { o.set_payload(s.body); },
        [&](Observer& o, Index k) {
          o.update(s.q.col(k), s.qd.col(k), s.tau.col(k),
                   k % 400 < 300 ? Observer::Mode::learn : Observer::Mode::observe);
        },
        [](Observer& o) {
          return values_of(
              o, joints, [](Observer& x, Index j) { return x.residual()[j]; },
              [](Observer& x, Index j) { return x.relative()[j]; }, &Observer::threshold, &Observer::level,
              [](Observer& x, Index j) { return x.force(j, Eigen::Vector3d(0.1, 0.2, 0.3)).sum(); },
              [](Observer& x, Index /*j*/) { return x.link(); });
        });
  }
  {
    SCOPED_TRACE("FrictionMonitor");
    using Monitor = FrictionMonitor<double>;
    const Monitor fresh(s.model, {.rows = {.f_m = f_m}, .regressor = true});
    const Index count = std::ssize(fresh.coefficients());
    expect_goes_on_bit_by_bit(
        fresh, [&](Monitor& m) { m.set_payload(s.body); },
        [&](Monitor& m, Index k) {
          m.update(s.q.col(k), s.tau.col(k), Vector::Constant(joints, 1e-3 * static_cast<double>(k)));
        },
        [&](Monitor& m) {
          return values_of(m, count, &Monitor::value, &Monitor::sigma, &Monitor::drift,
                           &Monitor::torque_error,
                           [](Monitor& x, Index i) { return i < x.chi().size() ? x.chi()[i] : 0.0; });
        });
  }
  {
    SCOPED_TRACE("PayloadEstimator");
    using Estimator = PayloadEstimator<double>;
    expect_goes_on_bit_by_bit(
        Estimator(s.model, {.rows = {.f_m = f_m}}), [](Estimator& e) { e.pause(); },
        [&](Estimator& e, Index k) { e.update(s.q.col(k), s.tau.col(k)); },
        [](Estimator& e) {
          return values_of(
              e, joints, [](Estimator& x, Index j) { return x.inertial()[6 + j]; },
              [](Estimator& x, Index j) { return x.row_sigma(j, 0.1) + x.row_sigma(j, 0.5); },
              [](Estimator& x, Index j) { return x.friction()[static_cast<std::size_t>(j)].value; },
              [](Estimator& x, Index j) {
                const auto& p = x.payload();
                return j < 3 ? p.com[j] + p.com_sigma[j] + p.inertia(j, j) + p.inertia_sigma[j]
                             : p.mass + p.mass_sigma + p.held + 2 * p.body + 4 * p.good;
              },
              [](Estimator& x, Index j) {
                const auto& c = x.change();
                return j == 0 ? x.suspicion()
                              : static_cast<double>(c.tick) + c.mass_before + c.sigma_before +
                                    static_cast<double>(c.kind);
              });
        });
  }
  using State = RobotState<double>;
  RobotStateOptions options;
  options.payload.rows.f_m = f_m;
  options.learn = 8.0;
  const std::vector<std::function<void(State&)>> calls = {
      [](State& /*x*/) {}, [](State& x) { x.payload_changed(); },
      [](State& x) { x.payload_known(2.0, {0.0, 0.01, 0.1}, 0.02, 0.003); },
      [](State& x) { x.gripper(false); },
      [](State& x) {
        x.gripper(false);
        x.gripper(true);
      }};
  for (const auto& call : calls) {
    SCOPED_TRACE("RobotState, call " + std::to_string(&call - calls.data()));
    expect_goes_on_bit_by_bit(
        State(s.model, DynamicModel(s.robot, s.chi_st), options), call,
        [&](State& x, Index k) {
          const Index lost = k % 97 == 5 ? 1 : 0;
          x.update(static_cast<double>(k) / f_m, s.q.col(k), s.tau.col(k - lost));
          static_cast<void>(x.feedforward(s.q.col(k), s.qd.col(k), s.q.col(k)));
        },
        [](State& x) {
          const Vector none = Vector::Zero(joints);
          State copy = x;  // feedforward() goes on with each call
          const Vector torque = copy.feedforward(none, none, none);
          return values_of(
              x, joints, [&](State& /*of*/, Index j) { return torque[j]; },
              [](State& of, Index j) {
                return of.observer().relative()[j] + of.observer().collision_relative()[j];
              },
              [](State& of, Index j) { return of.estimator().inertial()[6 + j]; },
              [](State& of, Index /*j*/) {
                return static_cast<double>(of.payload_changes() + 100 * (of.contact() ? 1 : 0) +
                                           of.counts().lost);
              });
        });
  }
  {
    SCOPED_TRACE("RecursiveIdentifier");
    using Identifier = RecursiveIdentifier<double>;
    const Identifier fresh(s.model, {.rows = {.f_m = f_m}, .forgetting = 20.0});
    const std::vector<double> w(fresh.columns().of_joint(2).size(), 0.3);
    expect_goes_on_bit_by_bit(
        fresh,
        [&](Identifier& r) {
          r.add_row(2, w, 1.0, 0.5);
          r.merge(fresh);
        },
        [&](Identifier& r, Index k) { r.update(s.q.col(k), s.tau.col(k)); },
        [](Identifier& r) {
          return values_of(
              r, r.size(), [](Identifier& x, Index i) { return x.chi()[i]; }, &Identifier::sigma,
              [](Identifier& x, Index i) {
                return i < joints ? x.consistency(i) : static_cast<double>(x.rows());
              });
        });
  }
}

template <typename Estimator>
void expect_refused(const Estimator& theirs, Estimator own, const char* words) {
  const std::vector<std::byte> before = state_of(own);
  const Restored restored = restore_state(own, state_of(theirs));
  EXPECT_FALSE(restored);
  EXPECT_STREQ(restored.refusal, (std::string("restore_state: the state is that of ") + words).c_str());
  EXPECT_EQ(state_of(own), before);
}

TEST(SavedState, OfAnotherArmRateFlangeOrOptionIsRefusedWithWords) {
  const Scene s;
  const char* const arm = "another arm: its model or covariance differs";
  const char* const rate = "another rate: f_m differs";
  const char* const options = "an estimator with other options";

  const DynamicModel dynamics(s.robot, s.chi_st);
  const ContactObserver<double> observer(dynamics, {.f_m = f_m});
  Vector heavier = s.chi_st;
  heavier[9] += 1e-3;
  expect_refused(observer, ContactObserver<double>(DynamicModel(s.robot, heavier), {.f_m = f_m}), arm);
  Robot longer = s.robot;
  longer.chain.links[1].p[0] += 1e-3;
  expect_refused(observer, ContactObserver<double>(DynamicModel(longer, s.chi_st), {.f_m = f_m}), arm);
  expect_refused(observer, ContactObserver<double>(dynamics, {.f_m = 2.0 * f_m}), rate);
  expect_refused(observer, ContactObserver<double>(dynamics, {.f_m = f_m, .bandwidth = 20.0}), options);

  const PayloadEstimatorOptions usual = {.rows = {.f_m = f_m}};
  const PayloadEstimator<double> payload(s.model, usual);
  OnlineModel other = s.model;
  other.C_chi *= 1.01;
  expect_refused(payload, PayloadEstimator<double>(other, usual), arm);
  other = s.model;
  other.robot = longer;
  expect_refused(payload, PayloadEstimator<double>(other, usual), arm);
  // Strides of the same number of ticks.
  PayloadEstimatorOptions changed = usual;
  changed.rows.f_m = f_m + 1.0;
  expect_refused(payload, PayloadEstimator<double>(s.model, changed), rate);
  changed = usual;
  changed.p[2] = 0.1;
  expect_refused(payload, PayloadEstimator<double>(s.model, changed),
                 "another flange: its pose R, p differs");
  changed = usual;
  changed.rows.torque_held = false;
  expect_refused(payload, PayloadEstimator<double>(s.model, changed), options);

  RobotStateOptions together;
  together.payload = usual;
  const RobotState<double> state(s.model, dynamics, together);
  expect_refused(state, RobotState<double>(s.model, DynamicModel(s.robot, heavier), together), arm);
  RobotStateOptions others = together;
  others.payload.rows.f_m = f_m + 1.0;
  expect_refused(state, RobotState<double>(s.model, dynamics, others), rate);
  others = together;
  others.payload.p[2] = 0.1;
  expect_refused(state, RobotState<double>(s.model, dynamics, others),
                 "another flange: its pose R, p differs");
  others = together;
  others.gate.largest_acceleration = 200.0;
  expect_refused(state, RobotState<double>(s.model, dynamics, others), options);

  const FrictionMonitor<double> monitor(s.model, {.rows = {.f_m = f_m}});
  const RecursiveIdentifier<double> identifier(s.model, {.rows = {.f_m = f_m}});
  other = s.model;
  other.chi[0] += 1e-9;
  expect_refused(monitor, FrictionMonitor<double>(other, {.rows = {.f_m = f_m}}), arm);
  expect_refused(monitor, FrictionMonitor<double>(s.model, {.rows = {.f_m = f_m}, .forgetting = 31.0}),
                 options);
  expect_refused(identifier, RecursiveIdentifier<double>(other, {.rows = {.f_m = f_m}}), arm);
  RecursiveIdentifier<double> to = identifier;
  EXPECT_STREQ(restore_state(to, state_of(monitor)).refusal,
               "restore_state: the state is that of another class of estimators or another Scalar");
}

}  // namespace
}  // namespace rivid
