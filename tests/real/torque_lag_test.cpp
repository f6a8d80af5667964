// The lag of the torques in a log that nobody here made: a physics engine tells the torques of the step
// before.

#include <gtest/gtest.h>

#include <algorithm>

#include "rivid/experiment/experiment.hpp"
#include "support/real_experiment.hpp"

namespace {

class LagOfAPhysicsEngine : public rivid::test::RealExperiment {
 protected:
  LagOfAPhysicsEngine() : RealExperiment("ur10_vrep") {}
};

TEST_F(LagOfAPhysicsEngine, IsFoundAndTakenBackTheErrorFalls) {
  rivid::Experiment experiment = this->experiment();
  experiment.estimation.method = rivid::Wls{};
  experiment.estimation.signal = {};
  const rivid::Identification before = run(experiment);
  ASSERT_TRUE(before.diagnostics && before.diagnostics->torque_lag);
  const rivid::TorqueLag lag = *before.diagnostics->torque_lag;
  EXPECT_NEAR(lag.samples, 0.63, 0.1);
  EXPECT_LT(lag.sigma, 0.1);
  EXPECT_TRUE(
      std::ranges::any_of(before.warnings, [](const rivid::Finding& f) { return f.code == "torque_lag"; }));

  experiment.log.torque_lag = lag.samples;
  const rivid::Identification after = run(experiment);
  EXPECT_LT(after.fit.relative_error, 0.7 * before.fit.relative_error);
  ASSERT_TRUE(after.diagnostics && after.diagnostics->torque_lag);
  EXPECT_NEAR(after.diagnostics->torque_lag->samples, 0.0, 0.1);
}

}  // namespace
