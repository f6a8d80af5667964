#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "rivid/simulate/control_laws.hpp"
#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "support/complaint.hpp"
#include "support/mallocs.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;

// The loops are linear: differences of their rates lose rounding alone, of which eigenvalues make a little
// more.
constexpr double of_differences = 1e-9;
// The same sum in another order, on signals of some thousands.
constexpr double rounding = 1e-10;

// Axes of a gantry, x, y, z: their mass matrix is diagonal and constant, so that each is a joint by itself.
Robot gantry(Index n) {
  Robot robot;
  robot.name = "gantry";
  robot.chain.gravity.setZero();
  // z of a frame along x of the one before.
  Eigen::Matrix3d next;
  next << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  for (Index j = 0; j < n; ++j) {
    Chain::Link link;
    link.type = JointType::prismatic;
    link.R = j == 0 ? Eigen::Matrix3d::Identity() : next;
    robot.chain.links.push_back(link);
    Joint joint;
    joint.name = "axis_" + std::to_string(j + 1);
    joint.link = "carriage_" + std::to_string(j + 1);
    joint.type = JointType::prismatic;
    joint.friction = Friction::none;
    joint.gear_ratio = 3.0 + static_cast<double>(j);
    joint.drive_gain = 0.7;
    robot.joints.push_back(joint);
    robot.inertials.push_back(inertial_from_com(2.0 + static_cast<double>(j), Eigen::Vector3d::Zero(),
                                                0.01 * Eigen::Matrix3d::Identity()));
  }
  return robot;
}

DynamicModel model_of(const Robot& robot, double factor = 1.0) { return {robot, factor * robot.chi_st()}; }

Plant plant_of(const Robot& robot, const DynamicModel& model) {
  return {robot, model, design_inertia(model, Matrix::Zero(1, robot.size()))};
}

struct Output {
  Vector v_tau, xd;
};

struct State {
  Vector q, qd, q_r, qd_r, qdd_r, x;

  explicit State(Index n, Index states = 0)
      : q(Vector::Zero(n)), qd(q), q_r(q), qd_r(q), qdd_r(q), x(Vector::Zero(states)) {}
};

Output output_of(const ControlLaw& law, const State& at) {
  Output out{Vector::Zero(at.q.size()), Vector::Zero(law.states())};
  law.control({0.0, at.q, at.qd, at.q_r, at.qd_r, at.qdd_r}, at.x, out.v_tau, out.xd);
  return out;
}

// Rates of (q, q̇, x) of a law that governs a robot, the reference being at zero.
Vector rates(const ControlLaw& law, const Robot& robot, const DynamicModel& model, const Vector& z) {
  const Index n = robot.size();
  State at(n, law.states());
  at.q = z.head(n);
  at.qd = z.segment(n, n);
  at.x = z.tail(law.states());
  const Output out = output_of(law, at);
  Vector zd(z.size());
  zd << at.qd, direct_dynamics(model, at.q, at.qd, robot.drive_matrix() * out.v_tau), out.xd;
  return zd;
}

// Poles of the loop by differencing its rates.
Eigen::VectorXcd poles_of(const ControlLaw& law, const Robot& robot, const DynamicModel& model) {
  const Index size = 2 * robot.size() + law.states();
  Matrix A(size, size);
  for (Index k = 0; k < size; ++k) {
    const Vector step = Vector::Unit(size, k);
    A.col(k) = 0.5 * (rates(law, robot, model, step) - rates(law, robot, model, -step));
  }
  return A.eigenvalues();
}

// Π (s − pole) at some places: the polynomial is well conditioned where multiple poles are not.
void expect_poles(const Eigen::VectorXcd& got, const std::vector<std::complex<double>>& wanted,
                  const std::string& what) {
  ASSERT_EQ(got.size(), static_cast<Index>(wanted.size())) << what;
  double scale = 0.0;
  for (const auto& pole : wanted) {
    scale = std::max(scale, std::abs(pole));
  }
  for (const std::complex<double> place :
       {std::complex(1.0, 0.0), std::complex(0.3, 1.2), std::complex(-0.5, 0.4)}) {
    std::complex<double> a = 1.0;
    std::complex<double> b = 1.0;
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      a *= place - got[static_cast<Index>(k)] / scale;
      b *= place - wanted[k] / scale;
    }
    EXPECT_LT(std::abs(a - b), of_differences) << what << "\ngot\n" << got;
  }
}

