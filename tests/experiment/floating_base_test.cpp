// A trunk with two legs that floats: its torques beside those of point masses that move as it does, logs of
// its pose and of the forces on it, its description back.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>

#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/identify/payload.hpp"
#include "rivid/model/urdf.hpp"
#include "rivid/online/model.hpp"
#include "rivid/regressor/batch.hpp"
#include "support/complaint.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Point {
  double mass;
  Vector3d at;  // in the frame of its link
};
using Body = std::vector<Point>;

// The trunk, a leg that turns about y, one that slides along x.
const std::vector<Body> bodies = {
    {{2.0, {0.1, 0.2, -0.1}}, {1.5, {-0.3, 0.0, 0.1}}, {0.7, {0.0, -0.2, 0.3}}, {0.9, {0.2, 0.1, 0.2}}},
    {{0.4, {0.0, 0.1, -0.2}}, {0.3, {0.1, 0.0, -0.4}}, {0.2, {-0.1, 0.1, 0.0}}, {0.5, {0.1, 0.1, 0.1}}},
    {{0.6, {0.2, 0.0, 0.1}}, {0.2, {0.0, 0.3, 0.0}}, {0.3, {-0.1, 0.0, 0.2}}, {0.4, {0.1, 0.2, 0.1}}}};
const Vector3d hip(0.3, -0.1, 0.05);
const Vector3d rail(-0.2, 0.1, -0.1);
const Vector3d gravity(0.0, 0.0, -9.81);

std::string inertial_text(const Body& body) {
  double mass = 0.0;
  Vector3d first = Vector3d::Zero();
  for (const Point& p : body) {
    mass += p.mass;
    first += p.mass * p.at;
  }
  const Vector3d centre = first / mass;
  Matrix3d I = Matrix3d::Zero();
  for (const Point& p : body) {
    const Vector3d r = p.at - centre;
    I += p.mass * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose());
  }
  std::ostringstream out;
  out.precision(17);
  out << "<inertial><origin xyz=\"" << centre.x() << " " << centre.y() << " " << centre.z()
      << "\"/><mass value=\"" << mass << "\"/><inertia ixx=\"" << I(0, 0) << "\" ixy=\"" << I(0, 1)
      << "\" ixz=\"" << I(0, 2) << "\" iyy=\"" << I(1, 1) << "\" iyz=\"" << I(1, 2) << "\" izz=\"" << I(2, 2)
      << "\"/></inertial>";
  return out.str();
}

std::string urdf() {
  return "<robot name=\"walker\">\n<link name=\"trunk\">" + inertial_text(bodies[0]) +
         "</link>\n<link name=\"leg\">" + inertial_text(bodies[1]) + "</link>\n<link name=\"slide\">" +
         inertial_text(bodies[2]) +
         "</link>\n<joint name=\"hip\" type=\"continuous\"><parent link=\"trunk\"/><child link=\"leg\"/>"
         "<origin xyz=\"0.3 -0.1 0.05\"/><axis xyz=\"0 1 0\"/></joint>\n"
         "<joint name=\"rail\" type=\"prismatic\"><parent link=\"trunk\"/><child link=\"slide\"/>"
         "<origin xyz=\"-0.2 0.1 -0.1\"/><axis xyz=\"1 0 0\"/></joint>\n</robot>\n";
}

Robot walker() {
  Robot robot =
      parse_urdf(urdf(), "walker.urdf", {.base = {}, .tip = {}, .floating = true, .gravity = gravity});
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::none;
    joint.rotor_inertia = false;
  }
  return robot;
}

constexpr Index n = 8;
using Positions = Eigen::Vector<double, n>;

Matrix3d turn(const Positions& q) {
  return (Eigen::AngleAxisd(q[3], Vector3d::UnitZ()) * Eigen::AngleAxisd(q[4], Vector3d::UnitY()) *
          Eigen::AngleAxisd(q[5], Vector3d::UnitX()))
      .toRotationMatrix();
}

