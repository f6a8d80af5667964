#include "rivid/regressor/base.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "rivid/model/mdh.hpp"
#include "rivid/regressor/batch.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"
#include "support/tx40.hpp"

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
  const BaseParameters base = base_parameters(test::tx40(Friction::coulomb));
  EXPECT_EQ(base.size(), 52) << ::testing::PrintToString(names(base));
  EXPECT_EQ(base_parameters(test::tx40(Friction::symmetric)).size(), 58);
  EXPECT_GT(base.smallest_kept / std::max(base.largest_dropped, 1e-17), 1e6)
      << "the rank decision is not clear";
}

// Closed-form rules of Gautier & Khalil (1990) for a general 6R robot with gravity along the first axis: of
// link 1 ZZ alone, of links 2…6 all but YY, MZ and M.
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

// Franka Panda by the modified Denavit-Hartenberg table of its documentation.
TEST(BaseParameters, OfThePandaAre43InertialOnes) {
  constexpr double quarter = std::numbers::pi / 2.0;
  Robot robot = robot_from(std::vector<MdhRow>{{.alpha = 0.0, .a = 0.0, .d = 0.333},
                                               {.alpha = -quarter, .a = 0.0, .d = 0.0},
                                               {.alpha = quarter, .a = 0.0, .d = 0.316},
                                               {.alpha = quarter, .a = 0.0825, .d = 0.0},
                                               {.alpha = -quarter, .a = -0.0825, .d = 0.384},
                                               {.alpha = quarter, .a = 0.0, .d = 0.0},
                                               {.alpha = quarter, .a = 0.088, .d = 0.0}});
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::none;
    joint.rotor_inertia = false;
  }
  const BaseParameters base = base_parameters(robot);
  EXPECT_EQ(base.size(), 43);
  EXPECT_GT(base.rank_gap(), 1e6);
}

// Torques of all standard parameters, (n_m n).
Vector torques(const Robot& robot, const BaseParameters& base, const Motion& motion, const Vector& chi_st) {
  BaseParameters all = base;
  all.parameters.clear();
  for (const StandardParameter& p : base.standard) {
    all.parameters.push_back({.leading = p, .name = "", .regrouped = "", .unit = ""});
  }
  return observation(robot, all, motion).dense() * chi_st;
}

TEST(BaseParameters, DoNotChangeAlongTheirNullSpaceNorDoTorques) {
  for (const int n : {1, 3, 6, 7}) {
    std::mt19937_64 random(static_cast<std::uint64_t>(200 + n));
    Robot robot = test::random_robot(n, random);
    if (n > 1) {
      robot.couplings = {{.motor = n - 1, .joints = {n - 2}, .ratios = {0.5}}};
    }
    const BaseParameters base = base_parameters(robot);
    const Matrix Z = base.null_space();
    ASSERT_EQ(Z.rows(), static_cast<Index>(base.standard.size()));
    ASSERT_EQ(Z.cols(), Z.rows() - base.size());
    const Vector chi_st = robot.chi_st();
    const Vector elsewhere = chi_st + Z * Vector::LinSpaced(Z.cols(), -1.0, 2.0);
    const double scale = elsewhere.cwiseAbs().maxCoeff();
    EXPECT_LT((base.from_standard(elsewhere) - base.from_standard(chi_st)).cwiseAbs().maxCoeff(),
              rounding * scale);
    const Motion motion = test::random_motion(20, n, random);
    const Vector here = torques(robot, base, motion, chi_st);
    EXPECT_LT((torques(robot, base, motion, elsewhere) - here).norm(), rounding * scale * here.norm())
        << n << " joints, seed " << 200 + n;
    // Every standard vector is its base vector's and a point of the null space.
    Vector dependent(Z.cols());
    for (Index i = 0; i < Z.cols(); ++i) {
      dependent[i] = chi_st[base.dependent[static_cast<std::size_t>(i)]];
    }
    EXPECT_LT((base.to_standard(base.from_standard(chi_st)) + Z * dependent - chi_st).cwiseAbs().maxCoeff(),
              rounding * scale);
  }
}