// Roots of s² + 2ζ ω s + ω².
std::vector<std::complex<double>> second_order(double omega, double zeta) {
  const std::complex<double> root = std::sqrt(std::complex(zeta * zeta - 1.0, 0.0));
  return {omega * (-zeta + root), omega * (-zeta - root)};
}

struct Law {
  std::string name;
  Control control;
  bool integral = false;
};

constexpr double omega_asked[] = {4.0, 25.0, 9.0};
constexpr double zeta_asked[] = {0.7, 1.0, 1.3};
constexpr double omega_i_asked[] = {0.9, 5.0, 1.0};

Vector first_of(const double* values, Index n) { return Vector::Map(values, n); }

std::vector<Law> laws_by_poles(Index n) {
  const Vector omega_n = first_of(omega_asked, n);
  const Vector zeta = first_of(zeta_asked, n);
  const Vector omega_i = first_of(omega_i_asked, n);
  return {
      {"PD", PdControl{.omega_n = omega_n, .zeta = zeta}},
      {"PD with reference velocity", PdControl{.omega_n = omega_n, .zeta = zeta, .reference_velocity = true}},
      {"PID", PidControl{.omega_n = omega_n, .zeta = zeta, .omega_i = omega_i}, true},
      {"PID without integral", PidControl{.omega_n = omega_n, .zeta = zeta}},
      {"cascade", CascadeControl{.omega_n = omega_n, .zeta = zeta, .omega_i = omega_i}, true},
      {"cascade without integral", CascadeControl{.omega_n = omega_n, .zeta = zeta}},
      {"computed torque", ComputedTorqueControl{.omega_n = omega_n, .zeta = zeta}}};
}

std::vector<std::complex<double>> asked_poles(Index n, bool integral) {
  std::vector<std::complex<double>> out;
  for (Index j = 0; j < n; ++j) {
    for (const auto& pole : second_order(omega_asked[j], zeta_asked[j])) {
      out.push_back(pole);
    }
    if (integral) {
      out.emplace_back(-omega_i_asked[j]);
    }
  }
  return out;
}

Vector gain(const ControlLaw& law, const std::string& name) {
  for (const Gain& gain : law.description().gains) {
    if (gain.name == name) {
      return gain.values;
    }
  }
  ADD_FAILURE() << "there is no gain " << name;
  return {};
}

// The known gains of a controller of that kind, as its maker would tell them.
Control with_known_gains(const Law& law, const ControlLaw& tuned, const Vector& J_apriori) {
  const bool integral = law.integral;
  if (law.name.starts_with("PD")) {
    return PdControl{.k_p = gain(tuned, "k_p"),
                     .k_v = gain(tuned, "k_v"),
                     .J_apriori = J_apriori,
                     .reference_velocity = law.name != "PD"};
  }
  if (law.name.starts_with("PID")) {
    return PidControl{.K_p = gain(tuned, "K_p"),
                      .K_i = integral ? gain(tuned, "K_i") : Vector(),
                      .K_d = gain(tuned, "K_d"),
                      .J_apriori = J_apriori};
  }
  return CascadeControl{.k_p = gain(tuned, "k_p"),
                        .k_v = gain(tuned, "k_v"),
                        .T_i = gain(tuned, "T_i"),
                        .J_apriori = J_apriori};
}

TEST(ControlLaws, HaveThePolesAskedForTrueAndForWildlyWrongParameters) {
  const Robot robot = gantry(3);
  for (const Law& law : laws_by_poles(3)) {
    for (const double factor : {1.0, 0.01, 0.2, 5.0, 100.0}) {
      const DynamicModel model = model_of(robot, factor);
      expect_poles(poles_of(*law.control(plant_of(robot, model)), robot, model), asked_poles(3, law.integral),
                   law.name);
    }
  }
}