// A point of a link in the world.
Vector3d placed(const Positions& q, std::size_t link, const Vector3d& at) {
  const Vector3d on_trunk = link == 0   ? at
                            : link == 1 ? Vector3d(hip + Eigen::AngleAxisd(q[6], Vector3d::UnitY()) * at)
                                        : Vector3d(rail + q[7] * Vector3d::UnitX() + at);
  return q.head<3>() + turn(q) * on_trunk;
}

// Of a function of a number, by central differences of sixth order.
template <typename F>
Vector3d slope(const F& f, double h) {
  return (45.0 * (f(h) - f(-h)) - 9.0 * (f(2 * h) - f(-2 * h)) + (f(3 * h) - f(-3 * h))) / (60.0 * h);
}
template <typename F>
Vector3d curvature(const F& f, double h) {
  return (-490.0 * f(0.0) + 270.0 * (f(h) + f(-h)) - 27.0 * (f(2 * h) + f(-2 * h)) +
          2.0 * (f(3 * h) + f(-3 * h))) /
         (180.0 * h * h);
}

// Σ ∂x/∂q · m (ẍ − g) over all points, d'Alembert.
Positions expected(const Positions& q, const Positions& qd, const Positions& qdd) {
  Positions out = Positions::Zero();
  for (std::size_t link = 0; link < bodies.size(); ++link) {
    for (const Point& p : bodies[link]) {
      const Vector3d a =
          curvature([&](double t) { return placed(q + t * qd + 0.5 * t * t * qdd, link, p.at); }, 5e-3);
      for (Index i = 0; i < n; ++i) {
        const Vector3d J =
            slope([&](double d) { return placed(q + d * Positions::Unit(i), link, p.at); }, 1e-2);
        out[i] += p.mass * J.dot(a - gravity);
      }
    }
  }
  return out;
}

TEST(FloatingBase, RegressorTimesParametersIsTheMotionOfItsPoints) {
  constexpr double tolerance = 1e-9;  // sixth-order differences of motions of a few rad/s
  const Robot robot = walker();
  ASSERT_EQ(robot.size(), n);
  ASSERT_EQ(robot.base_joints, 6);
  const BaseParameters base = base_parameters(robot);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  Motion motion{Matrix(20, n), Matrix(20, n), Matrix(20, n)};
  Matrix tau(20, n);
  for (Index k = 0; k < 20; ++k) {
    for (Index j = 0; j < n; ++j) {
      motion.q(k, j) = draw(random);
      motion.qd(k, j) = 2.0 * draw(random);
      motion.qdd(k, j) = 5.0 * draw(random);
    }
    tau.row(k) =
        expected(motion.q.row(k).transpose(), motion.qd.row(k).transpose(), motion.qdd.row(k).transpose())
            .transpose();
  }
  const Vector found = observation(robot, base, motion).dense() * base.from_standard(robot.chi_st());
  EXPECT_LT((found - tau.reshaped()).cwiseAbs().maxCoeff(), tolerance * tau.cwiseAbs().maxCoeff());
}

TEST(FloatingBase, KnowsTheWholeMassAndTheTenParametersOfTheTrunk) {
  const Robot robot = walker();
  const BaseParameters base = base_parameters(robot);
  const Vector chi = base.from_standard(robot.chi_st());
  int of_trunk = 0;
  double mass = 0.0;
  for (Index i = 0; i < base.size(); ++i) {
    const StandardParameter& p = base.parameters[static_cast<std::size_t>(i)].leading;
    EXPECT_GE(p.joint, 5) << "links of virtual joints have no body";
    of_trunk += p.joint == 5 ? 1 : 0;
    mass += p.kind == ParameterKind::M ? chi[i] : 0.0;  // that of the slide is a parameter by itself
  }
  EXPECT_NEAR(mass, 8.0, 1e-12);
  EXPECT_EQ(of_trunk, 10);
  EXPECT_EQ(robot.standard_parameters().size(), 30U);
}

constexpr std::string_view experiment_text = R"(
[robot]
urdf = "walker.urdf"
floating = true
gravity = [0, 0, -9.81]
friction = "none"
rotor_inertia = [false, false]

[log]
files = ["log.csv"]

[log.base]
position = ["x", "y", "z"]
orientation = ["qw", "qx", "qy", "qz"]
)";