TEST(BaseParameters, TellWhereTheirNumberIsNotClear) {
  BaseParameters base = base_parameters(test::scara());
  EXPECT_EQ(base.doubt(), std::nullopt);
  base.smallest_kept = 8e-9;
  base.largest_dropped = 1e-10;
  EXPECT_NEAR(base.rank_gap(), 80.0, 1e-9);
  base.weakest_kept = base.leading.front();
  base.strongest_dropped = base.dependent.back();
  const std::string kept = base.standard[static_cast<std::size_t>(base.weakest_kept)].name();
  const std::string dropped = base.standard[static_cast<std::size_t>(base.strongest_dropped)].name();
  EXPECT_EQ(base.doubt(), "the number of base parameters is not clear: of " + kept +
                              ", kept, 8e-09 is independent of the other parameters, of " + dropped +
                              ", regrouped, 1e-10; between the two should lie a factor of 100 at least");
}

// The TX40 with every axis turned by so much.
Robot misaligned_tx40(double angle) {
  Robot robot = test::tx40(Friction::coulomb);
  for (Chain::Link& link : robot.chain.links) {
    link.R = link.R * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
  }
  return robot;
}

TEST(BaseParameters, AreThoseOfTheRobotThoughItsAnglesAreWrittenWithFewDigits) {
  const BaseParameters exact = base_parameters(test::tx40(Friction::coulomb));
  const BaseParameters rounded = base_parameters(misaligned_tx40(1.5708 - (std::numbers::pi / 2)));
  EXPECT_EQ(names(rounded), names(exact));
  EXPECT_EQ(rounded.doubt(), std::nullopt);
  for (Index i = 0; i < exact.size(); ++i) {
    const auto place = static_cast<std::size_t>(i);
    EXPECT_EQ(rounded.parameters[place].regrouped.find("e-0"), std::string::npos)
        << rounded.parameters[place].regrouped;
  }
}

// Seven axes, each a right angle from the one before it but for the digits: what is left of Ia2, projected
// onto the states that were drawn, was a coefficient of 2e-7 of XX7. A rotor of 0.5 kg·m² times that
// outweighs the deviation of a wrist's inertia.
TEST(BaseParameters, DoNotTakeUpTheRoundingOfAnglesThatIsLeftOfARotor) {
  Robot robot = test::tx40(Friction::coulomb);
  robot.chain.links.resize(7);
  robot.joints.resize(7, robot.joints.back());
  robot.inertials.resize(7, robot.inertials.back());
  const std::array<double, 7> turns = {0.0, -1.5708, 1.5708, 1.5708, 1.5708, 1.5708, -1.5708};
  const std::array<Eigen::Vector3d, 7> offsets = {{{0.0, 0.0, 0.267},
                                                   {0.0, 0.0, 0.0},
                                                   {0.0, -0.293, 0.0},
                                                   {0.0525, 0.0, 0.0},
                                                   {0.0775, -0.3425, 0.0},
                                                   {0.0, 0.0, 0.0},
                                                   {0.076, 0.097, 0.0}}};
  for (std::size_t j = 0; j < 7; ++j) {
    robot.joints[j].name = "joint_" + std::to_string(j + 1);
    robot.chain.links[j].R = Eigen::AngleAxisd(turns[j], Eigen::Vector3d::UnitX()).toRotationMatrix();
    robot.chain.links[j].p = offsets[j];
  }
  const BaseParameters base = base_parameters(robot);
  for (Index i = 0; i < base.size(); ++i) {
    for (const auto& [name, coefficient] : base.regrouping(i)) {
      if (name.starts_with("Ia")) {
        EXPECT_NEAR(coefficient, 1.0, 1e-5)
            << base.parameters[static_cast<std::size_t>(i)].name << " " << name;
      }
    }
  }
}

TEST(BaseParameters, AreDoubtedWhereCoarseAnglesTellThemApart) {
  Robot robot = misaligned_tx40(1.57 - (std::numbers::pi / 2));
  const BaseParameters apart = base_parameters(robot);
  EXPECT_GT(apart.size(), 52);
  ASSERT_TRUE(apart.doubt());
  EXPECT_NE(apart.doubt()->find("base_tolerance"), std::string::npos) << *apart.doubt();
  robot.base_tolerance = 1e-2;
  EXPECT_EQ(base_parameters(robot).size(), 52);
}

TEST(BaseParameters, RefuseATolerance) {
  Robot robot = test::scara();
  robot.base_tolerance = 0.0;
  EXPECT_EQ(robot.complaint(), "base_tolerance is 0, must lie between 0 and 1");
}

// Joint 2 stands at q2 while joint 1 moves.
Motion locked_scara(double q2, double encoder_noise = 0.0) {
  std::mt19937_64 random(31);
  Motion motion = test::random_motion(2000, 2, random);
  motion.q.col(1).setConstant(q2);
  motion.qd.col(1) *= encoder_noise;
  motion.qdd.col(1) *= encoder_noise;
  return motion;
}

