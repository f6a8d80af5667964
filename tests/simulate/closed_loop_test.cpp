#include "rivid/simulate/closed_loop.hpp"

#include <gtest/gtest.h>

#include <climits>
#include <cmath>
#include <numbers>

#include "rivid/regressor/batch.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/references.hpp"
#include "support/complaint.hpp"
#include "support/scara_study.hpp"

namespace {

using rivid::BaseParameters;
using rivid::Index;
using rivid::Integrator;
using rivid::Matrix;
using rivid::Outcome;
using rivid::Robot;
using rivid::Simulation;
using rivid::SimulationOptions;
using rivid::Vector;

// A law that ignores the robot: v_τ is a function of time.
class Open final : public rivid::ControlLaw {
 public:
  explicit Open(std::function<double(double)> v) : v_(std::move(v)) {}
  void control(const rivid::ControlInput& input, const Eigen::Ref<const Vector>&, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector>) const override {
    v_tau.setConstant(v_(input.t));
  }

 private:
  std::function<double(double)> v_;
};

// A law that answers with the velocity it is told, on a drive of no gain.
class Told final : public rivid::ControlLaw {
 public:
  void control(const rivid::ControlInput& input, const Eigen::Ref<const Vector>&, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector>) const override {
    v_tau = input.qd;
  }
};

rivid::PointToPointReference rest(Index n, double duration) {
  return rivid::PointToPointReference(
      {.via = Matrix::Zero(2, n), .durations = Vector::Constant(1, duration)});
}

// The case study of [RIV], with its moves S1.
struct Scara : public rivid::test::ScaraStudy {
  static rivid::PointToPointReference s1() { return moves(1.0); }

