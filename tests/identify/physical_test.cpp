#include "rivid/identify/physical.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <numbers>
#include <random>

#include "rivid/identify/identification.hpp"
#include "rivid/model/parameters.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"
#include "support/scara_study.hpp"
#include "support/tx40.hpp"

namespace rivid {
namespace {

double value(const BaseParameters& base, const Vector& chi_st, const std::string& name) {
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    if (base.standard[i].name() == name) {
      return chi_st[static_cast<Index>(i)];
    }
  }
  ADD_FAILURE() << "no " << name;
  return 0.0;
}

void expect_bodies(const BaseParameters& base, const Vector& chi_st) {
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    if (base.standard[i].kind == ParameterKind::XX) {
      const Inertial inertial = chi_st.segment<inertial_count>(static_cast<Index>(i));
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(pseudo_inertia(inertial));
      EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.0) << base.standard[i].name();
    }
  }
}

// A robot of physical bodies whose description is its truth, and information on all its base parameters.
class PhysicalOfARandomRobot : public testing::Test {
 protected:
  PhysicalOfARandomRobot() {
    std::mt19937_64 random(71);
    robot_ = test::random_robot(5, random);
    base_ = base_parameters(robot_);
    chi_ = base_.from_standard(robot_.chi_st());
    root_ = 100.0 * Matrix::Identity(base_.size(), base_.size());
  }

  [[nodiscard]] PhysicalParameters found(const Physical& options = {}) const {
    return physical(robot_, base_, chi_, root_, options);
  }
  [[nodiscard]] std::string refusal(const Physical& options) const {
    return test::complaint_of([&] { return found(options); });
  }

  Robot robot_;
  BaseParameters base_;
  Vector chi_;
  Matrix root_;
};

TEST_F(PhysicalOfARandomRobot, IsTheDescriptionWhereItExplainsTheData) {
  // The gap of 1e-6 in a cost of order one leaves a thousandth of a standard deviation of the prior.
  constexpr double of_the_gap = 3e-3;
  for (const Physical::Prior prior : {Physical::Prior::log_det, Physical::Prior::ridge}) {
    const PhysicalParameters out = found({.prior = prior});
    EXPECT_TRUE(out.reached);
    EXPECT_LT(out.cost, 2e-6) << name(prior);
    EXPECT_LT((out.chi_st - robot_.chi_st()).norm(), of_the_gap * robot_.chi_st().norm()) << name(prior);
  }
}

TEST_F(PhysicalOfARandomRobot, GivesBackBaseParametersOfAPhysicalRobotWhateverTheDescription) {
  for (Inertial& inertial : robot_.inertials) {
    inertial *= 1.4;
  }
  root_ *= 100.0;
  const PhysicalParameters out = found();
  // The pull of the description, some tens, against 1e8 of the data.
  constexpr double pulled = 1e-4;
  EXPECT_LT((out.chi - chi_).norm(), pulled * chi_.norm());
  EXPECT_EQ(out.chi, base_.from_standard(out.chi_st));
  EXPECT_GT(out.divergence, 0.0);
  EXPECT_NEAR(out.cost, out.distance + out.divergence, 1e-9 * out.cost);
}

TEST_F(PhysicalOfARandomRobot, HasOneAnswerWhereTheDataSayNothingOfSomeParameters) {
  root_ = root_.topRows(base_.size() / 3).eval();
  chi_ *= 1.2;
  std::mt19937_64 random(72);
  std::normal_distribution<double> normal;
  Physical options;
  options.tolerance = 1e-9;
  const PhysicalParameters first = found(options);
  EXPECT_TRUE(first.reached);
  for (int start = 0; start < 3; ++start) {
    options.start = Vector::NullaryExpr(first.chi_st.size(), [&] { return normal(random); });
    const PhysicalParameters other = found(options);
    // A gap of 1e-9 in the cost leaves its root in the parameters.
    EXPECT_LT((other.chi_st - first.chi_st).norm(), 1e-4 * first.chi_st.norm()) << "start " << start;
  }
}

// Bodies that are off by 15 %, and data that tell a part of the base parameters: what is open of the others.
TEST_F(PhysicalOfARandomRobot, KnowsHowFarTheDescriptionIsOff) {
  std::mt19937_64 random(73);
  std::normal_distribution<double> normal;
  const Robot description = robot_;
  const Index told = base_.size() / 2;
  root_.bottomRows(base_.size() - told).setZero();
  constexpr double off = 0.15;
  constexpr int draws = 120;
  double squares = 0.0;
  double count = 0.0;
  for (int draw = 0; draw < draws; ++draw) {
    robot_ = description;
    for (Inertial& inertial : robot_.inertials) {
      const Eigen::LLT<Eigen::Matrix4d> factor(pseudo_inertia(inertial));
      Eigen::Matrix4d change = Eigen::Matrix4d::NullaryExpr([&] { return normal(random); });
      change = 0.5 * off * std::numbers::sqrt2 * (change + change.transpose().eval());
      const Eigen::Matrix4d L = factor.matrixL();
      inertial = inertial_from_pseudo_inertia(L * (Eigen::Matrix4d::Identity() + change) * L.transpose());
    }
    const Vector truth = base_.from_standard(robot_.chi_st());
    robot_ = description;
    const Vector noise = Vector::NullaryExpr(told, [&] { return normal(random); });
    chi_ = truth;
    chi_.head(told) += noise / root_(0, 0);
    const PhysicalParameters answer = found();
    const Vector error = answer.chi - truth;
    const Matrix& C = answer.C_prior;
    for (Index i = told; i < base_.size(); ++i) {
      if (base_.parameters[static_cast<std::size_t>(i)].leading.kind <= ParameterKind::M) {
        squares += error[i] * error[i] / C(i, i);
        ++count;
      }
    }
  }
  ASSERT_GT(count, 5 * draws);
  EXPECT_NEAR(std::sqrt(squares / count), 1.0, 0.3);
}