TEST(ControlLaws, KeepThePolesOfKnownGainsForWildlyWrongParameters) {
  const Robot robot = gantry(3);
  const DynamicModel truth = model_of(robot);
  const Plant actual = plant_of(robot, truth);
  for (const Law& law : laws_by_poles(3)) {
    if (law.name == "computed torque") {
      continue;  // its gains have no unit of inertia
    }
    const Control known = with_known_gains(law, *law.control(actual), actual.J);
    for (const double factor : {1.0, 0.01, 100.0}) {
      const DynamicModel model = model_of(robot, factor);
      expect_poles(poles_of(*known(plant_of(robot, model)), robot, model), asked_poles(3, law.integral),
                   law.name);
    }
  }
}

TEST(ControlLaws, DecoupleAFullGearMatrix) {
  Robot robot = gantry(3);
  for (Joint& joint : robot.joints) {
    joint.gear_ratio = 1.0;
  }
  robot.gear_matrix.resize(3, 3);
  robot.gear_matrix << 32.0, 0.0, 0.0, 0.0, -48.0, 0.0, 7.0, 32.0, 20.0;
  for (const Law& law : laws_by_poles(3)) {
    for (const double factor : {1.0, 0.01, 100.0}) {
      const DynamicModel model = model_of(robot, factor);
      expect_poles(poles_of(*law.control(plant_of(robot, model)), robot, model), asked_poles(3, law.integral),
                   law.name);
    }
  }
}

TEST(ControlLaws, FollowEq47WithAWrongInertiaOrDriveGain) {
  Robot robot = gantry(1);
  const DynamicModel model = model_of(robot);
  for (const auto& [J_ratio, g_ratio] : {std::pair{1.5, 1.0}, std::pair{1.0, 0.8}, std::pair{0.6, 1.3}}) {
    Robot apriori = robot;
    apriori.joints[0].drive_gain *= g_ratio;
    const DynamicModel apriori_model = model_of(robot, J_ratio);
    const auto law = PdControl{.omega_n = Vector::Constant(1, 10.0),
                               .zeta = Vector::Constant(1, 0.6)}(plant_of(apriori, apriori_model));
    const double ratio = std::sqrt(J_ratio / g_ratio);
    expect_poles(poles_of(*law, robot, model), second_order(10.0 * ratio, 0.6 * ratio), "Eq. (47)");
  }
}

TEST(ControlLaws, FeedNothingBackAtRestOnTheReference) {
  const Robot robot = gantry(3);
  const DynamicModel model = model_of(robot);
  for (const Law& law : laws_by_poles(3)) {
    const auto made = law.control(plant_of(robot, model));
    State at(3, made->states());
    at.q = at.q_r = Eigen::Vector3d(0.3, -1.0, 2.0);
    const Output out = output_of(*made, at);
    EXPECT_TRUE(out.v_tau.isZero(0.0)) << law.name;
    EXPECT_TRUE(out.xd.isZero(0.0)) << law.name;
  }
}

TEST(ControlLaws, NeverExceedTheSaturation) {
  const Robot robot = gantry(3);
  const DynamicModel model = model_of(robot);
  const Plant plant = plant_of(robot, model);
  const Vector most = Eigen::Vector3d(10.0, 0.5, 3.0);
  const Vector omega_n = first_of(omega_asked, 3);
  const Vector zeta = first_of(zeta_asked, 3);
  const Vector omega_i = first_of(omega_i_asked, 3);
  const std::vector<Control> controls = {
      PdControl{.omega_n = omega_n, .zeta = zeta, .v_tau_max = most},
      PidControl{.omega_n = omega_n, .zeta = zeta, .omega_i = omega_i, .v_tau_max = most},
      CascadeControl{.omega_n = omega_n, .zeta = zeta, .omega_i = omega_i, .v_tau_max = most},
      ComputedTorqueControl{.omega_n = omega_n, .zeta = zeta, .v_tau_max = most}};
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (const Control& control : controls) {
    const auto law = control(plant);
    Vector reached = Vector::Zero(3);
    for (int k = 0; k < 200; ++k) {
      State at(3, law->states());
      for (Vector* part : {&at.q, &at.qd, &at.q_r, &at.qd_r, &at.qdd_r, &at.x}) {
        *part = Vector::NullaryExpr(part->size(), [&] { return normal(random); });
      }
      reached = reached.cwiseMax(output_of(*law, at).v_tau.cwiseAbs());
    }
    EXPECT_EQ(reached, most);
  }
}

