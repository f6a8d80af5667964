#include "rivid/export/c_header.hpp"

#include <gtest/gtest.h>

#include <iomanip>
#include <sstream>

#include "rivid/error.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "rivid/simulate/inverse_dynamics.hpp"
#include "support/c_compilers.hpp"
#include "support/robots.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

// The same numbers in another order, relative to the largest torque.
constexpr double tolerance = 1e-12;
constexpr int states = 5;

// Reads states until the end, prints the torques of each function, one line each.
constexpr const char* program = R"(#include <stdio.h>
#include "robot.h"

static void show(const double tau[robot_JOINTS]) {
  int j;
  for (j = 0; j < robot_JOINTS; ++j) {
    printf("%.17g ", tau[j]);
  }
  printf("\n");
}

int main(void) {
  double x[4][robot_JOINTS];
  double tau[robot_JOINTS];
  int k = 0;
  FILE* file = fopen("states.txt", "r");
  while (file != 0 && fscanf(file, "%lf", &x[k / robot_JOINTS][k % robot_JOINTS]) == 1) {
    if (++k == 4 * robot_JOINTS) {
      k = 0;
      robot_inverse_dynamics(x[0], x[1], x[2], tau);
      show(tau);
      robot_rigid_body(x[0], x[1], x[2], tau);
      show(tau);
      robot_gravity(x[0], tau);
      show(tau);
      robot_friction(x[1], 0, tau);
      show(tau);
      robot_friction(x[1], x[3], tau);
      show(tau);
    }
  }
  return 0;
}
)";

// Torques of the compiled header, five lines a state.
Matrix compiled_torques(const test::Compiler& compiler, const test::TemporaryFolder& folder, Index n) {
  const std::string printed = compiler.printed(folder);
  std::istringstream in(printed);
  Matrix out = Matrix::Constant(n, 5 * states, std::nan(""));
  for (double& value : out.reshaped()) {
    in >> value;
  }
  EXPECT_TRUE(in) << printed;
  return out;
}

Vector without_friction(const Robot& robot, Vector chi_st) {
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (is_friction(parameters[i].kind)) {
      chi_st[static_cast<Index>(i)] = 0.0;
    }
  }
  return chi_st;
}

void expect_the_torques_of_the_library(const Robot& robot, std::mt19937_64& random) {
  const Index n = robot.size();
  const Vector chi_st = test::distinct_friction(robot);
  const DynamicModel model(robot, chi_st);
  const DynamicModel rigid(robot, without_friction(robot, chi_st));
  const test::TemporaryFolder folder;
  folder.write("robot.h", c_header(model, "robot", "a test */ \n"));
  folder.write("main.c", program);
  std::ostringstream text;
  text << std::setprecision(17);
  Matrix expected(n, 5 * states);
  for (int k = 0; k < states; ++k) {
    const Motion motion = test::random_motion(1, n, random);
    const Vector q = motion.q.transpose();
    const Vector qd = motion.qd.transpose();
    const Vector qdd = motion.qdd.transpose();
    const Vector v_s = qd.cwiseAbs();
    text << q.transpose() << '\n'
         << qd.transpose() << '\n'
         << qdd.transpose() << '\n'
         << v_s.transpose() << '\n';
    InverseDynamics sharp(model);
    InverseDynamics smooth(model, {.smoothing_speed = v_s});
    sharp.torque(q, qd, qdd, expected.col(5 * k));
    sharp.gravity(q, expected.col(5 * k + 2));
    sharp.friction(qd, expected.col(5 * k + 3));
    smooth.friction(qd, expected.col(5 * k + 4));
    expected.col(5 * k + 1) = inverse_dynamics(rigid, q, qd, qdd);
  }
  folder.write("states.txt", text.str());
  for (const test::Compiler& compiler : test::compilers()) {
    SCOPED_TRACE(compiler.name);
    const Matrix found = compiled_torques(compiler, folder, n);
    EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), tolerance * expected.cwiseAbs().maxCoeff());
  }
}

TEST(CHeader, GivesTheTorquesOfTheLibraryInEveryLanguage) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    expect_the_torques_of_the_library(test::random_robot(static_cast<int>(2 * seed), random), random);
  }
}

TEST(CHeader, KnowsEveryFrictionLaw) {
  std::mt19937_64 random(8);
  const auto n = static_cast<int>(friction_rows.size());
  Robot robot = test::random_robot(2 * n, random);
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    robot.joints[j].friction = friction_rows[j % friction_rows.size()].law;
    robot.joints[j].sign_speed = j < friction_rows.size() ? 0.0 : 0.4;
  }
  expect_the_torques_of_the_library(robot, random);
}

TEST(CHeader, KnowsAsymmetricFrictionAndCoupledMotors) {
  std::mt19937_64 random(4);
  Robot robot = test::random_robot(3, random);
  robot.joints[0].friction = Friction::asymmetric;
  Coupling coupling;
  coupling.motor = 2;
  coupling.joints = {1};
  coupling.ratios = {-0.5};
  coupling.Iam = 0.2;
  coupling.Fvm = 0.1;
  coupling.Fcm = 0.3;
  robot.couplings = {coupling};
  expect_the_torques_of_the_library(robot, random);
}

TEST(CHeader, KnowsSignsThatWereIdentifiedSmooth) {
  std::mt19937_64 random(7);
  Robot robot = test::random_robot(3, random);
  robot.joints[0].friction = Friction::asymmetric;
  robot.joints[0].sign_speed = 0.7;
  robot.joints[1].sign_speed = 0.3;
  expect_the_torques_of_the_library(robot, random);
}

TEST(CHeader, OfARobotWithoutFrictionCompiles) {
  std::mt19937_64 random(5);
  Robot robot = test::random_robot(1, random);
  robot.joints[0].friction = Friction::none;
  expect_the_torques_of_the_library(robot, random);
}

TEST(CHeader, RefusesANameThatIsNoIdentifier) {
  std::mt19937_64 random(6);
  const Robot robot = test::random_robot(1, random);
  const DynamicModel model(robot, robot.chi_st());
  for (const char* const name : {"", "1st", "my robot", "größe"}) {
    EXPECT_THROW(static_cast<void>(c_header(model, name)), InputError) << name;
  }
  EXPECT_EQ(c_identifier("1 robot.v2"), "_1_robot_v2");
}

}  // namespace
}  // namespace rivid