  [[nodiscard]] Simulation run(const SimulationOptions& options) const {
    return simulate(robot, base, truth, control, J, s1(), options);
  }
};

double farthest(const Simulation& a, const Simulation& b) {
  return (a.motion.q - b.motion.q).cwiseAbs().maxCoeff();
}

SimulationOptions scara_options(Integrator integrator, double rtol) {
  SimulationOptions options{.f_m = 200.0, .samples = 2001};
  options.integrator = integrator;
  options.rtol = rtol;
  options.atol = 1e-2 * rtol;
  return options;
}

// All methods, through every reversal and stick: what they differ by is their tolerance.
TEST(ClosedLoop, AllIntegratorsGiveTheSameMotion) {
  const Scara scara;
  const Simulation exact = scara.run(scara_options(Integrator::dormand_prince, 1e-11));
  ASSERT_EQ(exact.outcome, Outcome::completed);
  ASSERT_GT(exact.effort.mode_changes, 8);
  for (const Integrator integrator :
       {Integrator::adams, Integrator::bdf, Integrator::bogacki_shampine, Integrator::dormand_prince}) {
    double last = 1.0;
    for (const double rtol : {1e-6, 1e-8}) {
      const Simulation found = scara.run(scara_options(integrator, rtol));
      ASSERT_EQ(found.outcome, Outcome::completed) << name(integrator);
      EXPECT_EQ(found.element_changes, exact.element_changes) << name(integrator);
      const double error = farthest(found, exact);
      EXPECT_LT(error, 100 * rtol) << name(integrator);
      EXPECT_LT(error, last) << name(integrator) << ": the error falls with the tolerance";
      last = error;
    }
  }
}

TEST(ClosedLoop, AdamsNeedsFewRightHandSides) {
  const Simulation found = Scara().run(scara_options(Integrator::adams, 1e-6));
  EXPECT_LE(found.effort.right_hand_sides, 2500);
}

// τ = IDM χ on the rows of a simulation, whose friction columns are silent where a joint sticks.
TEST(ClosedLoop, TheMotionObeysTheInverseDynamicModel) {
  const Scara scara;
  const Simulation found = scara.run(scara_options(Integrator::adams, 1e-8));
  const Matrix W = rivid::observation(scara.robot, scara.base, found.motion).dense();
  const Vector tau = W * scara.truth;
  for (Index j = 0; j < 2; ++j) {
    for (Index k = 0; k < found.t.size(); ++k) {
      if (found.motion.qd(k, j) != 0.0) {
        ASSERT_NEAR(tau[j * found.t.size() + k], found.tau(k, j), 1e-9) << "joint " << j << ", sample " << k;
      } else {
        const double held = found.tau(k, j) - tau[j * found.t.size() + k];
        ASSERT_LE(std::abs(held), (j == 0 ? 0.82 : 0.137) * (1 + 1e-9)) << "joint " << j << ", sample " << k;
      }
    }
  }
}

// Of fourth order: half the step leaves no more than a sixteenth of the error.
TEST(ClosedLoop, RungeKuttaWithFixedStepsIsOfFourthOrder) {
  const Scara scara;
  const rivid::DynamicModel model(scara.robot, scara.base, scara.truth);
  const auto run = [&](Integrator integrator, double period) {
    SimulationOptions options{.f_m = 25.0, .samples = 51};
    options.integrator = integrator;
    options.sampling.period = period;
    options.friction = rivid::DryFrictionScheme::smooth;
    options.smooth_velocity = 1.0;
    options.rtol = 1e-12;
    options.atol = 1e-14;
    return simulate(scara.robot, model, Open([](double) { return 2.0; }), rest(2, 2.0), options);
  };
  const Simulation exact = run(Integrator::dormand_prince, 0.02);
  const double coarse = farthest(run(Integrator::rk4, 0.01), exact);
  const double fine = farthest(run(Integrator::rk4, 0.005), exact);
  EXPECT_GT(coarse / fine, 15.0);
}

TEST(ClosedLoop, WithoutFrictionItAgreesWithAnIntegrationOfHighOrder) {
  Scara scara;
  scara.set("Fc1", 0.0);
  scara.set("Fc2", 0.0);
  SimulationOptions options = scara_options(Integrator::adams, 1e-12);
  options.samples = 501;
  const Simulation found = scara.run(options);
  EXPECT_EQ(found.effort.mode_changes, 0);

  // The closed-form SCARA by Gragg's extrapolated midpoint rule, column by column.
  const auto reference = Scara::s1();
  const auto rate = [&](double t, const Eigen::Vector4d& y) {
    Vector q_r(2);
    Vector qd_r(2);
    Vector qdd_r(2);
    reference.at(t, q_r, qd_r, qdd_r);
    const double c = std::cos(y[1]);
    const double s = std::sin(y[1]);
    const double coupling = 0.5 * (0.242 * c - 0.014 * s);
    const double centrifugal = 0.5 * (0.242 * s + 0.014 * c);
    Eigen::Matrix2d M;
    M << 3.44 + 0.062 + 2 * coupling, 0.062 + coupling, 0.062 + coupling, 0.062;
    const Eigen::Vector2d k_v(2 * 1 * scara.J[0], 2 * 10 * scara.J[1]);
    const Eigen::Vector2d tau(0.5 * k_v[0] * (q_r[0] - y[0]) - k_v[0] * y[2],
                              5.0 * k_v[1] * (q_r[1] - y[1]) - k_v[1] * y[3]);
    const Eigen::Vector2d net(tau[0] + centrifugal * y[3] * (2 * y[2] + y[3]) - 0.03 * y[2],
                              tau[1] - centrifugal * y[2] * y[2] - 0.013 * y[3]);
    const Eigen::Vector2d qdd = M.ldlt().solve(net);
    return Eigen::Vector4d(y[2], y[3], qdd[0], qdd[1]);
  };
  Eigen::Vector4d y = Eigen::Vector4d::Zero();
  double worst = 0.0;
  for (Index k = 0; k + 1 < found.t.size(); ++k) {
    worst = std::max(worst, (y.head(2) - found.motion.q.row(k).transpose()).cwiseAbs().maxCoeff());
    constexpr int levels = 6;
    Eigen::Vector4d table[levels];
    for (int i = 0; i < levels; ++i) {
      const int steps = 2 * (i + 1);
      const double h = 0.005 / steps;
      const double t = 0.005 * static_cast<double>(k);
      Eigen::Vector4d before = y;
      Eigen::Vector4d now = y + h * rate(t, y);
      for (int m = 1; m < steps; ++m) {
        const Eigen::Vector4d next = before + 2 * h * rate(t + m * h, now);
        before = now;
        now = next;
      }
      table[i] = 0.5 * (now + before + h * rate(t + 0.005, now));
      for (int j = i - 1; j >= 0; --j) {
        const double ratio = std::pow(static_cast<double>(i + 1) / (j + 1), 2);
        table[j] = table[j + 1] + (table[j + 1] - table[j]) / (ratio - 1);
      }
    }
    y = table[0];
  }
  EXPECT_LT(worst, 1e-9);
}

// A carriage that is pushed: it starts where the force exceeds Fc, and slides to a stop where it ends.
TEST(ClosedLoop, BreakawayAndStopAreThoseOfTheClosedForm) {
  const Robot robot = rivid::test::slider(rivid::Friction::symmetric);
  const BaseParameters base = rivid::base_parameters(robot);
  const Eigen::Vector4d chi(2.0, 0.0, 3.0, 0.0);  // M Fv Fc off
  const rivid::DynamicModel model(robot, base, chi);
  for (const Integrator integrator : {Integrator::adams, Integrator::dormand_prince}) {
    SimulationOptions options{.f_m = 100.0};
    options.integrator = integrator;
    options.rtol = 1e-10;
    options.atol = 1e-12;
    // 4 t: breaks away at t = 0.75; then M v̇ = 4 t − 3.
    const Simulation pushed =
        simulate(robot, model, Open([](double t) { return 4.0 * t; }), rest(1, 2.0), options);
    ASSERT_EQ(pushed.outcome, Outcome::completed);
    for (Index k = 0; k < pushed.t.size(); ++k) {
      const double s = std::max(0.0, pushed.t[k] - 0.75);
      ASSERT_NEAR(pushed.motion.qd(k, 0), s * s, 1e-8) << "t = " << pushed.t[k];
      ASSERT_NEAR(pushed.motion.q(k, 0), s * s * s / 3, 1e-8) << "t = " << pushed.t[k];
    }
    EXPECT_EQ(pushed.effort.mode_changes, 1);
    // From 3 m/s without a force: −1.5 m/s², at rest after 2 s, and ever after.
    options.qd_0 = Vector::Constant(1, 3.0);
    const Simulation stopped =
        simulate(robot, model, Open([](double) { return 0.0; }), rest(1, 4.0), options);
    EXPECT_NEAR(stopped.motion.q(stopped.t.size() - 1, 0), 3.0, 1e-9);
    EXPECT_EQ(stopped.motion.qd(stopped.t.size() - 1, 0), 0.0);
    EXPECT_EQ(stopped.effort.mode_changes, 1);
  }
}

// Asymmetric friction and an offset: released in one direction sooner than in the other.
TEST(ClosedLoop, AsymmetricFrictionHoldsDifferentlyBothWays) {
  const Robot robot = rivid::test::slider(rivid::Friction::asymmetric);
  const BaseParameters base = rivid::base_parameters(robot);
  ASSERT_EQ(base.parameters[1].name, "Fv+1");
  Vector chi(5);
  chi << 2.0, 0.5, 3.0, 0.25, 1.0;  // M Fv+ Fc+ Fv− Fc−
  const rivid::DynamicModel model(robot, base, chi);
  const SimulationOptions options{.f_m = 100.0};
  const auto steady_speed = [&](double force) {
    const Simulation found =
        simulate(robot, model, Open([=](double) { return force; }), rest(1, 100.0), options);
    return found.motion.qd(found.t.size() - 1, 0);
  };
  EXPECT_EQ(steady_speed(2.9), 0.0);
  EXPECT_EQ(steady_speed(-0.9), 0.0);
  EXPECT_NEAR(steady_speed(4.0), 2.0, 1e-4);
  EXPECT_NEAR(steady_speed(-2.0), -4.0, 1e-3);
}

TEST(ClosedLoop, AJointWithoutCoulombFrictionNeverSticks) {
  Scara scara;
  scara.set("Fc2", 0.0);
  const Simulation found = scara.run(scara_options(Integrator::adams, 1e-6));
  ASSERT_EQ(found.element_names.size(), 1U);
  EXPECT_EQ(found.element_names[0], "joint_1");
}

TEST(ClosedLoop, SmoothFrictionTendsToTheExactOne) {
  const Scara scara;
  const Simulation exact = scara.run(scara_options(Integrator::adams, 1e-8));
  double last = 1.0;
  for (const double v_s : {1e-2, 1e-3}) {
    SimulationOptions options = scara_options(Integrator::bdf, 1e-8);
    options.friction = rivid::DryFrictionScheme::smooth;
    options.smooth_velocity = v_s;
    const double error = farthest(scara.run(options), exact);
    EXPECT_LT(error, 0.5 * last);
    last = error;
  }
}

// The law belongs to the joint: `exact` is exact for a joint whose sign is one, and smooth for the other.
TEST(ClosedLoop, AJointWithASmoothedSignNeverSticks) {
  constexpr double v_s = 1e-2;
  Scara scara;
  SimulationOptions options = scara_options(Integrator::bdf, 1e-8);
  options.friction = rivid::DryFrictionScheme::smooth;
  options.smooth_velocity = v_s;
  const Simulation all_smooth = scara.run(options);
  scara.robot.joints[1].sign_speed = v_s;
  const Simulation one_smooth = scara.run(scara_options(Integrator::bdf, 1e-8));
  EXPECT_EQ(one_smooth.element_names, std::vector<std::string>{"joint_1"});
  scara.robot.joints[0].sign_speed = v_s;
  const Simulation both = scara.run(scara_options(Integrator::bdf, 1e-8));
  EXPECT_TRUE(both.element_names.empty());
  constexpr double integration = 1e-6;  // 100 rtol, over motions of a radian
  EXPECT_LT(farthest(both, all_smooth), integration);
  EXPECT_GT(farthest(both, one_smooth), integration);
  options.smooth_velocity = 1.0;  // counts for joints that have none of their own
  EXPECT_LT(farthest(scara.run(options), all_smooth), integration);
}

// A sampled law that is fast against the motion is the continuous one.
TEST(ClosedLoop, SamplingTendsToTheContinuousLaw) {
  const Scara scara;
  const Simulation continuous = scara.run(scara_options(Integrator::adams, 1e-8));
  double last = 1.0;
  for (const double period : {5e-3, 1e-3, 2e-4}) {
    SimulationOptions options = scara_options(Integrator::automatic, 1e-8);
    options.sampling.period = period;
    const double error = farthest(scara.run(options), continuous);
    EXPECT_LT(error, 0.3 * last) << period;
    last = error;
  }
}

TEST(ClosedLoop, ThePastOfALoopThatBeginsInMotionIsThatMotion) {
  Robot robot = rivid::test::slider(rivid::Friction::none);
  robot.joints[0].drive_gain = 1e-12;
  robot.chain.gravity.setZero();
  const rivid::DynamicModel model(
      robot, Vector::Constant(1, 1.0).replicate(10, 1).cwiseProduct(Vector::Unit(10, 9)));
  SimulationOptions options{.f_m = 1000.0, .samples = 20};
  options.sampling.period = 1e-3;
  options.sampling.velocity_filter = {0.5, -0.25, 0.0, 0.0, -0.25};
  options.q_0 = Vector::Constant(1, 0.3);
  options.qd_0 = Vector::Constant(1, 0.7);
  // Σ w_i (q − i T q̇) / T = −q̇ Σ i w_i, for weights whose sum is zero.
  const Simulation found = simulate(robot, model, Told(), rest(1, 1.0), options);
  for (Index k = 0; k < 20; ++k) {
    EXPECT_NEAR(found.v_tau(k, 0), 0.7 * 1.25, 1e-6) << k;
  }
}

TEST(ClosedLoop, DelayShiftsTheControlSignal) {
  const Robot robot = rivid::test::slider(rivid::Friction::none);
  const rivid::DynamicModel model(
      robot, Vector::Constant(1, 1.0).replicate(10, 1).cwiseProduct(Vector::Unit(10, 9)));
  SimulationOptions options{.f_m = 1000.0, .samples = 50};
  options.sampling.period = 1e-3;
  options.sampling.delay = 3;
  const Simulation found =
      simulate(robot, model, Open([](double t) { return 1.0 + t; }), rest(1, 1.0), options);
  for (Index k = 0; k < 50; ++k) {
    EXPECT_NEAR(found.v_tau(k, 0), k < 3 ? 0.0 : 1.0 + 1e-3 * static_cast<double>(k - 3), 1e-12) << k;
  }
}

// Two periods and a quarter: the signals change a quarter of a period behind the instants of the controller.
TEST(ClosedLoop, DelayOfAPartOfAPeriodIsHeldFromThere) {
  const Robot robot = rivid::test::slider(rivid::Friction::none);
  const rivid::DynamicModel model(robot, Vector::Unit(10, 9));
  constexpr Index quarters = 200;
  SimulationOptions options{.f_m = 4000.0, .samples = quarters + 1};
  options.sampling.period = 1e-3;
  options.sampling.delay = 2.25;
  const auto run = [&] {
    return simulate(robot, model, Open([](double t) { return 1.0 + t; }), rest(1, 1.0), options);
  };
  const Simulation found = run();
  double velocity = 0.0;
  for (Index k = 0; k <= quarters; ++k) {
    const double wanted = k < 9 ? 0.0 : 1.0 + 1e-3 * static_cast<double>((k - 1) / 4 - 2);
    EXPECT_NEAR(found.v_tau(k, 0), wanted, 1e-12) << k;
    EXPECT_NEAR(found.motion.qd(k, 0), velocity, 1e-9) << k;
    velocity += wanted / 4000.0;
  }
  EXPECT_GT(velocity, 0.04);
  // A loop that begins in a given state was under control before.
  options.q_0 = options.qd_0 = Vector::Zero(1);
  EXPECT_EQ(run().v_tau(0, 0), 1.0);
}

TEST(ClosedLoop, QuantisedMeasurementIsWhatTheLawSees) {
  const Scara scara;
  SimulationOptions options = scara_options(Integrator::automatic, 1e-6);
  options.sampling.period = 5e-3;
  options.sampling.quantum = Eigen::Vector2d(1e-3, 2e-3);
  const Simulation found = scara.run(options);
  for (Index k = 0; k < found.t.size(); ++k) {
    for (Index j = 0; j < 2; ++j) {
      const double steps = found.q_measured(k, j) / options.sampling.quantum[j];
      ASSERT_NEAR(steps, std::round(steps), 1e-9);
      ASSERT_LE(std::abs(found.q_measured(k, j) - found.motion.q(k, j)),
                0.5001 * options.sampling.quantum[j]);
    }
  }
}

TEST(ClosedLoop, ANameIsThatOfItsIntegrator) {
  EXPECT_EQ(name(Integrator::automatic), "automatic");
  EXPECT_EQ(name(Integrator::adams), "adams");
  EXPECT_EQ(name(Integrator::bdf), "bdf");
  EXPECT_EQ(name(Integrator::bogacki_shampine), "bogacki_shampine");
  EXPECT_EQ(name(Integrator::dormand_prince), "dormand_prince");
  EXPECT_EQ(name(Integrator::rk4), "rk4");
}

// The outcomes that are no motion.

TEST(ClosedLoop, AnIndefiniteMassMatrixIsNamedWithTimeJointAndEigenvalue) {
  Scara scara;
  scara.set("ZZ2", -0.05);
  const Simulation found = scara.run(scara_options(Integrator::adams, 1e-6));
  EXPECT_EQ(found.outcome, Outcome::not_positive_definite);
  for (const char* part : {"at t = 0 s", "\"joint_2\"", "eigenvalue is -0.05"}) {
    EXPECT_NE(found.reason.find(part), std::string::npos) << found.reason;
  }
  EXPECT_EQ(found.t.size(), 0);
}

TEST(ClosedLoop, AnUnstableLoopDivergesAndSaysWhere) {
  Scara scara;
  const rivid::DynamicModel model(scara.robot, scara.base, scara.truth);
  class Runaway final : public rivid::ControlLaw {
    void control(const rivid::ControlInput& input, const Eigen::Ref<const Vector>&, Eigen::Ref<Vector> v_tau,
                 Eigen::Ref<Vector>) const override {
      v_tau = 50.0 * input.qd;
    }
  };
  SimulationOptions options{.f_m = 200.0};
  options.qd_0 = Eigen::Vector2d(0.1, 0.1);
  for (const Integrator integrator : {Integrator::adams, Integrator::dormand_prince}) {
    options.integrator = integrator;
    const Simulation found = simulate(scara.robot, model, Runaway(), Scara::s1(), options);
    EXPECT_EQ(found.outcome, Outcome::diverged) << found.reason;
    EXPECT_NE(found.reason.find("\"joint_"), std::string::npos) << found.reason;
    EXPECT_TRUE(found.motion.q.allFinite() && found.motion.qdd.allFinite() && found.tau.allFinite());
    EXPECT_LT(found.t.size(), 4001);
    EXPECT_GT(found.t.size(), 0);
  }
}

TEST(ClosedLoop, ABudgetEndsIt) {
  SimulationOptions options = scara_options(Integrator::adams, 1e-6);
  options.max_steps = 100;
  const Simulation found = Scara().run(options);
  EXPECT_EQ(found.outcome, Outcome::too_slow);
  EXPECT_NE(found.reason.find("100 steps"), std::string::npos) << found.reason;
}

TEST(ClosedLoop, WarnsOfAReferenceBeyondTheLimits) {
  Scara scara;
  scara.robot.joints[1].upper = 1.8;
  const Simulation found = scara.run(scara_options(Integrator::adams, 1e-6));
  ASSERT_EQ(found.warnings.size(), 1U);
  EXPECT_EQ(found.warnings[0].code, "reference_limits");
  EXPECT_EQ(found.warnings[0].text, "the reference of joint \"joint_2\" reaches 2, beyond its limit 1.8");
}

TEST(ClosedLoop, RefusesOptionsThatCanNotBeUsed) {
  const Scara scara;
  const auto message = [&](auto&& change) {
    SimulationOptions options = scara_options(Integrator::adams, 1e-6);
    change(options);
    return rivid::test::complaint_of([&] { return scara.run(options); });
  };
  EXPECT_EQ(message([](auto& o) { o.rtol = 0.0; }), "simulate: rtol is 0, must be between 0 and 1");
  EXPECT_EQ(message([](auto& o) { o.atol = -1.0; }), "simulate: atol is -1, must be positive");
  EXPECT_EQ(message([](auto& o) { o.f_m = std::nan(""); }), "simulate: f_m is nan, must be positive [Hz]");
  EXPECT_EQ(message([](auto& o) { o.q_0 = Vector::Zero(3); }),
            "simulate: q_0 has 3 values, must have one for each of 2 joints");
  EXPECT_EQ(message([](auto& o) { o.disturbance = Matrix::Constant(5, 2, HUGE_VAL); }),
            "simulate: disturbance(0, 0) is inf, must be finite");
  EXPECT_EQ(message([](auto& o) { o.sampling.delay = -1; }),
            "simulate: sampling.delay is -1, must be between 0 and 1000000 periods");
  EXPECT_EQ(
      message([](auto& o) { o.sampling.quantum = Eigen::Vector2d(1e-3, 1e-3); }),
      "simulate: sampling.quantum needs a sampling.period: a continuous law sees the true motion at once");
  EXPECT_EQ(message([](auto& o) { o.integrator = Integrator::rk4; }),
            "simulate: integrator rk4 knows no events; friction must be smooth or held");
  EXPECT_EQ(message([](auto& o) { o.integrator = static_cast<Integrator>(9); }),
            "simulate: integrator or friction is none of the values of its enum");
  EXPECT_EQ(message([](auto& o) { o.sampling = {.period = 1e-3, .delay = INT_MAX}; }),
            "simulate: sampling.delay is 2.14748365e+09, must be between 0 and 1000000 periods");
  EXPECT_TRUE(rivid::test::says(message([](auto& o) { o.samples = Index{1} << 40; }),
                                "at most 100000000 are simulated"));
  // With all of the reference, too.
  EXPECT_TRUE(rivid::test::says(message([](auto& o) { o = {.sampling = {.period = 1e-300}}; }),
                                "ticks of the controller in"));
}

// A reference that lasts so long, and is no number from some instant on.
class Odd final : public rivid::Reference {
 public:
  Odd(double duration, double until) : duration_(duration), until_(until) {}
  [[nodiscard]] Index joints() const override { return 2; }
  [[nodiscard]] double duration() const override { return duration_; }
  void at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
          Eigen::Ref<Vector> qdd_r) const override {
    q_r.setConstant(t < until_ ? 0.0 : std::nan(""));
    qd_r.setZero();
    qdd_r.setZero();
  }