TEST(ControlLaws, DoNotAllocate) {
  std::mt19937_64 random(3);
  Robot robot = test::random_robot(6, random);
  robot.joints[0].friction = Friction::asymmetric;
  const DynamicModel model = model_of(robot);
  const Plant plant = plant_of(robot, model);
  const Vector ones = Vector::Ones(6);
  for (const Control& control :
       {Control(PdControl{.omega_n = ones, .zeta = ones}),
        Control(PidControl{.omega_n = ones, .zeta = ones, .omega_i = ones, .v_tau_max = ones}),
        Control(CascadeControl{.omega_n = ones, .zeta = ones, .omega_i = 0.2 * ones}),
        Control(ComputedTorqueControl{.omega_n = ones, .zeta = ones})}) {
    const auto law = control(plant);
    const State at(6, law->states());
    Output out{Vector::Zero(6), Vector::Zero(law->states())};
    EXPECT_EQ(test::allocations_of([&] {
                law->control({0.0, at.q, at.qd, at.q_r, at.qd_r, at.qdd_r}, at.x, out.v_tau, out.xd);
              }),
              0);
  }
}

TEST(PdControl, IsEq40WithTheGainsOfEq45) {
  const Robot robot = gantry(2);
  const DynamicModel model = model_of(robot);
  const Plant plant = plant_of(robot, model);
  EXPECT_DOUBLE_EQ(plant.J[0], 2.0 + 3.0);
  const auto law = PdControl{.omega_n = Eigen::Vector2d(1.0, 10.0), .zeta = Eigen::Vector2d(1.0, 0.5)}(plant);
  const Vector k_p = Eigen::Vector2d(0.5, 10.0);
  const Vector k_v = Eigen::Vector2d(2.0 * 5.0 / (3.0 * 0.7), 10.0 * 3.0 / (4.0 * 0.7));
  EXPECT_EQ(law->description().law, "PD");
  EXPECT_LT((gain(*law, "k_p") - k_p).norm(), rounding);
  EXPECT_LT((gain(*law, "k_v") - k_v).norm(), rounding);
  State at(2);
  at.q << 0.2, 0.4;
  at.qd << -1.0, 2.0;
  at.q_r << 1.0, 0.0;
  at.qd_r << 5.0, 6.0;
  const Vector v_tau = k_v.cwiseProduct(k_p.cwiseProduct(at.q_r - at.q) - at.qd);
  EXPECT_LT((output_of(*law, at).v_tau - v_tau).norm(), rounding);
  EXPECT_EQ(law->states(), 0);
}

TEST(PdControl, HoldsKnownGainsWithoutAnInertiaToAdaptThemTo) {
  // EMPS: v = 160.18 · 243.45 (q_r − q) − 243.45 q̇, at most 10 V.
  Robot robot = test::slider();
  robot.joints[0].drive_gain = 35.15065188;
  const DynamicModel model(robot, 95.1 * Vector::Unit(robot.chi_st().size(), 9));
  const PdControl control{.k_p = Vector::Constant(1, 160.18),
                          .k_v = Vector::Constant(1, 243.45),
                          .v_tau_max = Vector::Constant(1, 10.0)};
  const auto law = control({robot, model, {}});
  State at(1);
  at.q << 0.1;
  at.qd << 0.02;
  at.q_r << 0.1001;
  EXPECT_NEAR(output_of(*law, at).v_tau[0], 160.18 * 243.45 * 1e-4 - 243.45 * 0.02, 1e-9);
  at.q_r << 0.2;
  EXPECT_EQ(output_of(*law, at).v_tau[0], 10.0);
}

TEST(PidControl, WithoutIntegralIsThePdLawOfManufacturers) {
  const Robot robot = gantry(2);
  const DynamicModel model = model_of(robot);
  const Vector K_p = Eigen::Vector2d(341.9, 375.0);
  const Vector K_d = Eigen::Vector2d(2.5361, 4.1174);
  const auto law = PidControl{.K_p = K_p, .K_d = K_d}({robot, model, {}});
  State at(2);
  at.q << 0.2, 0.4;
  at.qd << -1.0, 2.0;
  at.q_r << 1.0, 0.0;
  at.qd_r << 5.0, 6.0;
  const Vector v_tau = K_p.cwiseProduct(at.q_r - at.q) + K_d.cwiseProduct(at.qd_r - at.qd);
  EXPECT_LT((output_of(*law, at).v_tau - v_tau).norm(), rounding);
  EXPECT_EQ(law->states(), 0);
}