class WalkerLog : public testing::Test {
 protected:
  static constexpr int samples = 3000;
  static constexpr double rate = 1000.0;

  WalkerLog() { folder_.write("walker.urdf", urdf()); }

  // A smooth motion, and its derivatives, whose pitch is at most `pitch`.
  static std::array<Positions, 3> motion(double t, double pitch) {
    std::array<Positions, 3> out;
    for (Index j = 0; j < n; ++j) {
      const double w = 3.0 + 0.7 * static_cast<double>(j);
      const double v = 7.0 - 0.4 * static_cast<double>(j);
      const double a = j < 3 ? 0.1 : j == 4 ? pitch : 0.5;
      out[0][j] = a * (0.7 * std::sin(w * t + static_cast<double>(j)) + 0.3 * std::sin(v * t));
      out[1][j] = a * (0.7 * w * std::cos(w * t + static_cast<double>(j)) + 0.3 * v * std::cos(v * t));
      out[2][j] =
          -a * (0.7 * w * w * std::sin(w * t + static_cast<double>(j)) + 0.3 * v * v * std::sin(v * t));
    }
    out[0][3] += 2.0 * t;  // yaw goes round
    out[1][3] += 2.0;
    return out;
  }

  // Columns of pose, joints, joint torques and of a force that acts on the end of the leg, as a device there
  // shows it in the frame of the leg, which makes the rows of the base come out.
  void write(double pitch, bool torques = true) const {
    std::ostringstream text;
    text.precision(15);
    text << "t,x,y,z,qw,qx,qy,qz,ax,ay,az,q1,q2" << (torques ? ",tau1,tau2" : "")
         << ",fx,fy,fz,mx,my,mz,f1\n";
    const Vector3d imu(0.1, -0.2, 0.3);
    for (int k = 0; k < samples; ++k) {
      const double t = k / rate;
      const auto [q, qd, qdd] = motion(t, pitch);
      const Positions tau = expected(q, qd, qdd);
      const Eigen::Quaterniond turned(turn(q));
      // The whole wrench of the world, at the leg's point (0, 0, −0.4), balances the rows of the base.
      const Matrix3d of_leg = turn(q) * Eigen::AngleAxisd(q[6], Vector3d::UnitY()).toRotationMatrix();
      const Vector3d at(0.0, 0.0, -0.4);
      const Vector3d force = tau.head<3>();
      Eigen::Matrix3d axes;  // of yaw, pitch and roll
      axes.row(0) = Vector3d::UnitZ().transpose();
      axes.row(1) = (Eigen::AngleAxisd(q[3], Vector3d::UnitZ()) * Vector3d::UnitY()).transpose();
      axes.row(2) = turn(q).col(0).transpose();
      const Vector3d about_trunk = axes.fullPivLu().solve(Vector3d(tau.segment<3>(3)));
      const Vector3d moment = about_trunk - (placed(q, 1, at) - q.head<3>()).cross(force);
      const Vector3d a =
          curvature([&](double h) { return placed(q + h * qd + 0.5 * h * h * qdd, 0, imu); }, 5e-3);
      const Vector3d felt = turn(q).transpose() * (a - gravity);
      Eigen::Vector2d joints = tau.tail<2>();
      const Vector3d axis = turn(q).col(1);
      joints[0] -= axis.dot(moment + (placed(q, 1, at) - placed(q, 1, Vector3d::Zero())).cross(force));
      text << t;
      const auto put = [&](const auto& values) {
        for (const double value : values) {
          text << "," << value;
        }
      };
      put(Vector3d(q.head<3>()));
      text << "," << turned.w();
      put(Vector3d(turned.vec()));
      put(felt);
      put(Eigen::Vector2d(q.tail<2>()));
      if (torques) {
        put(joints);
      }
      put(Vector3d(of_leg.transpose() * force));
      put(Vector3d(of_leg.transpose() * moment));
      text << ",0\n";
    }
    folder_.write("log.csv", text.str());
  }

