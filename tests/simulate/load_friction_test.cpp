// Friction that follows the load, Fl |M q̈ + N| sign q̇, against equations and an integrator of its own.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "rivid/regressor/load.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/references.hpp"
#include "rivid/simulate/stick_slip.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr double gravity = 9.80665;
constexpr double length = 0.5;

// Two links in a vertical plane, whose equations stand in every book.
struct Arm {
  double ZZ1 = 1.9, MX1 = 2.2, Fv1 = 0.7, Fc1 = 1.5, Fl1 = 0.12;
  double ZZ2 = 0.22, MX2 = 0.6, Fv2 = 0.2, Fc2 = 0.4, Fl2 = 0.25;

  [[nodiscard]] static std::array<double, 2> torque(double t) {
    return {14.0 + 32.0 * std::sin(2.1 * t + 0.3), 3.0 * std::sin(3.7 * t) + 2.0};
  }

  [[nodiscard]] Robot robot() const {
    Robot out = test::scara();
    out.chain.gravity = {0.0, 0.0, -gravity};
    out.chain.links[0].R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    for (Joint& joint : out.joints) {
      joint.friction = Friction::load;
      joint.rotor_inertia = false;
    }
    return out;
  }

  [[nodiscard]] Vector chi_st(const Robot& robot) const {
    Vector out = Vector::Zero(static_cast<Index>(robot.standard_parameters().size()));
    const auto set = [&](ParameterKind kind, int joint, double value) {
      const std::vector<StandardParameter> list = robot.standard_parameters();
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (list[i].kind == kind && list[i].joint == joint) {
          out[static_cast<Index>(i)] = value;
        }
      }
    };
    using enum ParameterKind;
    set(ZZ, 0, ZZ1);
    set(MX, 0, MX1);
    set(Fv, 0, Fv1);
    set(Fc, 0, Fc1);
    set(Fl, 0, Fl1);
    set(ZZ, 1, ZZ2);
    set(MX, 1, MX2);
    set(Fv, 1, Fv2);
    set(Fc, 1, Fc2);
    set(Fl, 1, Fl2);
    return out;
  }
};

// Event-driven simulation: Runge-Kutta's classical steps, ends of modes by bisection.
class Oracle {
 public:
  using State = std::array<double, 4>;  // q1 q2 q̇1 q̇2

  explicit Oracle(const Arm& arm) : arm_(arm) {}

  // Positions every 0.01 s.
  std::vector<std::array<double, 2>> run(double duration) {
    std::vector<std::array<double, 2>> out;
    constexpr int parts = 500;
    const double h = 0.01 / parts;
    settle();
    const int samples = static_cast<int>(std::lround(duration / 0.01));
    for (int k = 0; k <= samples; ++k) {
      out.push_back({y_[0], y_[1]});
      for (int i = 0; i < parts; ++i) {
        advance(h);
      }
    }
    return out;
  }
  [[nodiscard]] int changes() const { return changes_; }

 private:
  struct Dynamics {
    double M11, M12, M22, N1, N2;
  };

  [[nodiscard]] Dynamics dynamics(const State& y) const {
    const double c = std::cos(y[1]);
    const double s = std::sin(y[1]);
    const double a = length * arm_.MX2;
    return {arm_.ZZ1 + arm_.ZZ2 + 2.0 * a * c, arm_.ZZ2 + a * c, arm_.ZZ2,
            -a * s * (2.0 * y[2] * y[3] + y[3] * y[3]) +
                gravity * (arm_.MX1 * std::cos(y[0]) + arm_.MX2 * std::cos(y[0] + y[1])),
            a * s * y[2] * y[2] + gravity * arm_.MX2 * std::cos(y[0] + y[1])};
  }

  // M q̈ + N that is left of a driving torque by friction that slips to the side `s`, solved case by case.
  [[nodiscard]] static double carried(double driving, double Fl, int s) {
    const double positive = driving / (1.0 + Fl * s);
    return positive >= 0.0 ? positive : driving / (1.0 - Fl * s);
  }

