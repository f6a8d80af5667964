#include "rivid/identify/standard_near.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "rivid/error.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// A triangular solve with a matrix of some tens of rows.
constexpr double rounding = 1e-12;

TEST(StandardNear, HasTheBaseParametersAskedFor) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Robot robot = test::random_robot(static_cast<int>(1 + seed % 7), random);
    const BaseParameters base = base_parameters(robot);
    std::normal_distribution<double> normal;
    const Vector chi = base.from_standard(robot.chi_st()) +
                       0.1 * Vector::NullaryExpr(base.size(), [&] { return normal(random); });
    const Vector found = standard_near(robot, base, chi);
    EXPECT_LE((base.from_standard(found) - chi).norm(), rounding * chi.norm());
  }
}

TEST(StandardNear, LeavesTheRobotAloneWhereItHasTheseBaseParameters) {
  std::mt19937_64 random(3);
  const Robot robot = test::random_robot(6, random);
  const BaseParameters base = base_parameters(robot);
  const Vector found = standard_near(robot, base, base.from_standard(robot.chi_st()));
  EXPECT_LE((found - robot.chi_st()).cwiseAbs().maxCoeff(), rounding * robot.chi_st().cwiseAbs().maxCoeff());
}

// What is left to choose, along the null space of the base parameters, makes any change of the least one longer.
TEST(StandardNear, TakesTheSmallestChange) {
  std::mt19937_64 random(4);
  Robot robot = test::scara();
  robot.inertials[0] = inertial_from_com(4.0, {0.0, 0.0, 0.0}, 0.04 * Eigen::Matrix3d::Identity());
  robot.inertials[1] = robot.inertials[0];
  robot.chain.gravity.setZero();
  const BaseParameters base = base_parameters(robot);
  Vector chi = base.from_standard(robot.chi_st());
  chi[0] += 1.0;  // ZZ1R = ZZ1 + Ia1 + L² M2
  const Vector change = standard_near(robot, base, chi) - robot.chi_st();
  // One mass and one radius of gyration for both links: ∫ r² dm = 0.06 kg·m² is 4 kg times L_g².
  const double inertia = 0.06;
  const double mass = 4.0;
  const double all = 2.0 * inertia * inertia + std::pow(0.25 * mass, 2);
  for (Index i = 0; i < change.size(); ++i) {
    const std::string name = base.standard[static_cast<std::size_t>(i)].name();
    const double expected = name == "ZZ1" || name == "Ia1" ? inertia * inertia / all
                            : name == "M2"                 ? 0.25 * mass * mass / all
                                                           : 0.0;
    EXPECT_NEAR(change[i], expected, rounding) << name;
  }
}

TEST(StandardNear, RefusesWhatItCanNotUse) {
  std::mt19937_64 random(5);
  const Robot robot = test::random_robot(2, random);
  const Robot other = test::random_robot(3, random);
  const BaseParameters base = base_parameters(robot);
  const Vector chi = Vector::Ones(base.size());
  const auto message = [&](const Robot& of, const Vector& values) -> std::string {
    try {
      static_cast<void>(standard_near(of, base, values));
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(message(other, chi).find("those of another robot than \"random_3\""), std::string::npos);
  EXPECT_NE(message(robot, Vector::Ones(1)).find("chi has 1 values"), std::string::npos);
  Vector holed = chi;
  holed[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message(robot, holed).find(base.parameters[0].name + " is nan, must be finite"),
            std::string::npos);
}

}  // namespace
}  // namespace rivid
