#include <gtest/gtest.h>

#include "rivid/model/robot.hpp"
#include "support/robots.hpp"
#include "support/tx40.hpp"

namespace rivid {
namespace {

std::vector<std::string> names(const Robot& robot) {
  std::vector<std::string> out;
  for (const StandardParameter& p : robot.standard_parameters()) {
    out.push_back(p.name());
  }
  return out;
}

Robot coupled(const Coupling& coupling) {
  Robot robot = test::tx40(Friction::coulomb);
  robot.couplings = {coupling};
  return robot;
}

void expect_complaint(const Robot& robot, const std::string& words) {
  const auto complaint = robot.complaint();
  ASSERT_TRUE(complaint.has_value()) << words;
  EXPECT_NE(complaint->find(words), std::string::npos) << *complaint;
}

TEST(Coupling, AddsItsParametersBehindThoseOfItsMotorsJoint) {
  Coupling coupling = test::tx40_wrist();
  coupling.motor = 4;
  coupling.joints = {3};
  coupling.Iam = 0.1;
  coupling.Fvm = 0.2;
  coupling.Fcm = 0.3;
  const Robot robot = coupled(coupling);
  const std::vector<std::string> all = names(robot);
  ASSERT_EQ(all.size(), 81U);
  EXPECT_EQ((std::vector<std::string>(all.begin() + 62, all.begin() + 69)),
            (std::vector<std::string>{"Ia5", "Fv5", "Fc5", "Iam5", "Fvm5", "Fcm5", "XX6"}));
  EXPECT_EQ(Vector(robot.chi_st().segment(65, 3)), Vector(Eigen::Vector3d(0.1, 0.2, 0.3)));
  EXPECT_EQ(unit(ParameterKind::Iam, JointType::revolute), "kg·m²");
  EXPECT_EQ(unit(ParameterKind::Fvm, JointType::revolute), "N·m·s/rad");
  EXPECT_EQ(unit(ParameterKind::Fcm, JointType::prismatic), "N");
}

TEST(Coupling, ThatIsTiedHasNoInertiaOfItsOwn) {
  EXPECT_EQ(names(coupled(test::tx40_wrist_of_birdy())).size(), 80U);
}

TEST(Coupling, MatrixHasTheRatiosOffTheDiagonal) {
  Matrix expected = Matrix::Identity(3, 3);
  expected(2, 0) = 0.5;
  expected(2, 1) = -2.0;
  const Coupling coupling{.motor = 2, .joints = {0, 1}, .ratios = {0.5, -2.0}};
  EXPECT_EQ(coupling_matrix(std::span(&coupling, 1), 3), expected);
}

TEST(Coupling, ThatCanNotBeIsRefused) {
  Coupling coupling = test::tx40_wrist();
  coupling.motor = 6;
  expect_complaint(coupled(coupling), "coupling: motor is joint 7 of 6");
  coupling = test::tx40_wrist();
  coupling.joints = {9};
  expect_complaint(coupled(coupling), "coupling of motor \"joint_6\": it is turned by joint 10 of 6");
  coupling.joints = {5};
  expect_complaint(coupled(coupling), "joint \"joint_6\" is named twice");
  coupling.joints = {4, 4};
  expect_complaint(coupled(coupling), "it has 1 ratios for 2 joints");
  coupling.ratios = {1.0, 1.0};
  expect_complaint(coupled(coupling), "joint \"joint_5\" is named twice");
  coupling.joints = {};
  expect_complaint(coupled(coupling), "it names no other joint");
  coupling = test::tx40_wrist();
  coupling.ratios = {0.0};
  expect_complaint(coupled(coupling), "the ratio of joint \"joint_5\" is 0, must be finite and not zero");
  coupling = test::tx40_wrist();
  coupling.Fcm = std::numeric_limits<double>::quiet_NaN();
  expect_complaint(coupled(coupling), "Iam, Fvm and Fcm must be finite");
  coupling = test::tx40_wrist();
  coupling.inertia = Coupling::Inertia::none;
  coupling.viscous = false;
  coupling.coulomb = Coupling::Coulomb::none;
  expect_complaint(coupled(coupling), "it has no parameter");
}

TEST(Coupling, LeavesTheDiagonalToParametersThatMustBeThere) {
  Robot robot = coupled(test::tx40_wrist());
  robot.joints[4].rotor_inertia = false;
  expect_complaint(robot,
                   "joint \"joint_5\" has no Ia, which the coupling leaves the joint's own share to: give it "
                   "rotor_inertia, or terms = \"all\"");
  robot.couplings[0].terms = Coupling::Terms::all;
  EXPECT_EQ(robot.complaint(), std::nullopt);
  robot.couplings[0].inertia = Coupling::Inertia::tied;
  robot.joints[5].rotor_inertia = false;
  expect_complaint(robot, "joint \"joint_6\" has no Ia that the coupled inertia could be tied to");
  robot = coupled(test::tx40_wrist());
  robot.joints[5].friction = Friction::none;
  expect_complaint(robot, "joint \"joint_6\" has no Fv");
  robot = coupled(test::tx40_wrist_of_birdy());
  robot.joints[5].friction = Friction::viscous;
  expect_complaint(robot, "joint \"joint_6\" has no Fc");
}

TEST(Coupling, OfTwoMotorsByTheSameJointsIsRefusedUnlessTheyCanBeToldApart) {
  Robot robot = coupled(test::tx40_wrist());
  robot.couplings.push_back(test::tx40_wrist());
  expect_complaint(robot, "coupling of motor \"joint_6\": the motor is described twice");
  robot.couplings[1] = {.motor = 4, .joints = {5}, .ratios = {-1.0}};
  expect_complaint(robot, "coupling of motor \"joint_5\": Iam5 moves the robot just as Iam6 does");
  // A differential: q̇5 + q̇6 and q̇5 − q̇6.
  robot.couplings[0].terms = robot.couplings[1].terms = Coupling::Terms::all;
  EXPECT_EQ(robot.complaint(), std::nullopt);
}

TEST(Coupling, OfMotorsThatTurnAlikeIsRefused) {
  Robot robot = coupled(test::tx40_wrist());
  robot.couplings = {{.motor = 3, .joints = {4}, .ratios = {1.0}},
                     {.motor = 4, .joints = {5}, .ratios = {1.0}},
                     {.motor = 5, .joints = {3}, .ratios = {-1.0}}};
  // q̇4 + q̇5, q̇5 + q̇6 and q̇6 − q̇4: the third is the second less the first.
  expect_complaint(robot, "the matrix from joint to motor velocities is singular, rank 5 of 6");
}

TEST(GearMatrix, TakesThePlaceOfTheGearRatios) {
  Robot robot = test::scara();
  robot.joints[0].gear_ratio = 10.0;
  robot.joints[1].gear_ratio = -5.0;
  EXPECT_EQ(robot.gears(), (Matrix{{10.0, 0.0}, {0.0, -5.0}}));
  robot.joints[0].gear_ratio = robot.joints[1].gear_ratio = 1.0;
  robot.joints[0].drive_gain = 2.0;
  robot.joints[1].drive_gain = 3.0;
  robot.gear_matrix = Matrix{{10.0, 0.0}, {4.0, 5.0}};
  // Motor 2 loads joint 1 as well: τ = Rᵀ diag(drive_gain) v.
  EXPECT_EQ(robot.drive_matrix(), (Matrix{{20.0, 12.0}, {0.0, 15.0}}));
  EXPECT_EQ(robot.complaint(), std::nullopt);
}

TEST(GearMatrix, ThatCanNotBeIsRefused) {
  Robot robot = test::scara();
  robot.gear_matrix = Matrix::Identity(3, 2);
  expect_complaint(robot, "gear_matrix is (3 x 2), must be (2 x 2)");
  robot.gear_matrix = Matrix::Ones(2, 2);
  expect_complaint(robot, "gear_matrix is singular, rank 1 of 2");
  robot.gear_matrix = Matrix{{1.0, std::numeric_limits<double>::infinity()}, {0.0, 1.0}};
  expect_complaint(robot, "gear_matrix must be finite");
  robot.gear_matrix = Matrix::Identity(2, 2);
  robot.joints[1].gear_ratio = 50.0;
  expect_complaint(robot, "joint \"joint_2\": gear_ratio is 50 beside a gear_matrix");
}

}  // namespace
}  // namespace rivid
