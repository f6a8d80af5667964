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

TEST_F(BirdyLoop, ItsOwnIntegratorChatters) {
  const auto found =
      simulation(BirdyTx40::with_its_integrator(BirdyTx40::loop(BirdyTx40::low_noise, seed)));
  ASSERT_EQ(found.outcome, rivid::Outcome::completed) << found.reason;
  EXPECT_NEAR(static_cast<double>(rivid::test::sign_changes(found.motion.qd.col(5))), 749.0, 0.1 * 749.0);
}

TEST_F(BirdyLoop, TheMotionDoesNot) {
  const auto found = simulation(BirdyTx40::loop(BirdyTx40::low_noise, seed));
  ASSERT_EQ(found.outcome, rivid::Outcome::completed) << found.reason;
  EXPECT_NEAR(static_cast<double>(rivid::test::sign_changes(found.motion.qd.col(5))), 17.0, 2.0);
  std::printf("modes %ld rhs %ld steps %ld %.1f ms; reversals", static_cast<long>(found.effort.mode_changes),
              static_cast<long>(found.effort.right_hand_sides), static_cast<long>(found.effort.steps), 1e3 * found.effort.seconds);
  for (int j = 0; j < 6; ++j) std::printf(" %ld", static_cast<long>(rivid::test::sign_changes(found.motion.qd.col(j))));
  std::printf("\n tracking"); 
  for (int j = 0; j < 6; ++j) std::printf(" %g", found.max_tracking_error[j]);
  std::printf("\n");
}

}  // namespace