TEST_F(PhysicalOfARandomRobot, BrakesAndHasNoNegativeRotors) {
  for (Index i = 0; i < base_.size(); ++i) {
    if (base_.parameters[static_cast<std::size_t>(i)].leading.kind >= ParameterKind::Ia) {
      chi_[i] = -1.0;
    }
  }
  const PhysicalParameters out = found();
  for (std::size_t i = 0; i < base_.standard.size(); ++i) {
    const ParameterKind kind = base_.standard[i].kind;
    if (kind > ParameterKind::M && kind != ParameterKind::off) {
      EXPECT_GT(out.chi_st[static_cast<Index>(i)], 0.0) << base_.standard[i].name();
    }
    if (kind == ParameterKind::off) {
      EXPECT_NEAR(out.chi_st[static_cast<Index>(i)], -1.0, 1e-3) << "an offset has either sign";
    }
  }
  expect_bodies(base_, out.chi_st);
}

TEST_F(PhysicalOfARandomRobot, KeepsMassesWithinTheirBounds) {
  const double total = [&] {
    double sum = 0.0;
    for (const Inertial& inertial : robot_.inertials) {
      sum += inertial[9];
    }
    return sum;
  }();
  Physical options{.masses = {{"link_2", 0.0, 0.3}, {"link_4", 20.0, 30.0}}};
  options.total_mass = {total + 30.0, total + 40.0};
  for (Joint& joint : robot_.joints) {
    joint.link = "link" + joint.name.substr(joint.name.find('_'));
  }
  const PhysicalParameters out = found(options);
  EXPECT_TRUE(out.reached);
  EXPECT_LT(value(base_, out.chi_st, "M2"), 0.3);
  EXPECT_GT(value(base_, out.chi_st, "M4"), 20.0);
  double sum = 0.0;
  for (const char* mass : {"M1", "M2", "M3", "M4", "M5"}) {
    sum += value(base_, out.chi_st, mass);
  }
  EXPECT_GT(sum, total + 30.0);
  expect_bodies(base_, out.chi_st);
}

TEST_F(PhysicalOfARandomRobot, PutsABodyWhereTheDescriptionHasNone) {
  robot_.joints[1].link = "forearm";
  robot_.joints[3].link = "flange";
  robot_.inertials[1].setZero();
  robot_.inertials[3].head<6>().setZero();
  const PhysicalParameters out = found();
  ASSERT_EQ(out.notes.size(), 2U);
  EXPECT_NE(out.notes[0].find("link \"forearm\" has no mass"), std::string::npos) << out.notes[0];
  EXPECT_NE(out.notes[1].find("link \"flange\" has an inertia tensor that belongs to no extended body"),
            std::string::npos)
      << out.notes[1];
  EXPECT_TRUE(out.reached);
  expect_bodies(base_, out.chi_st);
}

TEST_F(PhysicalOfARandomRobot, RefusesWhatItCanNotUse) {
  robot_.joints[0].link = "shoulder";
  EXPECT_EQ(refusal({.weight = 0.0}), "physical: weight is 0, must be positive");
  EXPECT_NE(refusal({.masses = {{"shulder", 1.0, 2.0}}}).find("did you mean \"shoulder\"?"),
            std::string::npos);
  EXPECT_NE(refusal({.masses = {{"shoulder", 2.0, 1.0}}}).find("masses of link \"shoulder\": 2 to 1 kg"),
            std::string::npos);
  EXPECT_NE(
      refusal({.masses = {{"shoulder", 5.0, 9.0}}, .total_mass = {{1.0, 4.0}}}).find("can not be reached"),
      std::string::npos);
  EXPECT_NE(refusal({.start = Vector::Zero(3)}).find("start has 3 values"), std::string::npos);
  chi_.resize(2);
  EXPECT_NE(refusal({}).find("chi has 2 values"), std::string::npos);
}