  // Accelerations in given modes, and what holds the joints that stick less what may hold them.
  std::array<double, 2> accelerations(double t, const State& y, const std::array<int, 2>& mode,
                                      std::array<double, 2>* excess) const {
    const Dynamics d = dynamics(y);
    const std::array<double, 2> tau = Arm::torque(t);
    const std::array<double, 2> Fv = {arm_.Fv1, arm_.Fv2};
    const std::array<double, 2> Fc = {arm_.Fc1, arm_.Fc2};
    const std::array<double, 2> Fl = {arm_.Fl1, arm_.Fl2};
    std::array<double, 2> u{};
    for (std::size_t j = 0; j < 2; ++j) {
      u[j] = carried(tau[j] - Fv[j] * y[2 + j] - Fc[j] * mode[j], Fl[j], mode[j]);
    }
    std::array<double, 2> a{};
    if (mode[0] != 0 && mode[1] != 0) {
      const double det = d.M11 * d.M22 - d.M12 * d.M12;
      const double r1 = u[0] - d.N1;
      const double r2 = u[1] - d.N2;
      return {(d.M22 * r1 - d.M12 * r2) / det, (d.M11 * r2 - d.M12 * r1) / det};
    }
    if (mode[0] != 0) {
      a[0] = (u[0] - d.N1) / d.M11;
    } else if (mode[1] != 0) {
      a[1] = (u[1] - d.N2) / d.M22;
    }
    const std::array<double, 2> load = {d.M11 * a[0] + d.M12 * a[1] + d.N1,
                                        d.M12 * a[0] + d.M22 * a[1] + d.N2};
    for (std::size_t j = 0; j < 2 && excess != nullptr; ++j) {
      const double held = tau[j] - load[j];
      (*excess)[j] =
          mode[j] != 0
              ? 0.0
              : std::copysign(std::max(std::abs(held) - Fc[j] - Fl[j] * std::abs(load[j]), 0.0), held);
    }
    return a;
  }

  // Joints at rest that can not be held are let go.
  void settle() {
    for (int round = 0; round < 4; ++round) {
      std::array<double, 2> excess{};
      accelerations(t_, y_, mode_, &excess);
      bool changed = false;
      for (std::size_t j = 0; j < 2; ++j) {
        if (mode_[j] == 0 && excess[j] != 0.0) {
          mode_[j] = excess[j] > 0.0 ? 1 : -1;
          ++changes_;
          changed = true;
        }
      }
      if (!changed) {
        return;
      }
    }
  }

  [[nodiscard]] State stepped(double h) const {
    const auto rate = [&](double t, const State& y) -> State {
      const auto a = accelerations(t, y, mode_, nullptr);
      return {mode_[0] != 0 ? y[2] : 0.0, mode_[1] != 0 ? y[3] : 0.0, a[0], a[1]};
    };
    const auto moved = [&](const State& k, double by) {
      State out = y_;
      for (std::size_t i = 0; i < 4; ++i) {
        out[i] += by * k[i];
      }
      return out;
    };
    const State k1 = rate(t_, y_);
    const State k2 = rate(t_ + 0.5 * h, moved(k1, 0.5 * h));
    const State k3 = rate(t_ + 0.5 * h, moved(k2, 0.5 * h));
    const State k4 = rate(t_ + h, moved(k3, h));
    State out = y_;
    for (std::size_t i = 0; i < 4; ++i) {
      out[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    }
    return out;
  }

  // The joint whose mode ends within h, or −1.
  [[nodiscard]] int ends(double h) const {
    const State y = stepped(h);
    std::array<double, 2> excess{};
    accelerations(t_ + h, y, mode_, &excess);
    for (int j = 0; j < 2; ++j) {
      const auto at = static_cast<std::size_t>(j);
      if (mode_[at] != 0 ? y[2 + at] * mode_[at] < 0.0 : excess[at] != 0.0) {
        return j;
      }
    }
    return -1;
  }

  void advance(double h) {
    while (h > 0.0) {
      if (ends(h) < 0) {
        y_ = stepped(h);
        t_ += h;
        return;
      }
      double low = 0.0;
      double high = h;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (ends(middle) < 0 ? low : high) = middle;
      }
      const int joint = ends(high);
      y_ = stepped(high);
      t_ += high;
      h -= high;
      const auto at = static_cast<std::size_t>(joint);
      if (mode_[at] != 0) {
        mode_[at] = 0;
        y_[2 + at] = 0.0;
        ++changes_;
      }
      settle();
    }
  }

  Arm arm_;
  State y_ = {0.2, -0.4, 0.0, 0.0};
  std::array<int, 2> mode_ = {0, 0};
  double t_ = 0.0;
  int changes_ = 0;
};

class TorqueOfTime final : public ControlLaw {
 public:
  void control(const ControlInput& input, const Eigen::Ref<const Vector>& /*x*/, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> /*xd*/) const override {
    const auto tau = Arm::torque(input.t);
    v_tau << tau[0], tau[1];
  }
};

