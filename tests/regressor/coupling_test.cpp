#include <gtest/gtest.h>

#include "rivid/regressor/batch.hpp"
#include "support/robots.hpp"
#include "support/tx40.hpp"

namespace rivid {
namespace {

// The same quantity by another summation.
constexpr double rounding = 1e-12;

// Torques of standard parameters, (n_m × n).
Matrix torques(const Robot& robot, const Motion& motion, const Vector& chi_st) {
  const BaseParameters base = base_parameters(robot);
  return Matrix((observation(robot, base, motion).dense() * base.from_standard(chi_st))
                    .reshaped(motion.samples(), robot.size()));
}

// What a coupling adds to the torques of the robot without it, at values of 1 of its parameters alone.
struct Difference {
  Robot robot;
  Motion motion;
  Matrix tau;
};

Difference difference(const Coupling& coupling, const std::string& parameter) {
  std::mt19937_64 random(11);
  Difference out;
  out.robot = test::tx40(Friction::coulomb);
  out.robot.couplings = {coupling};
  out.motion = test::random_motion(40, 6, random);
  const std::vector<StandardParameter> standard = out.robot.standard_parameters();
  Vector chi_st = Vector::Zero(static_cast<Index>(standard.size()));
  for (std::size_t i = 0; i < standard.size(); ++i) {
    chi_st[static_cast<Index>(i)] = standard[i].name() == parameter ? 1.0 : 0.0;
  }
  out.tau = torques(out.robot, out.motion, chi_st);
  return out;
}

void expect_rows_5_and_6(const Difference& d, const Matrix& expected) {
  EXPECT_LT(d.tau.leftCols(4).cwiseAbs().maxCoeff(), rounding);
  EXPECT_LT((d.tau.rightCols(2) - expected).cwiseAbs().maxCoeff(), rounding);
}

Matrix columns(const Vector& a, const Vector& b) {
  Matrix out(a.size(), 2);
  out << a, b;
  return out;
}

TEST(Coupling, InTheFreeReadingHasThreeColumnsOnBothJoints) {
  const Coupling wrist = test::tx40_wrist();
  const Difference Iam = difference(wrist, "Iam6");
  expect_rows_5_and_6(Iam, columns(Iam.motion.qdd.col(5), Iam.motion.qdd.col(4)));
  const Difference Fvm = difference(wrist, "Fvm6");
  expect_rows_5_and_6(Fvm, columns(Fvm.motion.qd.col(5), Fvm.motion.qd.col(4)));
  const Difference Fcm = difference(wrist, "Fcm6");
  const Vector s = (Fcm.motion.qd.col(4) + Fcm.motion.qd.col(5)).cwiseSign();
  expect_rows_5_and_6(Fcm, columns(s, s));
  const Difference Ia = difference(wrist, "Ia6");
  expect_rows_5_and_6(Ia, columns(Vector::Zero(40), Ia.motion.qdd.col(5)));
}

TEST(Coupling, InTheTiedReadingIsThatOfBirdy) {
  const Coupling wrist = test::tx40_wrist_of_birdy();
  const Difference Ia = difference(wrist, "Ia6");
  expect_rows_5_and_6(Ia, columns(Ia.motion.qdd.col(5), Ia.motion.qdd.col(5) + Ia.motion.qdd.col(4)));
  const Difference Fcm = difference(wrist, "Fcm6");
  expect_rows_5_and_6(Fcm, columns(Fcm.motion.qd.col(5).cwiseSign(), Fcm.motion.qd.col(4).cwiseSign()));
  Coupling whole = wrist;
  whole.terms = Coupling::Terms::all;
  const Difference all = difference(whole, "Ia6");
  const Vector sum = all.motion.qdd.col(4) + all.motion.qdd.col(5);
  expect_rows_5_and_6(all, columns(sum, sum));
}

// Kinetic energy ½ Iam (cᵀ q̇)² and friction of the motor, for any chain, ratios and number of joints.
TEST(Coupling, WithAllTermsIsAMotorAtItsOwnVelocity) {
  for (const std::uint64_t seed : {21U, 22U, 23U}) {
    std::mt19937_64 random(seed);
    Robot robot = test::random_robot(5, random);
    const Motion motion = test::random_motion(30, 5, random);
    const Matrix without = torques(robot, motion, robot.chi_st());
    robot.couplings = {{.motor = 3,
                        .joints = {0, 4},
                        .ratios = {-0.5, 2.0},
                        .terms = Coupling::Terms::all,
                        .Iam = 0.3,
                        .Fvm = 0.7,
                        .Fcm = 1.1}};
    const Vector c = robot.couplings[0].row(5);
    const Vector rate = motion.qd * c;
    const Vector acceleration = motion.qdd * c;
    const Matrix expected =
        without + (0.3 * acceleration + 0.7 * rate + 1.1 * rate.cwiseSign()) * c.transpose();
    const Matrix found = torques(robot, motion, robot.chi_st());
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-11 * expected.cwiseAbs().maxCoeff()) << seed;

    // Cross terms alone, with the diagonal in Ia and Fv, are the same robot.
    robot.couplings[0].terms = Coupling::Terms::cross;
    for (Index j = 0; j < 5; ++j) {
      robot.joints[static_cast<std::size_t>(j)].Ia += 0.3 * c[j] * c[j];
      robot.joints[static_cast<std::size_t>(j)].Fv += 0.7 * c[j] * c[j];
    }
    const Matrix cross = torques(robot, motion, robot.chi_st());
    EXPECT_LT((cross - expected).cwiseAbs().maxCoeff(), 1e-11 * expected.cwiseAbs().maxCoeff()) << seed;
  }
}

TEST(Coupling, WithSingleSignsFollowsTheSignsOfItsRatios) {
  Coupling coupling = test::tx40_wrist_of_birdy();
  coupling.ratios = {-2.0};
  const Difference Fcm = difference(coupling, "Fcm6");
  // Row 5: c5 sign(q̇6); row 6: sign(c5 q̇5).
  expect_rows_5_and_6(Fcm,
                      columns(-2.0 * Fcm.motion.qd.col(5).cwiseSign(), -Fcm.motion.qd.col(4).cwiseSign()));
}

TEST(Coupling, GivesTheTx40ItsPublishedNumbersOfBaseParameters) {
  const auto count = [](Friction friction, std::vector<Coupling> couplings) {
    Robot robot = test::tx40(friction);
    robot.couplings = std::move(couplings);
    const BaseParameters base = base_parameters(robot);
    EXPECT_GT(base.rank_gap(), 1e6);
    EXPECT_EQ(base.doubt(), std::nullopt);
    return base.size();
  };
  EXPECT_EQ(count(Friction::coulomb, {}), 52);
  EXPECT_EQ(count(Friction::coulomb, {test::tx40_wrist_of_birdy()}), 54);
  EXPECT_EQ(count(Friction::symmetric, {test::tx40_wrist_of_birdy()}), 60);
  EXPECT_EQ(count(Friction::symmetric, {test::tx40_wrist()}), 61);
}

TEST(Coupling, IsScannedAfterTheJointsOwnParameters) {
  // A motor whose own terms are modelled as well adds nothing but its cross terms: none of Ia, Fv is
  // regrouped.
  Robot robot = test::tx40(Friction::coulomb);
  robot.couplings = {test::tx40_wrist()};
  robot.couplings[0].terms = Coupling::Terms::all;
  const BaseParameters base = base_parameters(robot);
  EXPECT_EQ(base.size(), 55);
  std::vector<std::string> last;
  for (const BaseParameter& p : std::span(base.parameters).last(6)) {
    last.push_back(p.name);
  }
  EXPECT_EQ(last, (std::vector<std::string>{"Ia6", "Fv6", "Fc6", "Iam6", "Fvm6", "Fcm6"}));
}

}  // namespace
}  // namespace rivid
