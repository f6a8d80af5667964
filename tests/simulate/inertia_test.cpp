#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "rivid/simulate/design_inertia.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

using test::complaint_of;
using test::says;

// Another algorithm for the same quantity.
constexpr double other_algorithm = 1e-12;

// The eight parameters of [RIV]'s SCARA: ZZ1R Fv1 Fc1 ZZ2R LMX2 LMY2 Fv2 Fc2.
struct Scara {
  Robot robot = test::scara();
  BaseParameters base = base_parameters(robot);

  [[nodiscard]] DynamicModel model(double ZZ1R, double ZZ2R, double LMX2, double LMY2) const {
    constexpr double L = 0.5;
    Vector chi = Vector::Zero(base.size());
    for (Index i = 0; i < base.size(); ++i) {
      const std::string& name = base.parameters[static_cast<std::size_t>(i)].name;
      chi[i] = name == "ZZ1R"  ? ZZ1R
               : name == "ZZ2" ? ZZ2R
               : name == "MX2" ? LMX2 / L
               : name == "MY2" ? LMY2 / L
                               : 0.0;
    }
    return {robot, base, chi};
  }
};

TEST(DesignInertia, OfTheScaraIsThatOfThePaper) {
  const Scara scara;
  const DynamicModel model = scara.model(3.44, 0.062, 0.124, 0.0);
  // M_11 = ZZ1R + ZZ2R + 2 LMX2 cos q2 is largest stretched out.
  const Eigen::Vector2d wanted(3.44 + 0.062 + 2.0 * 0.124, 0.062);
  EXPECT_LT((design_inertia(model) - wanted).norm(), other_algorithm);
  Matrix q = Matrix::Zero(3, 2);
  q.col(1) << 1.0, 0.5, -2.0;
  EXPECT_NEAR(design_inertia(model, q)[0], 3.44 + 0.062 + 2.0 * 0.124 * std::cos(0.5), other_algorithm);
}

TEST(DesignInertia, IsTheLargestDiagonalEntryOfTheMassMatrixOverTheSamples) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    std::mt19937_64 random(seed);
    const Robot robot = test::random_robot(1 + static_cast<int>(seed % 8), random);
    const DynamicModel model(robot, robot.chi_st());
    const Matrix q = test::random_motion(37, robot.size(), random).q;
    Vector wanted = Vector::Zero(robot.size());
    for (Index k = 0; k < q.rows(); ++k) {
      wanted = wanted.cwiseMax(mass_matrix(model, q.row(k).transpose()).diagonal());
    }
    EXPECT_LT((design_inertia(model, q) - wanted).cwiseQuotient(wanted).cwiseAbs().maxCoeff(),
              other_algorithm)
        << "seed " << seed;
  }
}

TEST(DesignInertia, OfBaseParametersAloneIsThatOfTheRobot) {
  std::mt19937_64 random(4);
  const Robot robot = test::random_robot(6, random);
  const BaseParameters base = base_parameters(robot);
  const DynamicModel whole(robot, robot.chi_st());
  const DynamicModel regrouped(robot, base, base.from_standard(robot.chi_st()));
  const Matrix q = test::random_motion(100, 6, random).q;
  const Vector J = design_inertia(whole, q);
  // The regrouping is a least-squares solution.
  EXPECT_LT((design_inertia(regrouped, q) - J).cwiseQuotient(J).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(DesignInertia, OverAllPositionsIsNotExceededAnywhere) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 random(seed);
    Robot robot = test::random_robot(6, random);
    for (Joint& joint : robot.joints) {
      joint.lower = joint.type == JointType::revolute ? -2.0 : -0.3;
      joint.upper = joint.type == JointType::revolute ? 2.5 : 0.4;
    }
    const DynamicModel model(robot, robot.chi_st());
    const Vector J = design_inertia(model);
    Matrix q(20000, 6);
    for (Index j = 0; j < 6; ++j) {
      const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
      std::uniform_real_distribution<double> within(joint.lower, joint.upper);
      q.col(j) = Vector::NullaryExpr(q.rows(), [&] { return within(random); });
    }
    const Vector sampled = design_inertia(model, q);
    EXPECT_TRUE((J.array() >= sampled.array() * (1.0 - other_algorithm)).all()) << "seed " << seed;
    EXPECT_TRUE((J.array() <= sampled.array() * 1.3).all()) << "seed " << seed;
  }
}