TEST(PidControl, WithoutIntegralActionOnAJointLetsNothingWindUpThere) {
  const Robot robot = gantry(2);
  const DynamicModel model = model_of(robot);
  const auto law = PidControl{.K_p = Eigen::Vector2d(10.0, 10.0),
                              .K_i = Eigen::Vector2d(0.0, 5.0),
                              .K_d = Eigen::Vector2d(1.0, 1.0),
                              .v_tau_max = Eigen::Vector2d(1.0, 1.0)}({robot, model, {}});
  State at(2, law->states());
  at.q_r << 3.0, 3.0;
  const Output out = output_of(*law, at);
  EXPECT_EQ(out.xd[0], 0.0);
  // K_i e + (v_τ − v) / T_t with T_t = √(K_d / K_i)
  EXPECT_NEAR(out.xd[1], 15.0 + (1.0 - 30.0) / std::sqrt(1.0 / 5.0), rounding);
}

// Position of a one-axis gantry that follows a step of its reference, by the classical Runge-Kutta method.
struct Step {
  double overshoot = 0.0;
  double last = 0.0;
};

Step step_response(const Control& control, double distance, double duration) {
  const Robot robot = gantry(1);
  const DynamicModel model = model_of(robot);
  const auto law = control(plant_of(robot, model));
  Vector z = Vector::Zero(2 + law->states());
  z[0] = -distance;  // the reference is at zero
  Step out;
  const double h = 1e-3;
  for (double t = 0.0; t < duration; t += h) {
    const auto f = [&](const Vector& state) { return rates(*law, robot, model, state); };
    const Vector k1 = f(z);
    const Vector k2 = f(z + 0.5 * h * k1);
    const Vector k3 = f(z + 0.5 * h * k2);
    const Vector k4 = f(z + h * k3);
    z += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    out.overshoot = std::max(out.overshoot, z[0]);
  }
  out.last = z[0];
  return out;
}

// The same with a sampled controller: its output is held for a period, its states go on by xd times the
// period.
Step sampled_step_response(const Control& control, double distance, double duration) {
  const Robot robot = gantry(1);
  const DynamicModel model = model_of(robot);
  const Plant plant = plant_of(robot, model);
  const auto law = control(plant);
  State at(1, law->states());
  at.q[0] = -distance;
  Step out;
  const double h = 1e-3;
  for (double t = 0.0; t < duration; t += h) {
    const Output held = output_of(*law, at);
    const double qdd = robot.joints[0].g_tau() * held.v_tau[0] / plant.J[0];
    at.q[0] += h * (at.qd[0] + 0.5 * h * qdd);
    at.qd[0] += h * qdd;
    at.x += h * held.xd;
    out.overshoot = std::max(out.overshoot, at.q[0]);
  }
  out.last = at.q[0];
  return out;
}

TEST(AntiWindup, RecoversFromALongSaturation) {
  const Vector one = Vector::Ones(1);
  const PidControl pid{.omega_n = 5.0 * one, .zeta = one, .omega_i = one, .v_tau_max = one};
  const CascadeControl cascade{.omega_n = 5.0 * one, .zeta = one, .omega_i = one, .v_tau_max = one};
  PidControl wound_pid = pid;
  CascadeControl wound_cascade = cascade;
  wound_pid.tracking_time = wound_cascade.tracking_time = Vector::Constant(1, 1e9);
  const std::vector<std::pair<Control, Control>> pairs = {{pid, wound_pid}, {cascade, wound_cascade}};
  for (const auto& [control, wound] : pairs) {
    for (const auto& response : {step_response, sampled_step_response}) {
      const Step with = response(control, 2.0, 20.0);
      const Step without = response(wound, 2.0, 20.0);
      EXPECT_LT(std::abs(with.last), 1e-3);
      EXPECT_LT(with.overshoot, 0.5 * without.overshoot);
    }
  }
}

