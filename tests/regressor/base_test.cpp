#include "rivid/regressor/base.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "rivid/error.hpp"
#include "rivid/model/mdh.hpp"
#include "rivid/regressor/observation.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// The same quantity by another summation: entries of some tens, sums over up to 14 n terms.
constexpr double rounding = 1e-11;

std::vector<std::string> names(const BaseParameters& base) {
  std::vector<std::string> out;
  for (const BaseParameter& p : base.parameters) {
    out.push_back(p.name);
  }
  return out;
}

std::string regrouped(const BaseParameters& base, const std::string& name) {
  for (const BaseParameter& p : base.parameters) {
    if (p.name == name) {
      return p.regrouped;
    }
  }
  return "none of that name";
}

// Staubli TX40 by its modified Denavit-Hartenberg table (BIRDy, TX40.m).
Robot tx40(Friction friction) {
  constexpr double quarter = std::numbers::pi / 2.0;
  const std::vector<MdhRow> table = {{.alpha = 0.0, .a = 0.0, .d = 0.32, .theta = 0.0},
                                     {.alpha = -quarter, .a = 0.0, .d = 0.0, .theta = -quarter},
                                     {.alpha = 0.0, .a = 0.225, .d = 0.035, .theta = quarter},
                                     {.alpha = quarter, .a = 0.0, .d = 0.225, .theta = 0.0},
                                     {.alpha = -quarter, .a = 0.0, .d = 0.0, .theta = 0.0},
                                     {.alpha = quarter, .a = 0.0, .d = 0.0, .theta = 0.0}};
  Robot robot = robot_from(table);
  for (Joint& joint : robot.joints) {
    joint.friction = friction;
  }
  return robot;
}

TEST(BaseParameters, OfTheScaraAreTheEightOfThePaperWithTheirRegrouping) {
  const BaseParameters base = base_parameters(test::scara());
  EXPECT_EQ(names(base), (std::vector<std::string>{"ZZ1R", "Fv1", "Fc1", "ZZ2", "MX2", "MY2", "Fv2", "Fc2"}));
  EXPECT_EQ(regrouped(base, "ZZ1R"), "ZZ1 + Ia1 + 0.25 M2");
  EXPECT_EQ(base.parameters[0].unit, "kg·m²");
  EXPECT_EQ(base.parameters[1].unit, "N·m·s/rad");
}

TEST(BaseParameters, OfASliderAreMassAndFriction) {
  EXPECT_EQ(names(base_parameters(test::slider())), (std::vector<std::string>{"M1", "Fv1", "Fc1", "off1"}));
  const BaseParameters asymmetric = base_parameters(test::slider(Friction::asymmetric, true));
  EXPECT_EQ(names(asymmetric), (std::vector<std::string>{"M1R", "Fv+1", "Fc+1", "Fv-1", "Fc-1"}));
  EXPECT_EQ(regrouped(asymmetric, "M1R"), "M1 + Ia1");
  EXPECT_EQ(asymmetric.parameters[1].unit, "N·s/m");
}

TEST(BaseParameters, OfTheTx40Are52WithTwoFrictionParametersAJointAnd58WithOffsets) {
  const BaseParameters base = base_parameters(tx40(Friction::coulomb));
  EXPECT_EQ(base.size(), 52) << ::testing::PrintToString(names(base));
  EXPECT_EQ(base_parameters(tx40(Friction::symmetric)).size(), 58);
  EXPECT_GT(base.smallest_kept / std::max(base.largest_dropped, 1e-17), 1e6)
      << "the rank decision is not clear";
}

// Closed-form rules of Gautier & Khalil (1990) for a general 6R robot with gravity along the first axis: of link 1
// ZZ alone, of links 2…6 all but YY, MZ and M.
TEST(BaseParameters, OfAGeneralSixRevoluteArmAreThoseOfTheClosedFormRules) {
  std::mt19937_64 random(7);
  Robot robot = test::random_robot(6, random);
  for (std::size_t j = 0; j < 6; ++j) {
    robot.chain.links[j].type = robot.joints[j].type = JointType::revolute;
    robot.chain.links[j].axes = {0, 1, 2};
    robot.chain.links[j].signs = {1, 1, 1};
    robot.joints[j].rotor_inertia = false;
    robot.joints[j].friction = Friction::none;
  }
  robot.chain.links[0].R.setIdentity();
  robot.chain.gravity = {0.0, 0.0, -9.81};
  std::vector<std::string> expected = {"ZZ1R"};
  for (int j = 2; j <= 6; ++j) {
    for (const char* const symbol : {"XX", "XY", "XZ", "YZ", "ZZ", "MX", "MY"}) {
      expected.push_back(symbol + std::to_string(j));
    }
  }
  std::vector<std::string> found;
  for (const BaseParameter& p : base_parameters(robot).parameters) {
    found.push_back(p.leading.name());
  }
  expected[0] = "ZZ1";
  EXPECT_EQ(found, expected);
}

TEST(BaseParameters, GiveTheTorquesOfTheStandardParameters) {
  for (const int n : {1, 2, 3, 6, 9, 12}) {
    std::mt19937_64 random(static_cast<std::uint64_t>(100 + n));
    const Robot robot = test::random_robot(n, random);
    const BaseParameters base = base_parameters(robot);
    const Motion motion = test::random_motion(20, n, random);
    const Vector chi_st = robot.chi_st();
    const Vector chi = base.from_standard(chi_st);

    // The observation matrix of all standard parameters is that of a base without regrouping.
    BaseParameters all = base;
    all.parameters.clear();
    for (const StandardParameter& p : base.standard) {
      all.parameters.push_back({.leading = p, .name = "", .regrouped = "", .unit = ""});
    }
    const Vector standard = observation(robot, all, motion).dense() * chi_st;
    const Vector reduced = observation(robot, base, motion).dense() * chi;
    EXPECT_LT((standard - reduced).norm(), rounding * standard.norm()) << n << " joints, seed " << 100 + n;
    const Vector back = observation(robot, all, motion).dense() * base.to_standard(chi);
    EXPECT_LT((standard - back).norm(), rounding * standard.norm()) << n << " joints, seed " << 100 + n;
  }
}

TEST(BaseParameters, NameTheParametersByTheAxesOfTheLinkFrame) {
  Robot robot = test::scara();
  for (Chain::Link& link : robot.chain.links) {
    link.axes = {1, 2,
                 0};  // x of the link is y of the frame, y is z: both joints turn about their link's y axis
  }
  EXPECT_EQ(names(base_parameters(robot)),
            (std::vector<std::string>{"YY1R", "Fv1", "Fc1", "YY2", "MX2", "MZ2", "Fv2", "Fc2"}));
}

TEST(BaseParameters, OfARobotThatCanNotBeUsedAreRefused) {
  Robot robot = test::scara();
  robot.joints[1].drive_gain = 0.0;
  try {
    (void)base_parameters(robot);
    FAIL() << "a drive gain of zero was accepted";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("joint \"joint_2\": drive_gain"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace rivid