  [[nodiscard]] Experiment experiment(std::string text) const {
    folder_.write("walker.toml", text);
    return read_experiment(folder_.path() / "walker.toml");
  }
  static std::string with_contact() {
    return std::string(experiment_text) +
           "[[log.contact]]\nlink = \"leg\"\nwrench = [\"fx\", \"fy\", \"fz\", \"mx\", \"my\", \"mz\"]\n"
           "at = [0, 0, -0.4]\n";
  }
  static std::string with(std::string text, const std::string& old, const std::string& now) {
    return text.replace(text.find(old), old.size(), now);
  }
  [[nodiscard]] const test::TemporaryFolder& folder() const { return folder_; }

 private:
  test::TemporaryFolder folder_;
};

// Errors of parameters over the largest of their unit.
void expect_description(const Robot& robot, const Identification& found, double tolerance) {
  ASSERT_EQ(found.status, Status::identified) << (found.reasons.empty() ? "" : found.reasons.front());
  const Vector chi = found.base.from_standard(robot.chi_st());
  EXPECT_LT((found.chi - chi).cwiseAbs().maxCoeff(), tolerance * chi.cwiseAbs().maxCoeff());
}

TEST_F(WalkerLog, PoseAndMeasuredWrenchGiveItsDescription) {
  constexpr double tolerance = 1e-4;  // samples of 1 ms of motions of 1 Hz, differentiated
  write(0.5);
  const Experiment read = experiment(with_contact());
  const std::vector<Log> logs = read_logs(read.log, read.robot);
  ASSERT_EQ(logs.front().q.cols(), n);
  const auto [q, qd, qdd] = motion(2.5, 0.5);
  EXPECT_LT((logs.front().q.row(2500).transpose() - q).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((logs.front().tau.row(2500).transpose() - expected(q, qd, qdd)).cwiseAbs().maxCoeff(), 1e-7);
  const Identification found = run(read);
  expect_description(read.robot, found, tolerance);
}

TEST_F(WalkerLog, AccelerometerAndOrientationGiveTheSame) {
  constexpr double tolerance = 1e-4;
  write(0.5);
  const Experiment read = experiment(with(with_contact(), "position = [\"x\", \"y\", \"z\"]",
                                          "acceleration = [\"ax\", \"ay\", \"az\"]\nimu = [0.1, -0.2, 0.3]"));
  expect_description(read.robot, run(read), tolerance);
}

// No torque on the base: its six accelerations are those that leave none, and the torques of the joints fix
// the scale.
class FreeFlight : public WalkerLog {
 protected:
  // @param rail  amplitude of the sliding leg
  // @param seed  of noise of the pose (0.1 mm, 0.2 mrad) and the hip (20 µrad), which shakes at 60 Hz; 0:
  // none
  void write_flight(double rail_amplitude, bool torques, unsigned seed = 0) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const double shaken = seed == 0 ? 0.0 : 5e-3;  // rad
    using Six = Eigen::Vector<double, 6>;
    const auto joints = [&](double t) -> std::array<Eigen::Vector2d, 3> {
      const Eigen::Array2d w(11.0, 9.0);
      const Eigen::Array2d v(19.0, 21.0);
      const Eigen::Array2d a(0.6, rail_amplitude);
      const Eigen::Array2d at = w * t + Eigen::Array2d(0.0, 1.0);
      const double u = 2.0 * std::numbers::pi * 60.0;
      const Eigen::Array2d s(shaken, 0.0);
      return {a * (at.sin() + 0.5 * (v * t).sin()) + s * std::sin(u * t),
              a * (w * at.cos() + 0.5 * v * (v * t).cos()) + s * u * std::cos(u * t),
              -a * (w * w * at.sin() + 0.5 * v * v * (v * t).sin()) - s * u * u * std::sin(u * t)};
    };
    const auto state = [&](double t, const Six& q, const Six& qd) {
      const auto [s, sd, sdd] = joints(t);
      std::array<Positions, 3> out;
      out[0] << q, s;
      out[1] << qd, sd;
      out[2] << Six::Zero(), sdd;
      const Six held = expected(out[0], out[1], out[2]).head<6>();
      Eigen::Matrix<double, 6, 6> M;
      for (Index i = 0; i < 6; ++i) {
        M.col(i) = expected(out[0], out[1], out[2] + Positions::Unit(i)).head<6>() - held;
      }
      out[2].head<6>() = -M.fullPivLu().solve(held);
      return out;
    };
    Six q = Six::Zero();
    Six qd;
    qd << 0.2, -0.3, 3.0, 1.2, 0.5, 1.5;
    std::ostringstream text;
    text.precision(15);
    text << "t,x,y,z,roll,pitch,yaw,q1,q2" << (torques ? ",tau1,tau2\n" : "\n");
    for (int k = 0; k < 700; ++k) {
      const double t = k / rate;
      const double h = 1.0 / rate;
      const auto now = state(t, q, qd);
      const Positions tau = expected(now[0], now[1], now[2]);
      text << t;
      const std::array<double, 8> deviation = {1e-4, 1e-4, 1e-4, 2e-4, 2e-4, 2e-4, 2e-5, 2e-5};
      std::size_t column = 0;
      for (const double value : {q[0], q[1], q[2], q[5], q[4], q[3], now[0][6], now[0][7]}) {
        text << "," << value + (seed == 0 ? 0.0 : deviation[column++] * normal(random));
      }
      if (torques) {
        text << "," << tau[6] << "," << tau[7];
      }
      text << "\n";
      const Six a1 = now[2].head<6>();
      const Six v2 = qd + 0.5 * h * a1;
      const Six a2 = state(t + 0.5 * h, q + 0.5 * h * qd, v2)[2].head<6>();
      const Six v3 = qd + 0.5 * h * a2;
      const Six a3 = state(t + 0.5 * h, q + 0.5 * h * v2, v3)[2].head<6>();
      const Six v4 = qd + h * a3;
      const Six a4 = state(t + h, q + h * v3, v4)[2].head<6>();
      q += h / 6.0 * (qd + 2.0 * v2 + 2.0 * v3 + v4);
      qd += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
    folder().write("log.csv", text.str());
  }

  static std::string flight_text() {
    return with(std::string(experiment_text), "[\"qw\", \"qx\", \"qy\", \"qz\"]",
                "[\"roll\", \"pitch\", \"yaw\"]");
  }
  static std::string massive_text() {
    return with(with(flight_text(), "rotor_inertia = [false, false]",
                     "rotor_inertia = false\nmoving = [\"hip\"]\ntotal_mass = 8.0"),
                "files = [\"log.csv\"]", "files = [\"log.csv\"]\nposition = [\"q1\"]");
  }
};

constexpr double flight_tolerance = 1e-3;  // samples of 1 ms of motions of 3 Hz, differentiated

TEST_F(FreeFlight, GivesItsDescription) {
  write_flight(0.15, true);
  const Experiment read = experiment(flight_text());
  expect_description(read.robot, run(read), flight_tolerance);
}

// The rail is held: a mass that slides is none of the root.
TEST_F(FreeFlight, WithoutTorqueAKnownMassGivesItsDescription) {
  write_flight(0.0, false);
  const std::string text = massive_text();
  for (const std::string method : {"wls", "ols"}) {
    const Experiment read = experiment(text + "[method]\nname = \"" + method + "\"\n");
    const Identification found = run(read);
    expect_description(read.robot, found, flight_tolerance);
    const auto mass = std::ranges::find_if(
        found.base.parameters, [](const BaseParameter& p) { return p.leading.kind == ParameterKind::M; });
    EXPECT_EQ(found.chi[mass - found.base.parameters.begin()], 8.0);
    const ParameterEstimate& told =
        found.parameters[static_cast<std::size_t>(mass - found.base.parameters.begin())];
    EXPECT_NEAR(told.sigma, 1e-6 * 8.0, 1e-8);
    EXPECT_LT(std::abs(told.noise_bias), 0.1);
    EXPECT_EQ(std::ranges::find(found.warnings, "dead_torque", &Finding::code), found.warnings.end());
  }
  // Of a false mass all is false by one factor.
  const Experiment read = experiment(with(text, "total_mass = 8.0", "total_mass = 16.0"));
  const Identification found = run(read);
  const Vector chi = found.base.from_standard(read.robot.chi_st());
  EXPECT_LT((found.chi - 2.0 * chi).cwiseAbs().maxCoeff(),
            2.0 * flight_tolerance * chi.cwiseAbs().maxCoeff());

  const auto said = [&](const std::string& other) {
    const Experiment wrong = experiment(other);
    return test::complaint_of([&] { return read_logs(wrong.log, wrong.robot); });
  };
  EXPECT_TRUE(test::says(said(with(text, "friction = \"none\"", "friction = \"coulomb\"")),
                         "friction and rotor of joint \"hip\" need"));
  EXPECT_TRUE(test::says(said(with(text, "total_mass = 8.0", "")), "but for one scale"));
  EXPECT_TRUE(test::says(test::complaint_of([&] { return experiment(with(text, "moving = [\"hip\"]", "")); }),
                         "without sliding links"));
}

// What shakes the hip counts as noise of its position, whose expected bias is tens of σ: intervals are as
// wide as the estimate at twice the window bears it out.
TEST_F(FreeFlight, NoiseThatIsMotionDoesNotWidenIntervals) {
  double squares = 0.0;
  double count = 0.0;
  double most_expected = 0.0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    write_flight(0.0, false, seed);
    const Experiment read = experiment(massive_text());
    const Identification found = run(read);
    const Vector error = found.chi - found.base.from_standard(read.robot.chi_st());
    for (Index i = 0; i < error.size(); ++i) {
      const ParameterEstimate& told = found.parameters[static_cast<std::size_t>(i)];
      squares += std::pow(error[i] / told.sigma, 2);
      count += error[i] != 0.0 ? 1.0 : 0.0;
      most_expected = std::max(most_expected, std::abs(told.noise_bias));
    }
  }
  EXPECT_GT(most_expected, 30.0);
  EXPECT_GT(count, 60.0);
  EXPECT_GT(std::sqrt(squares / count), 0.5);
  EXPECT_LT(std::sqrt(squares / count), 1.1);
}

