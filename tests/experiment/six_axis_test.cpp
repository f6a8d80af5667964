// The arm of data/six_axis is that of BIRDy: its URDF was made from the same tables by other code.

#include <gtest/gtest.h>

#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "support/birdy.hpp"

namespace rivid {
namespace {

const std::filesystem::path folder = std::filesystem::path(RIVID_DATA) / "six_axis";

TEST(SixAxis, HasTheBaseParametersOfTheTx40) {
  const Robot robot = read_experiment(folder / "simulate.toml", Use::simulation).robot;
  const test::BirdyTx40 birdy;
  const BaseParameters base = base_parameters(robot);
  const BaseParameters expected = base_parameters(birdy.robot);
  ASSERT_EQ(base.size(), 52);
  ASSERT_EQ(expected.size(), 52);
  const Vector chi = base.from_standard(robot.chi_st());
  const Vector chi_expected = expected.from_standard(birdy.robot.chi_st());
  constexpr double tolerance = 1e-10;  // twelve digits in the file, sums of some ten kg m²
  for (std::size_t i = 0; i < base.parameters.size(); ++i) {
    EXPECT_EQ(base.parameters[i].name, expected.parameters[i].name);
    EXPECT_NEAR(chi[static_cast<Index>(i)], chi_expected[static_cast<Index>(i)], tolerance)
        << base.parameters[i].name;
  }
}

TEST(SixAxis, ComesOutOfItsLogByInstrumentsThatKnowNothing) {
  MonteCarlo plan = read_monte_carlo(folder / "montecarlo.toml");
  plan.trials.resize(1);
  const MonteCarloRow row = monte_carlo_run(plan, 7).front();
  ASSERT_EQ(row.status, "identified");
  const Vector truth = base_parameters(plan.experiment.robot).from_standard(plan.experiment.robot.chi_st());
  // Of 52 errors in their deviations none is beyond 4.5, of which chance makes one in 3000 logs.
  EXPECT_LE(((row.value - truth).array() / row.sigma.array()).abs().maxCoeff(), 4.5);
}

}  // namespace
}  // namespace rivid