TEST(BaseParameters, OfAMotionThatExcitesAllAreThoseOfTheRobot) {
  std::mt19937_64 random(32);
  Robot robot = test::random_robot(4, random);
  const BaseParameters structural = base_parameters(robot);
  const BaseParameters seen = base_parameters(robot, test::random_motion(700, 4, random), 1e-9);
  EXPECT_EQ(names(seen), names(structural));
  EXPECT_LT((seen.K - structural.K).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(BaseParameters, OfALockedJointAreFewerAndRegroupMore) {
  const BaseParameters stretched = base_parameters(test::scara(), locked_scara(0.0), 1e-9);
  EXPECT_EQ(names(stretched), (std::vector<std::string>{"ZZ1R", "Fv1", "Fc1", "ZZ2R", "MY2"}));
  EXPECT_EQ(regrouped(stretched, "ZZ1R"), "ZZ1 + Ia1 + 0.5 MX2 + 0.25 M2");
  EXPECT_EQ(regrouped(stretched, "ZZ2R"), "ZZ2 + 0.5 MX2");
  const BaseParameters bent = base_parameters(test::scara(), locked_scara(1.0), 1e-9);
  EXPECT_EQ(names(bent), (std::vector<std::string>{"ZZ1R", "Fv1", "Fc1", "ZZ2R", "MX2R"}));
}

TEST(BaseParameters, OfALockedJointDoNotHoldItsNoise) {
  Robot robot = test::scara();
  robot.joints[0].friction = robot.joints[1].friction = Friction::viscous;
  const BaseParameters found = base_parameters(robot, locked_scara(0.0, 1e-5), 1e-3);
  EXPECT_EQ(names(found), (std::vector<std::string>{"ZZ1R", "Fv1", "ZZ2R", "MY2"}));
  EXPECT_EQ(regrouped(found, "ZZ2R"), "ZZ2 + 0.5 MX2");
  // With a tolerance below the noise, noise is what is seen.
  EXPECT_GT(base_parameters(robot, locked_scara(0.0, 1e-5), 1e-9).size(), 4);
}

TEST(BaseParameters, OfAMotionFitItsObservationMatrix) {
  const Robot robot = test::scara();
  const Motion motion = locked_scara(0.4);
  const BaseParameters seen = base_parameters(robot, motion, 1e-9);
  std::mt19937_64 random(33);
  Robot heavy = robot;
  heavy.inertials = {test::random_inertial(random), test::random_inertial(random)};
  const Vector chi_st = heavy.chi_st();
  const Vector expected = torques(robot, seen, motion, chi_st);
  const Vector found = observation(robot, seen, motion).dense() * seen.from_standard(chi_st);
  EXPECT_LT((found - expected).norm(), rounding * expected.norm());
}

TEST(BaseParameters, OfAMotionThatCanNotBeUsedAreRefused) {
  const auto refused = [](const Motion& motion, double tolerance, const std::string& words) {
    EXPECT_TRUE(test::says(
        test::complaint_of([&] { return base_parameters(test::scara(), motion, tolerance); }), words));
  };
  const Motion motion = locked_scara(0.0);
  refused(motion, 0.0, "tolerance is 0, must lie between 0 and 1");
  refused(motion, std::numeric_limits<double>::quiet_NaN(), "must lie between 0 and 1");
  Motion uneven = motion;
  uneven.qd.conservativeResize(7, 2);
  refused(uneven, 1e-3, "one column for each of the 2 joints and the same number of rows");
  refused(Motion{}, 1e-3, "at least one");
  const Motion rest{Matrix::Zero(3, 2), Matrix::Zero(3, 2), Matrix::Zero(3, 2)};
  refused(rest, 1e-3, "shows no parameter in its torques");
}

TEST(BaseParameters, OfARobotThatCanNotBeUsedAreRefused) {
  Robot robot = test::scara();
  robot.joints[1].drive_gain = 0.0;
  EXPECT_TRUE(test::says(test::complaint_of([&] { return base_parameters(robot); }),
                         "joint \"joint_2\": drive_gain"));
  robot = test::scara();
  robot.joints[0].sign_speed = -0.1;
  EXPECT_EQ(robot.complaint(), "joint \"joint_1\": sign_speed is -0.1, must be finite and not negative");
}

}  // namespace
}  // namespace rivid