TEST(CascadeControl, BecomesThePdLawWithoutIntegralAction) {
  const Robot robot = gantry(2);
  const DynamicModel model = model_of(robot);
  const Plant plant = plant_of(robot, model);
  const Vector omega_n = Eigen::Vector2d(3.0, 20.0);
  const Vector zeta = Eigen::Vector2d(0.8, 1.0);
  const auto cascade = CascadeControl{
      .omega_n = omega_n, .zeta = zeta, .omega_i = Vector::Zero(2), .feed_forward = Vector::Zero(2)}(plant);
  const auto pd = PdControl{.omega_n = omega_n, .zeta = zeta}(plant);
  EXPECT_EQ(cascade->states(), 0);
  for (const char* const name : {"k_p", "k_v"}) {
    EXPECT_LT((gain(*cascade, name) - gain(*pd, name)).norm(), rounding) << name;
  }
  State at(2);
  at.q << 0.2, 0.4;
  at.qd_r << 5.0, 6.0;
  EXPECT_LT((output_of(*cascade, at).v_tau - output_of(*pd, at).v_tau).norm(), rounding);
}

TEST(CascadeControl, HasTheFastestIntegralPoleThatItCanHave) {
  const Robot robot = gantry(1);
  const DynamicModel model = model_of(robot);
  const Plant plant = plant_of(robot, model);
  const auto asked = [](double omega_i) {
    return CascadeControl{.omega_n = Vector::Constant(1, 10.0),
                          .zeta = Vector::Constant(1, 1.0),
                          .omega_i = Vector::Constant(1, omega_i)};
  };
  const auto law = asked(2.5)(plant);
  EXPECT_NEAR(gain(*law, "k_p")[0] * gain(*law, "T_i")[0], 1.0, 1e-6);
  EXPECT_TRUE(says(
      complaint_of([&] { static_cast<void>(asked(2.6)(plant)); }),
      "CascadeControl: omega_i of joint \"axis_1\" is 2.6 rad/s, must be at most omega_n / (2 (1 + zeta)) "
      "= 2.5 rad/s"));
}

TEST(ComputedTorqueControl, MakesEachJointADoubleIntegrator) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    const int n = 1 + static_cast<int>(seed % 7);
    Robot robot = test::random_robot(n, random);
    robot.joints[0].friction = Friction::asymmetric;
    if (n > 2) {
      robot.couplings = {
          {.motor = n - 1, .joints = {n - 2}, .ratios = {-0.7}, .Iam = 0.05, .Fvm = 0.3, .Fcm = 0.4}};
      robot.gear_matrix = Matrix::Identity(n, n) + 0.1 * test::random_motion(n, n, random).q;
    }
    const DynamicModel model(robot, robot.chi_st());
    const Vector omega_n = Vector::LinSpaced(n, 3.0, 20.0);
    const Vector zeta = Vector::LinSpaced(n, 0.5, 1.0);
    const auto law =
        ComputedTorqueControl{.omega_n = omega_n, .zeta = zeta, .coulomb_velocity = 1e-6}({robot, model, {}});
    const Motion motion = test::random_motion(3, n, random);
    State at(n);
    at.q = motion.q.row(0);
    at.q_r = motion.q.row(1);
    at.qd = motion.qd.row(0);
    at.qd_r =
        1.5 * at.qd;  // in the same directions, so that the compensated Coulomb friction has the right signs
    at.qdd_r = motion.qdd.row(0);
    const Vector wanted = at.qdd_r + 2.0 * zeta.cwiseProduct(omega_n).cwiseProduct(at.qd_r - at.qd) +
                          omega_n.cwiseAbs2().cwiseProduct(at.q_r - at.q);
    const Vector qdd = direct_dynamics(model, at.q, at.qd, robot.drive_matrix() * output_of(*law, at).v_tau);
    EXPECT_LT((qdd - wanted).norm(), 1e-9 * wanted.norm()) << "seed " << seed;
  }
}

TEST(ComputedTorqueControl, KeepsAModelOfItsOwn) {
  const Robot robot = gantry(1);
  const DynamicModel model = model_of(robot);
  const auto own = std::make_shared<const DynamicModel>(model_of(robot, 4.0));
  const Vector one = Vector::Ones(1);
  const auto law =
      ComputedTorqueControl{.k_p = 9.0 * one, .k_d = 2.0 * one, .model = own}({robot, model, {}});
  expect_poles(poles_of(*law, robot, model), second_order(6.0, 2.0 * 4.0 / 12.0), "four times the mass");
}