TEST_F(WalkerLog, SingularPitchIsRefusedWithItsInstant) {
  write(2.5);
  const Experiment read = experiment(with_contact());
  const std::string said = test::complaint_of([&] { return read_logs(read.log, read.robot); });
  EXPECT_TRUE(test::says(said, "the base is pitched by")) << said;
  EXPECT_TRUE(test::says(said, "at t = ")) << said;
}

TEST_F(WalkerLog, ScaleNeedsATorqueOrAWrench) {
  constexpr double tolerance = 1e-4;
  write(0.5, false);
  const Experiment read = experiment(std::string(experiment_text));
  EXPECT_TRUE(
      test::says(test::complaint_of([&] { return read_logs(read.log, read.robot); }), "but for one scale"));
  const Experiment touched = experiment(with_contact());
  expect_description(touched.robot, run(touched), tolerance);
  const Experiment paper = experiment(with_contact() + "[signal]\nrows = \"paper\"\n");
  EXPECT_TRUE(test::says(test::complaint_of([&] { return run(paper); }), "needs exact rows"));
}

TEST_F(WalkerLog, WhatDoesNotFitIsRefused) {
  write(0.5);
  const auto said = [&](const std::string& text) {
    return test::complaint_of([&] { return experiment(text); });
  };
  const std::string good = with_contact();
  EXPECT_TRUE(test::says(said(with(good, "floating = true\n", "")), "belong together"));
  EXPECT_TRUE(test::says(said(with(good, "link = \"leg\"", "link = \"foot\"")), "is no moving link"));
  EXPECT_TRUE(test::says(said(with(good, "\"qx\", \"qy\", ", "")), "must name 4 or 3"));
  EXPECT_TRUE(test::says(said(with(good, "\"mx\", ", "")), "must name 6 or 3"));
  EXPECT_TRUE(test::says(said(good + "[control]\nlaw = \"pd\"\nomega_n = 10\n"), "stands still"));
  const Experiment wrong = experiment(with(good, "\"qw\", \"qx\"", "\"ax\", \"qx\""));
  EXPECT_TRUE(
      test::says(test::complaint_of([&] { return read_logs(wrong.log, wrong.robot); }), "quaternion"));
}

