// BIRDy's TX40 scenario: its own integrator chatters where the motion does not.

#include <gtest/gtest.h>

#include <filesystem>

#include "support/birdy.hpp"

namespace {

using rivid::test::BirdyTx40;

class BirdyLoop : public ::testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::path(RIVID_REAL_DATA).parent_path() / "reference" / "birdy_tx40_trajectory.csv";
    if (!std::filesystem::exists(file_)) {
      GTEST_SKIP() << "no " << file_;
    }
  }

  [[nodiscard]] rivid::Simulation simulation(const rivid::SimulationOptions& options) const {
    const BirdyTx40 scenario;
    const rivid::DynamicModel model(scenario.robot, scenario.robot.chi_st());
    const auto law = scenario.control({scenario.robot, model, {}});
    return rivid::simulate(scenario.robot, model, *law, BirdyTx40::reference(file_.string()), options);
  }

  std::filesystem::path file_;
};

constexpr std::uint64_t seed = 20211;

double reversals(const rivid::Simulation& simulation) {
  return static_cast<double>(rivid::test::sign_changes(simulation.motion.qd.col(5)));
}

// The independent replica counted 749 in the motion that the data are made from. Noise that is fed back adds
// to them.
TEST_F(BirdyLoop, ItsOwnIntegratorChatters) {
  const auto found = simulation(BirdyTx40::with_its_integrator(BirdyTx40::loop(0.0, seed)));
  ASSERT_EQ(found.outcome, rivid::Outcome::completed) << found.reason;
  EXPECT_NEAR(reversals(found), 749.0, 0.1 * 749.0);
  const auto noisy = simulation(BirdyTx40::with_its_integrator(BirdyTx40::loop(BirdyTx40::low_noise, seed)));
  EXPECT_GT(reversals(noisy), reversals(found));
}

TEST_F(BirdyLoop, TheMotionDoesNot) {
  for (const double noise : {0.0, BirdyTx40::low_noise}) {
    const auto found = simulation(BirdyTx40::loop(noise, seed));
    ASSERT_EQ(found.outcome, rivid::Outcome::completed) << found.reason;
    EXPECT_NEAR(reversals(found), 17.0, 2.0) << noise;
  }
}

}  // namespace