TEST(ControlLaws, RefuseGainsThatCanNotBeUsed) {
  const Robot robot = gantry(2);
  const DynamicModel model = model_of(robot);
  const Plant plant = plant_of(robot, model);
  const Vector ones = Vector::Ones(2);
  const Vector spoiled = Eigen::Vector2d(1.0, 0.0);
  const Vector broken = Eigen::Vector2d(std::nan(""), 1.0);
  const auto complaint = [&](const Control& control) {
    return complaint_of([&] { static_cast<void>(control(plant)); });
  };
  EXPECT_TRUE(says(complaint(PdControl{}), "PdControl: give either omega_n and zeta, or k_p and k_v"));
  EXPECT_TRUE(says(complaint(PdControl{.omega_n = ones, .zeta = ones, .k_p = ones}), ", not both"));
  EXPECT_TRUE(says(complaint(PdControl{.omega_n = spoiled, .zeta = ones}),
                   "PdControl: omega_n of joint \"axis_2\" is 0, must be positive and finite"));
  EXPECT_TRUE(says(complaint(PdControl{.omega_n = ones, .zeta = broken}), "zeta of joint \"axis_1\" is nan"));
  EXPECT_TRUE(says(complaint(PdControl{.omega_n = ones}), "zeta has 0 entries for 2 joints"));
  EXPECT_TRUE(says(complaint(PdControl{.omega_n = Vector::Ones(3), .zeta = ones}),
                   "omega_n has 3 entries for 2 joints"));
  EXPECT_TRUE(says(complaint(PdControl{.k_p = -ones, .k_v = ones}),
                   "k_p of joint \"axis_1\" is -1, must be positive"));
  EXPECT_TRUE(
      says(complaint(PdControl{.k_p = ones, .k_v = spoiled}),
           "k_v of joint \"axis_2\" is 0, must be finite and of the sign of the drive gain g_tau, not zero"));
  EXPECT_TRUE(says(complaint(PdControl{.k_p = ones, .k_v = ones, .J_apriori = -ones}),
                   "J_apriori of joint \"axis_1\" is -1"));
  EXPECT_TRUE(says(complaint(PdControl{.omega_n = ones, .zeta = ones, .v_tau_max = spoiled}),
                   "v_tau_max of joint \"axis_2\" is 0"));
  EXPECT_TRUE(says(complaint(PidControl{}),
                   "PidControl: give either omega_n and zeta (with omega_i), or K_p and K_d"));
  EXPECT_TRUE(says(complaint(PidControl{.omega_n = ones, .zeta = ones, .omega_i = -ones}),
                   "omega_i of joint \"axis_1\" is -1, must be finite and not negative"));
  EXPECT_TRUE(says(complaint(PidControl{.K_p = spoiled, .K_d = ones}), "K_p of joint \"axis_2\" is 0"));
  EXPECT_TRUE(
      says(complaint(PidControl{.K_p = ones, .K_i = -ones, .K_d = ones}), "K_i of joint \"axis_1\" is -1"));
  EXPECT_TRUE(
      says(complaint(PidControl{.omega_n = ones, .zeta = ones, .omega_i = ones, .tracking_time = spoiled}),
           "tracking_time of joint \"axis_2\" is 0"));
  EXPECT_TRUE(says(complaint(CascadeControl{}), "CascadeControl: give either omega_n and zeta"));
  EXPECT_TRUE(says(complaint(CascadeControl{.k_p = ones, .k_v = ones, .T_i = -ones}),
                   "T_i of joint \"axis_1\" is -1"));
  EXPECT_TRUE(says(complaint(CascadeControl{.k_p = ones, .k_v = ones, .feed_forward = -ones}),
                   "feed_forward of joint \"axis_1\" is -1"));
  EXPECT_TRUE(
      says(complaint(ComputedTorqueControl{}), "ComputedTorqueControl: give either omega_n and zeta"));
  EXPECT_TRUE(says(complaint(ComputedTorqueControl{.omega_n = ones, .zeta = ones, .coulomb_velocity = 0.0}),
                   "coulomb_velocity is 0, must be positive"));
  const Robot other = gantry(1);
  EXPECT_TRUE(says(
      complaint(ComputedTorqueControl{
          .omega_n = ones, .zeta = ones, .model = std::make_shared<const DynamicModel>(model_of(other))}),
      "the model has 1 joint, the robot has 2"));
}

