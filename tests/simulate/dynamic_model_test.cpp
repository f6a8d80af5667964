#include "rivid/simulate/dynamic_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "rivid/regressor/batch.hpp"
#include "rivid/regressor/load.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"
#include "support/tx40.hpp"

namespace rivid {
namespace {

// The same quantity by another summation, relative to the largest torque.
constexpr double tolerance = 1e-12;

void set(const Robot& robot, Vector& chi_st, const std::string& name, double value) {
  const std::vector<StandardParameter> parameters = robot.standard_parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].name() == name) {
      chi_st[static_cast<Index>(i)] = value;
      return;
    }
  }
  FAIL() << "there is no " << name;
}

// Torques of the regressor, (n_m × n).
Matrix regressor_torques(const Robot& robot, const Vector& chi_st, const Motion& motion) {
  const BaseParameters base = base_parameters(robot);
  const Vector chi = base.from_standard(chi_st);
  return Matrix((observation(robot, at_load(base, chi), motion).dense() * chi)
                    .reshaped(motion.samples(), robot.size()));
}

Matrix model_torques(const DynamicModel& model, const Motion& motion) {
  Matrix out(motion.samples(), model.size());
  for (Index k = 0; k < motion.samples(); ++k) {
    out.row(k) = inverse_dynamics(model, motion.q.row(k).transpose(), motion.qd.row(k).transpose(),
                                  motion.qdd.row(k).transpose())
                     .transpose();
  }
  return out;
}

void expect_regressor_torques(const Robot& robot, const Vector& chi_st, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const Motion motion = test::random_motion(30, robot.size(), random);
  const DynamicModel model(robot, chi_st);
  EXPECT_TRUE(model.clamped().empty());
  const Matrix expected = regressor_torques(robot, chi_st, motion);
  EXPECT_LT((model_torques(model, motion) - expected).cwiseAbs().maxCoeff(),
            tolerance * expected.cwiseAbs().maxCoeff())
      << robot.name << ", seed " << seed;
}

TEST(DynamicModel, HasTheTorquesOfTheRegressorUnderEveryFrictionLaw) {
  for (const FrictionRow& law : friction_rows) {
    SCOPED_TRACE(law.name);
    std::mt19937_64 random(31);
    Robot robot = test::random_robot(6, random);
    for (Joint& joint : robot.joints) {
      joint.friction = law.law;
    }
    robot.joints[2].rotor_inertia = false;
    expect_regressor_torques(robot, test::distinct_friction(robot), 32);
  }
}

TEST(DynamicModel, HasTheTorquesOfTheRegressorWithCoupledMotors) {
  for (const Coupling::Terms terms : {Coupling::Terms::cross, Coupling::Terms::all}) {
    for (Coupling wrist : {test::tx40_wrist(), test::tx40_wrist_of_birdy()}) {
      wrist.terms = terms;
      wrist.ratios = {-0.5};
      Robot robot = test::tx40(Friction::symmetric);
      robot.couplings = {wrist};
      std::mt19937_64 random(33);
      for (Inertial& inertial : robot.inertials) {
        inertial = test::random_inertial(random);
      }
      for (Joint& joint : robot.joints) {
        joint.Ia = 0.7;
      }
      Vector chi_st = test::distinct_friction(robot);
      if (wrist.inertia == Coupling::Inertia::free) {
        set(robot, chi_st, "Iam6", 0.2);
      }
      expect_regressor_torques(robot, chi_st, 34);
      set(robot, chi_st, "Fcm6", wrist.coulomb == Coupling::Coulomb::single ? -0.3 : 0.3);
      expect_regressor_torques(robot, chi_st, 35);
    }
  }
}

TEST(DynamicModel, OfBaseParametersHasTheTorquesOfTheStandardParameters) {
  for (const int n : {1, 3, 7}) {
    std::mt19937_64 random(static_cast<std::uint64_t>(36 + n));
    const Robot robot = test::random_robot(n, random);
    const Motion motion = test::random_motion(20, n, random);
    const BaseParameters base = base_parameters(robot);
    const Matrix expected = model_torques(DynamicModel(robot, robot.chi_st()), motion);
    const DynamicModel model(robot, base, base.from_standard(robot.chi_st()));
    EXPECT_LT((model_torques(model, motion) - expected).cwiseAbs().maxCoeff(),
              1e-10 * expected.cwiseAbs().maxCoeff())
        << n;
  }
}

TEST(DynamicModel, HasOneElementForEachJointThatBrakesAtAll) {
  Robot robot = test::tx40(Friction::symmetric);
  Vector chi_st = robot.chi_st();
  set(robot, chi_st, "Fc2", 1.5);
  set(robot, chi_st, "Fv3", 1.0);
  const DynamicModel model(robot, chi_st);
  ASSERT_EQ(model.dry_friction().size(), 1U);
  const DryFriction& element = model.dry_friction()[0];
  EXPECT_EQ(element.name, robot.joints[1].name);
  EXPECT_EQ(element.direction, Vector(Vector::Unit(6, 1)));
  EXPECT_EQ(element.torque, element.direction);
  EXPECT_EQ(element.Fc_plus, 1.5);
  EXPECT_EQ(element.Fc_minus, 1.5);
  EXPECT_EQ(model.viscous()(2, 2), 1.0);
}