TEST(FloatingBase, IsRefusedByWhatKnowsNoPose) {
  const Robot robot = walker();
  EXPECT_TRUE(
      test::says(PayloadOptions{.link = "leg"}.complaint(robot).value_or(""), "base that stands still"));
  OnlineModel online;
  online.robot = robot;
  EXPECT_TRUE(test::says(online.complaint().value_or(""), "know no pose of the base"));
}

TEST(FloatingBase, IsWrittenBackWithoutItsVirtualJoints) {
  const Robot robot = walker();
  Vector chi_st = robot.chi_st();
  chi_st[9] += 1.0;  // M of the trunk
  const RewrittenUrdf written = rewritten_urdf(urdf(), "walker.urdf", robot, chi_st);
  EXPECT_TRUE(written.faults.empty());
  EXPECT_EQ(written.text.find("base_"), std::string::npos) << written.text;
  const Robot again = parse_urdf(written.text, "written.urdf", same_part(robot));
  EXPECT_NEAR(again.inertials[5][9], robot.inertials[5][9] + 1.0, 1e-12);
}

TEST_F(WalkerLog, DraftNamesItsPose) {
  for (const std::string& header :
       {std::string("t,base_x,base_y,base_z,base_qw,base_qx,base_qy,base_qz,q1,q2,tau1,tau2,"
                    "leg_fx,leg_fy,leg_fz"),
        std::string("t,odom.pose.pose.position.x,odom.pose.pose.position.y,odom.pose.pose.position.z,"
                    "odom.pose.pose.orientation.x,odom.pose.pose.orientation.y,odom.pose.pose.orientation.z,"
                    "odom.pose.pose.orientation.w,q1,q2,tau1,tau2")}) {
    std::string text = header + "\n";
    for (int k = 0; k < 10; ++k) {
      text += std::to_string(0.001 * k);
      for (std::ptrdiff_t c = std::ranges::count(header, ','); c > 0; --c) {
        text += ",0.5";
      }
      text += "\n";
    }
    folder().write("log.csv", text);
    const std::vector<std::filesystem::path> logs = {folder().path() / "log.csv"};
    const ExperimentDraft made =
        draft_experiment(folder().path() / "drafted.toml", folder().path() / "walker.urdf", {}, logs);
    EXPECT_TRUE(made.complete) << made.text;
    folder().write("drafted.toml", made.text);
    const Experiment read = read_experiment(folder().path() / "drafted.toml");
    ASSERT_TRUE(read.log.base) << made.text;
    EXPECT_EQ(read.robot.base_joints, 6);
    ASSERT_EQ(read.log.contact.size(), (header.find("leg") != std::string::npos) ? 1U : 0U) << made.text;
    EXPECT_TRUE(read.log.contact.empty() || read.log.contact.front().link == "leg");
    EXPECT_TRUE(read.log.base->position.front().name.ends_with("x"));
    EXPECT_TRUE(read.log.base->orientation.front().name.ends_with("w"));
    EXPECT_TRUE(read.log.base->orientation.back().name.ends_with("z"));
  }
}

TEST_F(WalkerLog, DraftTakesNoPoseOfAToolForItsBase) {
  std::string text =
      "t,pose.position.x,pose.position.y,pose.position.z,pose.orientation.x,pose.orientation.y,"
      "pose.orientation.z,pose.orientation.w,q1,q2,tau1,tau2\n";
  for (int k = 0; k < 10; ++k) {
    text += std::to_string(0.001 * k) + ",0.5,0.5,0.5,0.5,0.5,0.5,0.5,0.5,0.5,0.5,0.5\n";
  }
  folder().write("log.csv", text);
  const std::vector<std::filesystem::path> logs = {folder().path() / "log.csv"};
  const ExperimentDraft made =
      draft_experiment(folder().path() / "drafted.toml", folder().path() / "walker.urdf", {}, logs);
  EXPECT_EQ(made.text.find("floating"), std::string::npos) << made.text;
}

}  // namespace
}  // namespace rivid