TEST(PhysicalOfACoupledRobot, LeavesRotorsNoLessThanTheCouplingTakes) {
  Robot robot = test::tx40(Friction::coulomb);
  robot.couplings = {test::tx40_wrist()};
  std::mt19937_64 random(73);
  for (Inertial& inertial : robot.inertials) {
    inertial = test::random_inertial(random);
  }
  const BaseParameters base = base_parameters(robot);
  Vector chi_st = robot.chi_st();
  for (std::size_t i = 0; i < base.standard.size(); ++i) {
    const ParameterKind kind = base.standard[i].kind;
    if (kind > ParameterKind::M) {
      // The estimate has more of the coupling than the rotors and the viscous friction of the joints allow.
      chi_st[static_cast<Index>(i)] = kind == ParameterKind::Iam || kind == ParameterKind::Fvm ? 0.5 : 0.2;
    }
  }
  const Matrix root = 10.0 * Matrix::Identity(base.size(), base.size());
  const PhysicalParameters out = physical(robot, base, base.from_standard(chi_st), root);
  EXPECT_TRUE(out.reached);
  for (const char* joint : {"5", "6"}) {
    EXPECT_GE(value(base, out.chi_st, std::string("Ia") + joint), value(base, out.chi_st, "Iam6"));
    EXPECT_GE(value(base, out.chi_st, std::string("Fv") + joint), value(base, out.chi_st, "Fvm6"));
  }
  EXPECT_GT(value(base, out.chi_st, "Fcm6"), 0.0);
}

TEST(PhysicalOfAsymmetricFriction, BrakesOnTheMeanOfBothDirections) {
  const Robot slider = test::slider(Friction::asymmetric);
  const BaseParameters base = base_parameters(slider);
  ASSERT_EQ(base.size(), 5);
  // M, Fv+, Fc+, Fv-, Fc-: an offset of 2 with a friction of 1; then one that drives.
  const Matrix root = 100.0 * Matrix::Identity(5, 5);
  const PhysicalParameters shifted = physical(slider, base, (Vector(5) << 3, 1, 3, 1, -1).finished(), root);
  EXPECT_NEAR(value(base, shifted.chi_st, "Fc-1"), -1.0, 1e-3);
  const PhysicalParameters driving = physical(slider, base, (Vector(5) << 3, 1, 1, 1, -3).finished(), root);
  EXPECT_NEAR(value(base, driving.chi_st, "Fc+1"), 2.0, 1e-2);
  EXPECT_NEAR(value(base, driving.chi_st, "Fc-1"), -2.0, 1e-2);
}

TEST(PhysicalModel, IsCarriedByEveryMethodBesideThePlainEstimate) {
  test::ScaraStudy scara;
  const Log log = scara.log(2.0, 5);
  const SignalOptions signal = test::ScaraStudy::filtered();
  Estimation iv = scara.iv();
  iv.signal = signal;
  const auto both = [&](Estimation method) {
    const Identification plain = identify(scara.robot, log, method);
    EXPECT_FALSE(plain.physical);
    method.physical = Physical{};
    Identification found = identify(scara.robot, log, method);
    EXPECT_EQ(found.chi, plain.chi) << found.title;
    return found;
  };
  for (const Identification& found :
       {both({.method = Ols{}, .signal = signal}), both({.method = Wls{}, .signal = signal}), both(iv)}) {
    ASSERT_TRUE(found.physical) << found.title;
    EXPECT_TRUE(found.physical->parameters.reached);
    EXPECT_EQ(found.physical->fit.rows, found.fit.rows);
    EXPECT_EQ(found.physical->fit.joints.size(), 2U);
    // Bodies of a kilogram that nobody described hold nothing back.
    EXPECT_LT(found.physical->fit.relative_error, 1.05 * found.fit.relative_error) << found.title;
    const Validation other = validate(scara.robot, found, scara.log(2.0, 6));
    ASSERT_TRUE(other.physical);
    EXPECT_NEAR(other.physical->relative_error, other.fit.relative_error, 0.1 * other.fit.relative_error);
  }
}

TEST(PhysicalModel, IsWhatAWarningOfWeakExcitationAsksFor) {
  test::ScaraStudy scara;
  Log log = scara.log(2.0, 5);
  const auto warnings_of_weakness = [&](const Identification& found) {
    return std::ranges::count_if(found.warnings, [](const Finding& warning) {
      return warning.code == "weak_excitation" &&
             warning.text.find("the data hardly distinguish") != std::string::npos;
    });
  };
  Estimation method{.method = Ols{}, .signal = test::ScaraStudy::filtered()};
  EXPECT_EQ(warnings_of_weakness(identify(scara.robot, log, method)), 0);
  // Joint 2 hardly moves against joint 1: its own inertia and that which it carries look alike.
  log.q.col(1) = 0.005 * log.q.col(1).array() + 0.1;
  const Identification weak = identify(scara.robot, log, method);
  ASSERT_EQ(weak.status, Status::identified);
  EXPECT_EQ(warnings_of_weakness(weak), 1);
  method.physical = Physical{};
  const Identification held = identify(scara.robot, log, method);
  EXPECT_EQ(warnings_of_weakness(held), 0);
  ASSERT_TRUE(held.physical);
  EXPECT_TRUE(held.physical->parameters.reached);
}

}  // namespace
}  // namespace rivid