TEST(DynamicModel, HasAnElementForACoupledMotor) {
  Robot robot = test::tx40(Friction::symmetric);
  robot.couplings = {test::tx40_wrist()};
  Vector chi_st = robot.chi_st();
  set(robot, chi_st, "Fcm6", 2.0);
  const DynamicModel model(robot, chi_st);
  ASSERT_EQ(model.dry_friction().size(), 1U);
  EXPECT_EQ(model.dry_friction()[0].direction, robot.couplings[0].row(6));
  EXPECT_EQ(model.dry_friction()[0].torque, robot.couplings[0].row(6));
  EXPECT_EQ(model.dry_friction()[0].Fc_plus, 2.0);
}

TEST(DynamicModel, GivesAnAsymmetricLawWithTheSameCoefficientsTheParametersOfTheSymmetricOne) {
  Robot robot = test::scara();
  robot.joints[0].friction = Friction::asymmetric;
  Vector chi_st = robot.chi_st();
  set(robot, chi_st, "Fv+1", 2.0);
  set(robot, chi_st, "Fv-1", 3.0);
  set(robot, chi_st, "Fc+1", 3.0);
  set(robot, chi_st, "Fc-1", -1.0);
  const DynamicModel model(robot, chi_st);
  ASSERT_EQ(model.dry_friction().size(), 1U);
  const DryFriction& element = model.dry_friction()[0];
  EXPECT_EQ(model.viscous()(0, 0), 2.0);
  EXPECT_EQ(element.viscous(true, 2.0), 0.0);
  EXPECT_EQ(element.viscous(false, -2.0), -2.0);
  EXPECT_EQ(element.Fc_plus, 1.0);
  EXPECT_EQ(element.Fc_minus, 1.0);
  EXPECT_EQ(model.offset()[0], 2.0);
  EXPECT_TRUE(model.clamped().empty());
}

TEST(DynamicModel, NamesTheFrictionThatWouldDrive) {
  Robot robot = test::tx40(Friction::symmetric);
  robot.joints[3].friction = Friction::asymmetric;
  robot.couplings = {test::tx40_wrist()};
  Vector chi_st = robot.chi_st();
  for (const char* const name : {"Fv5", "Fv6"}) {
    set(robot, chi_st, name, 1.0);
  }
  for (const char* const name : {"Fv1", "Fc2", "Fc-4", "Fv+4", "Fcm6"}) {
    set(robot, chi_st, name, -0.5);
  }
  set(robot, chi_st, "Fvm6", 1.5);
  const DynamicModel model(robot, chi_st);
  EXPECT_EQ(model.clamped(),
            (std::vector<std::string>{"Fv1", "Fv+4", "Fv5", "Fv6", "Fvm6", "Fc2", "Fc-4", "Fcm6"}));
  EXPECT_EQ(model.viscous()(0, 0), 0.0);
  // (1 1.5; 1.5 1) without its eigenvalue −0.5.
  EXPECT_LT((model.viscous().bottomRightCorner(2, 2) - Matrix::Constant(2, 2, 1.25)).cwiseAbs().maxCoeff(),
            1e-14);
  EXPECT_EQ(model.dry_friction().size(), 1U) << "Fv-4 − Fv+4 is left";
}

TEST(DynamicModel, RefusesWhatDoesNotFit) {
  const Robot robot = test::scara();
  const Vector chi_st = robot.chi_st();
  EXPECT_EQ(test::complaint_of([&] { return DynamicModel(robot, chi_st.head(3)); }),
            "DynamicModel: chi_st has 3 values, the robot has 25 standard parameters");
  Vector spoiled = chi_st;
  set(robot, spoiled, "ZZ2", std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(test::complaint_of([&] { return DynamicModel(robot, spoiled); }),
            "DynamicModel: ZZ2 is nan, must be finite");
  const Robot other = test::slider();
  EXPECT_NE(test::complaint_of([&] {
              return DynamicModel(other, base_parameters(robot), Vector::Zero(8));
            }).find("base parameters are those of another robot"),
            std::string::npos);
  Robot coupled = test::tx40(Friction::asymmetric);
  coupled.couplings = {test::tx40_wrist_of_birdy()};
  Vector chi_coupled = coupled.chi_st();
  set(coupled, chi_coupled, "Fcm6", 1.0);
  EXPECT_NE(
      test::complaint_of([&] { return DynamicModel(coupled, chi_coupled); }).find("has asymmetric friction"),
      std::string::npos);
}

}  // namespace
}  // namespace rivid