 private:
  double duration_;
  double until_;
};

TEST(ClosedLoop, RefusesAReferenceThatIsNone) {
  const Scara scara;
  const auto message = [&](double duration, double until) {
    return rivid::test::complaint_of([&] {
      return simulate(scara.robot, scara.base, scara.truth, scara.control, scara.J, Odd(duration, until));
    });
  };
  for (const double duration : {std::nan(""), -1.0, HUGE_VAL}) {
    EXPECT_TRUE(
        rivid::test::says(message(duration, 1.0), "both must be finite, and the second not negative"));
  }
  EXPECT_EQ(message(1.0, 0.0),
            "simulate: the reference of joint \"joint_1\" begins at nan with the velocity 0, must be finite");
}

TEST(ClosedLoop, NamesTheReferenceOrTheSignalThatIsNoNumber) {
  const Scara scara;
  const rivid::DynamicModel model(scara.robot, scara.base, scara.truth);
  const Open law([](double t) { return t < 0.05 ? 0.0 : std::nan(""); });
  for (const double period : {0.0, 0.01}) {
    const SimulationOptions options{.f_m = 100.0, .sampling = {.period = period}};
    const Simulation by_law = simulate(scara.robot, model, law, rest(2, 1.0), options);
    EXPECT_EQ(by_law.outcome, Outcome::diverged);
    EXPECT_TRUE(rivid::test::says(by_law.reason, "the control signal of joint \"joint_1\" is nan"));
    const Simulation by_reference =
        simulate(scara.robot, scara.base, scara.truth, scara.control, scara.J, Odd(1.0, 0.05), options);
    EXPECT_EQ(by_reference.outcome, Outcome::diverged);
    EXPECT_TRUE(rivid::test::says(by_reference.reason, "the reference of joint \"joint_1\" is nan"));
  }
}

TEST(ClosedLoop, RefusesAControlWithoutALaw) {
  const Scara scara;
  const auto message = [&](const rivid::Control& control) {
    return rivid::test::complaint_of(
        [&] { return simulate(scara.robot, scara.base, scara.truth, control, scara.J, rest(2, 1.0)); });
  };
  EXPECT_EQ(message({}), "control is empty, must make a ControlLaw");
  EXPECT_EQ(message([](const rivid::Plant&) { return nullptr; }),
            "control returns no law, must make a ControlLaw");
}

}  // namespace