TEST(DesignInertia, OverAllPositionsKeepsToTheLimits) {
  Scara scara;
  EXPECT_NEAR(design_inertia(scara.model(3.0, 0.1, 0.3, 0.4))[0], 3.1 + 2.0 * 0.5, other_algorithm);
  scara.robot.joints[1].lower = 1.0;
  scara.robot.joints[1].upper = 2.0;
  const double at_lower = 3.1 + 2.0 * (0.3 * std::cos(1.0) - 0.4 * std::sin(1.0));
  EXPECT_NEAR(design_inertia(scara.model(3.0, 0.1, 0.3, 0.4))[0], at_lower, other_algorithm);
}

TEST(DesignInertia, OfOneJointNeedsNoSearch) {
  const Robot robot = test::slider();
  const BaseParameters base = base_parameters(robot);
  Vector chi = Vector::Zero(base.size());
  chi[0] = 95.1;
  const DynamicModel model(robot, base, chi);
  EXPECT_DOUBLE_EQ(design_inertia(model)[0], 95.1);
  EXPECT_DOUBLE_EQ(design_inertia(model, Matrix::Zero(1, 1))[0], 95.1);
}

TEST(DesignInertia, IsRefusedWhereItIsNotPositive) {
  const Scara scara;
  const DynamicModel model = scara.model(0.1, 0.05, 0.2, 0.0);
  Matrix q = Matrix::Zero(20, 2);
  q(17, 1) = 3.0;
  EXPECT_TRUE(
      says(complaint_of<NumericsError>([&] { static_cast<void>(design_inertia(model, q)); }),
           "design_inertia: M(1,1) of joint \"joint_1\" is -0.246 kg·m² at sample 17, must be positive"));
  EXPECT_TRUE(says(complaint_of<NumericsError>([&] { static_cast<void>(design_inertia(model)); }),
                   "kg·m² at a position within the limits, must be positive"));
  EXPECT_TRUE(says(complaint_of<NumericsError>(
                       [&] { static_cast<void>(design_inertia(scara.model(1.0, 0.0, 0.0, 0.0), q)); }),
                   "M(2,2) of joint \"joint_2\" is 0 kg·m² at sample 0"));
}

TEST(DesignInertia, RefusesPositionsThatDoNotFit) {
  const Scara scara;
  const DynamicModel model = scara.model(3.0, 0.1, 0.3, 0.4);
  EXPECT_TRUE(
      says(complaint_of([&] { static_cast<void>(design_inertia(model, Matrix::Zero(5, 3))); }),
           "design_inertia: q is (5 x 3), must have one row a sample and one column for each of 2 joints"));
  EXPECT_TRUE(
      says(complaint_of([&] { static_cast<void>(design_inertia(model, Matrix::Zero(0, 2))); }), "(0 x 2)"));
  EXPECT_TRUE(says(
      complaint_of([&] { static_cast<void>(design_inertia(model, Matrix::Constant(9, 2, std::nan("")))); }),
      "q must be finite"));
  EXPECT_TRUE(
      says(complaint_of([&] { static_cast<void>(design_inertia(model, InertiaSearch{.samples = 0})); }),
           "samples is 0, must be between 1 and 10000000"));
  EXPECT_TRUE(
      says(complaint_of([&] { static_cast<void>(design_inertia(model, InertiaSearch{.starts = 0})); }),
           "starts is 0"));
  std::mt19937_64 random(1);
  Robot robot = test::random_robot(2, random);
  robot.chain.links[1].type = robot.joints[1].type = JointType::prismatic;
  const DynamicModel sliding(robot, robot.chi_st());
  EXPECT_TRUE(says(complaint_of([&] { static_cast<void>(design_inertia(sliding)); }),
                   "the limits of joint \"joint_2\" are -inf and inf, must be finite and in order"));
}

}  // namespace
}  // namespace rivid