TEST(LoadFriction, MovesAsAnIndependentSimulationDoes) {
  constexpr double duration = 3.0;
  const Arm arm;
  Oracle oracle(arm);
  const auto expected = oracle.run(duration);
  ASSERT_GE(oracle.changes(), 6) << "the motion is to stick and to break away";
  const Robot robot = arm.robot();
  const DynamicModel model(robot, arm.chi_st(robot));
  const PointToPointReference rest({.via = Matrix::Zero(2, 2), .durations = Vector::Constant(1, duration)});
  for (const Integrator integrator : {Integrator::adams, Integrator::dormand_prince}) {
    SimulationOptions options{.f_m = 100.0};
    options.integrator = integrator;
    options.rtol = 1e-10;
    options.atol = 1e-12;
    options.q_0 = Eigen::Vector2d(0.2, -0.4);
    options.qd_0 = Vector::Zero(2);
    const Simulation found = simulate(robot, model, TorqueOfTime(), rest, options);
    ASSERT_EQ(found.outcome, Outcome::completed);
    EXPECT_GE(found.effort.mode_changes, 6);
    for (Index k = 0; k < found.t.size(); ++k) {
      for (Index j = 0; j < 2; ++j) {
        ASSERT_NEAR(found.motion.q(k, j), expected[static_cast<std::size_t>(k)][static_cast<std::size_t>(j)],
                    1e-6)
            << "t = " << found.t[k] << ", joint " << j + 1;
      }
    }
  }
}

// Joint by joint: held within Fc + Fl |M q̈ + N|, or driven off against it.
TEST(LoadFriction, DecidesAllJointsAtRestByItsOwnLaw) {
  std::mt19937_64 random(4711);
  std::normal_distribution<double> normal;
  int stuck = 0;
  int slipping = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 1 + trial % 7;
    Robot robot = test::random_robot(n, random);
    for (Joint& joint : robot.joints) {
      joint.friction = Friction::load;
    }
    Vector chi_st = test::distinct_friction(robot);
    const DynamicModel model(robot, chi_st);
    Dynamics<double> dynamics(model);
    StickSlip friction(model);
    const auto span_of = [](Vector& x) { return std::span(x.data(), static_cast<std::size_t>(x.size())); };
    Vector q = Vector::NullaryExpr(n, [&] { return normal(random); });
    Vector qd = Vector::Zero(n);
    ASSERT_TRUE(dynamics.set_state(span_of(q), span_of(qd)));
    friction.reset(span_of(qd));
    const Vector N = Vector::Map(dynamics.N().data(), n);
    const Vector driving = N + Vector::NullaryExpr(n, [&] { return 5.0 * normal(random); });
    Vector f = driving - N;
    friction.settle(dynamics, -1, span_of(qd), span_of(f));
    f = driving - N;
    Vector qdd(n);
    friction.accelerate(dynamics, span_of(qd), span_of(f), span_of(qdd));
    const Vector load = inverse_dynamics(model, q, qd, qdd) - model.offset();
    for (Index j = 0; j < n; ++j) {
      const DryFriction& law = model.dry_friction()[static_cast<std::size_t>(j)];
      const double held = driving[j] - load[j];
      const double most = law.Fc_plus + law.load * std::abs(load[j]);
      const double rounding = 1e-8 * (1.0 + std::abs(driving[j]) + std::abs(load[j]));
      switch (friction.mode(j)) {
        case FrictionMode::stick:
          EXPECT_EQ(qdd[j], 0.0);
          EXPECT_LE(std::abs(held), most + rounding);
          ++stuck;
          break;
        case FrictionMode::slip_plus:
          EXPECT_GE(qdd[j], -rounding);
          EXPECT_NEAR(held, most, rounding);
          ++slipping;
          break;
        case FrictionMode::slip_minus:
          EXPECT_LE(qdd[j], rounding);
          EXPECT_NEAR(held, -most, rounding);
          ++slipping;
          break;
      }
    }
  }
  EXPECT_GT(stuck, 100);
  EXPECT_GT(slipping, 100);
}

TEST(LoadFriction, TakesAtMostWhatAGearCanLose) {
  const Arm arm{.Fl1 = -0.1, .Fl2 = 1.3};
  const Robot robot = arm.robot();
  const DynamicModel model(robot, arm.chi_st(robot));
  EXPECT_EQ(model.clamped(), (std::vector<std::string>{"Fl1", "Fl2"}));
  EXPECT_EQ(model.dry_friction()[0].load, 0.0);
  EXPECT_EQ(model.dry_friction()[1].load, 0.95);
}