TEST(ControlLaws, RefuseAPlantWithoutAPositiveInertia) {
  const Robot robot = gantry(2);
  const DynamicModel model = model_of(robot);
  const Vector ones = Vector::Ones(2);
  const auto complaint = [&](const Control& control, const Vector& J) {
    return complaint_of([&] { static_cast<void>(control({robot, model, J})); });
  };
  const PdControl poles{.omega_n = ones, .zeta = ones};
  EXPECT_TRUE(says(complaint(poles, {}), "PdControl: the design inertia J has 0 entries for 2 joints"));
  EXPECT_TRUE(says(complaint(poles, Eigen::Vector2d(1.0, -2.0)),
                   "the design inertia J of joint \"axis_2\" is -2, must be positive and finite"));
  EXPECT_EQ(complaint(PdControl{.k_p = ones, .k_v = ones}, {}), "");
}

TEST(ControlLaws, TakeTheSignOfTheDriveGain) {
  Robot robot = gantry(1);
  robot.joints[0].gear_ratio = -48.0;
  const DynamicModel model = model_of(robot);
  const Plant plant = plant_of(robot, model);
  const Vector one = Vector::Ones(1);
  for (const Law& law : laws_by_poles(1)) {
    expect_poles(poles_of(*law.control(plant), robot, model), asked_poles(1, law.integral), law.name);
  }
  EXPECT_NO_THROW(static_cast<void>(PdControl{.k_p = one, .k_v = -one}(plant)));
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(PdControl{.k_p = one, .k_v = one}(plant)); }),
                   "of the sign of the drive gain g_tau"));
}

TEST(ControlLaws, RefuseKnownGainsWhereGearsCoupleTheJoints) {
  Robot robot = gantry(2);
  for (Joint& joint : robot.joints) {
    joint.gear_ratio = 1.0;
  }
  robot.gear_matrix.resize(2, 2);
  robot.gear_matrix << 45.0, 0.0, 32.0, 32.0;
  const DynamicModel model = model_of(robot);
  const Vector ones = Vector::Ones(2);
  for (const Control& control :
       {Control(PdControl{.k_p = ones, .k_v = ones}), Control(PidControl{.K_p = ones, .K_d = ones}),
        Control(CascadeControl{.k_p = ones, .k_v = ones})}) {
    EXPECT_TRUE(says(
        complaint_of([&] { static_cast<void>(control(plant_of(robot, model))); }),
        "the robot's gear_matrix couples its joints, so that no control signal belongs to one joint alone; "
        "give the poles"));
  }
  EXPECT_NO_THROW(static_cast<void>(ComputedTorqueControl{.k_p = ones, .k_d = ones}(plant_of(robot, model))));
}

// docs/control.md names this law as an example.
class FilteredPd : public ControlLaw {
 public:
  explicit FilteredPd(Vector k_v) : k_v_(std::move(k_v)) {}

  [[nodiscard]] Index states() const override { return k_v_.size(); }

  void control(const ControlInput& input, const Eigen::Ref<const Vector>& x, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> xd) const override {
    v_tau = k_v_.cwiseProduct(k_p * (input.q_r - input.q) - x);
    xd = (input.qd - x) / T_f;
  }

 private:
  static constexpr double k_p = 5.0;
  static constexpr double T_f = 0.01;
  Vector k_v_;
};

TEST(ControlLaws, MayBeOfOnesOwn) {
  const Robot robot = gantry(2);
  const DynamicModel model = model_of(robot);
  const Control control = [](const Plant& plant) {
    Vector k_v(plant.J.size());
    for (Index j = 0; j < k_v.size(); ++j) {
      k_v[j] = 20.0 * plant.J[j] / plant.robot.joints[static_cast<std::size_t>(j)].g_tau();
    }
    return std::make_unique<FilteredPd>(k_v);
  };
  const auto law = control(plant_of(robot, model));
  EXPECT_TRUE(law->description().gains.empty());
  // (s² + 100) (1 + 0.01 s) + 20 s = 0
  for (const auto& pole : poles_of(*law, robot, model)) {
    EXPECT_LT(std::abs((pole * pole + 100.0) * (1.0 + 0.01 * pole) + 20.0 * pole), 1e-6);
  }
}

}  // namespace
}  // namespace rivid
