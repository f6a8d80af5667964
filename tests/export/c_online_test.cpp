// What a generated header has for a control loop, against the observer of the library and a known payload.

#include <gtest/gtest.h>

#include <iomanip>
#include <sstream>

#include "rivid/export/c_header.hpp"
#include "rivid/online/contact_observer.hpp"
#include "support/c_compilers.hpp"
#include "support/online.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

constexpr double f_m = 1000.0;
constexpr double bandwidth = 40.0;
constexpr double smooth = 0.03;  // v_s of all joints
constexpr Index joints = 5;

// Reads q, qd and tau tick by tick; prints the observed torque of each tick, and at the end the payload and
// what it leaves.
constexpr const char* program = R"(#include <stdio.h>
#include "robot.h"

static robot_observer observer;
static robot_payload payload;

static void show(const double* x, int count) {
  int i;
  for (i = 0; i < count; ++i) {
    printf("%.17g ", x[i]);
  }
}

int main(void) {
  double x[3][robot_JOINTS], smoothing_speed[robot_JOINTS], sigma[robot_JOINTS];
  double taken[2] = {0.0, 0.0};
  int j, k = 0;
  FILE* file = fopen("ticks.txt", "r");
  for (j = 0; j < robot_JOINTS; ++j) {
    smoothing_speed[j] = SMOOTH;
    sigma[j] = 0.2;
  }
  while (file != 0 && fscanf(file, "%lf", &x[k / robot_JOINTS][k % robot_JOINTS]) == 1) {
    if (++k == 3 * robot_JOINTS) {
      k = 0;
      taken[0] += robot_observe(&observer, x[0], x[1], x[2], smoothing_speed, BANDWIDTH, F_M);
      taken[1] += robot_estimate_payload(&payload, x[0], x[1], x[2], smoothing_speed, sigma, 5.0, BANDWIDTH, F_M);
      show(observer.torque, robot_JOINTS);
    }
  }
  show(&payload.mass, 1);
  show(payload.com, 3);
  show(&payload.mass_sigma, 1);
  show(payload.com_sigma, 3);
  show(payload.rest, robot_JOINTS);
  show(taken, 2);
  return 0;
}
)";

std::string number_for(std::string_view name, double value) {
  std::ostringstream out;
  out << "#define " << name << ' ' << value << '\n';
  return out.str();
}

struct Scene {
  Robot robot;
  Vector chi_st;
  Inertial body;  // frame of the last link
  Matrix q, qd, tau;

  explicit Scene(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    robot = test::random_robot(joints, random);
    robot.chain.gravity = {0.0, 0.0, -9.81};
    for (std::size_t j = 0; j < robot.joints.size(); ++j) {
      robot.chain.links[j].type = robot.joints[j].type = j == 1 ? JointType::prismatic : JointType::revolute;
    }
    robot.joints[0].friction = Friction::load;
    robot.joints[1].friction = Friction::asymmetric;
    robot.joints[2].sign_speed = 0.3;
    chi_st = test::distinct_friction(robot);
    body = inertial_from_com(2.0, {0.04, -0.02, 0.08}, Eigen::Vector3d(0.02, 0.03, 0.025).asDiagonal());
    const Motion motion = test::Wandering(joints, seed, 0.8, 1.2).at(test::ticks(10.0, f_m));
    q = motion.q.transpose();
    qd = motion.qd.transpose();
    const Matrix at =
        test::torques(DynamicModel(robot, test::loaded(robot, chi_st, body)), motion).transpose();
    // What acts from one tick to the next.
    tau = at;
    tau.rightCols(at.cols() - 1) = 0.5 * (at.rightCols(at.cols() - 1) + at.leftCols(at.cols() - 1));
  }

  [[nodiscard]] std::string ticks() const {
    std::ostringstream out;
    out << std::setprecision(17);
    for (Index k = 0; k < q.cols(); ++k) {
      out << q.col(k).transpose() << '\n' << qd.col(k).transpose() << '\n' << tau.col(k).transpose() << '\n';
    }
    return out.str();
  }
};

// @param lost  ticks that are none
void expect_the_observer_of_the_library(const Scene& scene, int lost) {
  const DynamicModel model(scene.robot, scene.chi_st);
  const test::TemporaryFolder folder;
  folder.write("robot.h", c_header(model, "robot"));
  folder.write("main.c", number_for("F_M", f_m) + number_for("BANDWIDTH", bandwidth) +
                             number_for("SMOOTH", smooth) + program);
  folder.write("ticks.txt", scene.ticks());
  ContactObserver<double> observer(
      model, {.f_m = f_m, .bandwidth = bandwidth, .smoothing_speed = Vector::Constant(joints, smooth)});
  Matrix expected(joints, scene.q.cols());
  for (Index k = 0; k < scene.q.cols(); ++k) {
    observer.update(scene.q.col(k), scene.qd.col(k), scene.tau.col(k));
    expected.col(k) = observer.residual();
  }
  const double size = expected.cwiseAbs().maxCoeff();
  for (const test::Compiler& compiler : test::compilers()) {
    SCOPED_TRACE(compiler.name);
    const std::string printed = compiler.printed(folder);
    std::istringstream in(printed);
    Matrix found(joints, scene.q.cols());
    Vector payload(8);
    Vector rest(joints);
    Eigen::Vector2d taken;
    for (double& value : found.reshaped()) {
      in >> value;
    }
    for (double& value : payload) {
      in >> value;
    }
    for (double& value : rest) {
      in >> value;
    }
    in >> taken[0] >> taken[1];
    ASSERT_TRUE(in);
    EXPECT_EQ(taken, Eigen::Vector2d::Constant(static_cast<double>(scene.q.cols() - lost)));
    // Differences of momenta over a tick carry their rounding f_m times.
    EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-9 * size);
    // Friction is smooth here and sharp in the truth: exact within its tail of tanh(3), 0.5 %, of some newton
    // metres.
    const Eigen::Vector3d com = scene.body.segment<3>(6) / scene.body[9];
    EXPECT_NEAR(payload[0], scene.body[9], 0.02 * scene.body[9]);
    EXPECT_LE((payload.segment<3>(1) - com).cwiseAbs().maxCoeff(), 5e-3);
    EXPECT_GT(payload[4], 0.0);
    EXPECT_LT(payload[4], 0.05);
    EXPECT_GT(payload.tail<3>().minCoeff(), 0.0);
    EXPECT_LT(rest.cwiseAbs().maxCoeff(), 0.1 * size);
  }
}

TEST(COnline, IsTheObserverOfTheLibraryAndFindsThePayload) {
  for (const std::uint64_t seed : {1U, 2U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_the_observer_of_the_library(Scene(seed), 0);
  }
}

TEST(COnline, PassesOverTicksThatAreNoneAsTheLibraryDoes) {
  Scene scene(1);
  scene.tau(3, 0) = scene.tau(2, 3000) = std::numeric_limits<double>::quiet_NaN();
  scene.q(0, 4500) = -std::numeric_limits<double>::infinity();
  scene.qd(4, 4501) = 1e300;
  expect_the_observer_of_the_library(scene, 4);
}

}  // namespace
}  // namespace rivid