TEST(LoadFriction, IsRefusedBesideDryFrictionOfACoupledMotor) {
  Robot robot = Arm().robot();
  robot.couplings = {{.motor = 1, .joints = {0}, .ratios = {1.0}}};
  robot.joints[0].rotor_inertia = robot.joints[1].rotor_inertia = true;
  ASSERT_TRUE(robot.complaint());
  EXPECT_TRUE(test::says(*robot.complaint(), "follows its load"));
  robot.couplings[0].coulomb = Coupling::Coulomb::none;
  EXPECT_FALSE(robot.complaint());
}

TEST(LoadColumns, AreTheLoadTimesTheSignOfTheVelocity) {
  std::mt19937_64 random(12);
  for (const int n : {1, 3, 6}) {
    Robot robot = test::random_robot(n, random);
    for (Joint& joint : robot.joints) {
      joint.friction = Friction::load;
    }
    const BaseParameters base = base_parameters(robot);
    const Vector chi = base.from_standard(test::distinct_friction(robot));
    const Motion motion = test::random_motion(40, n, random);
    const Observation W = observation(robot, at_load(base, chi), motion);
    const DynamicModel model(robot, base, chi);
    for (Index k = 0; k < motion.samples(); ++k) {
      const Vector q = motion.q.row(k);
      const Vector qd = motion.qd.row(k);
      const Vector qdd = motion.qdd.row(k);
      const Vector load = mass_matrix(model, q) * qdd + bias(model, q, qd);
      for (std::size_t j = 0; j < W.joints.size(); ++j) {
        for (std::size_t c = 0; c < W.joints[j].columns.size(); ++c) {
          const auto at = static_cast<std::size_t>(W.joints[j].columns[c]);
          if (base.parameters[at].leading.kind == ParameterKind::Fl) {
            const auto joint = static_cast<Index>(j);
            EXPECT_NEAR(W.joints[j].W(k, static_cast<Index>(c)), std::abs(load[joint]) * sign(qd[joint]),
                        1e-9 * (1.0 + load.cwiseAbs().maxCoeff()));
          }
        }
      }
    }
  }
}

// The rows of the tangent are the derivatives of the torques by the parameters.
TEST(LoadColumns, OfTheTangentAreDerivatives) {
  std::mt19937_64 random(13);
  Robot robot = test::random_robot(4, random);
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::load_root;
  }
  const BaseParameters base = base_parameters(robot);
  const Vector chi = base.from_standard(test::distinct_friction(robot));
  const Motion motion = test::random_motion(30, 4, random);
  const auto torque = [&](const Vector& at) {
    return Vector(observation(robot, at_load(base, at), motion).dense() * at);
  };
  const Matrix tangent = observation(robot, at_load(base, chi, Vector::Zero(4)), motion).dense();
  for (Index i = 0; i < base.size(); ++i) {
    const double step = 1e-6;
    const Vector by = step * Vector::Unit(base.size(), i);
    const Vector slope = (torque(chi + by) - torque(chi - by)) / (2.0 * step);
    // Samples whose load changes its sign within the step have no derivative.
    const Vector error = (tangent.col(i) - slope).cwiseAbs();
    EXPECT_LT(error.maxCoeff(), 1e-6 * (1.0 + slope.cwiseAbs().maxCoeff()))
        << base.parameters[static_cast<std::size_t>(i)].name;
  }
}

TEST(LoadColumns, AskForParametersOfTheLoad) {
  const Robot robot = Arm().robot();
  std::mt19937_64 random(14);
  const Motion motion = test::random_motion(5, 2, random);
  EXPECT_TRUE(test::says(
      test::complaint_of([&] { static_cast<void>(observation(robot, base_parameters(robot), motion)); }),
      "base.load.chi"));
  EXPECT_EQ(without_load(robot).joints[0].friction, Friction::symmetric);
  EXPECT_TRUE(has_load(robot));
  EXPECT_FALSE(has_load(without_load(robot)));
}

TEST(LoadColumns, AreIndependentOfAllOthers) {
  for (const int n : {1, 2, 6}) {
    std::mt19937_64 random(static_cast<std::uint64_t>(15 + n));
    Robot robot = test::random_robot(n, random);
    const Index plain = base_parameters(robot).size();
    for (Joint& joint : robot.joints) {
      joint.friction = Friction::load_root;
    }
    EXPECT_EQ(base_parameters(robot).size(), plain + 2 * n);
  }
}

}  // namespace
}  // namespace rivid
