// A torso with two arms, simulated in its closed loop and identified as one robot.

#include <gtest/gtest.h>

#include <cmath>

#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/export/urdf.hpp"
#include "support/temporary_folder.hpp"
#include "support/two_arms.hpp"
#include "support/written_urdf.hpp"

namespace rivid {
namespace {

constexpr std::string_view study = R"(
[robot]
urdf = "two_arms.urdf"
moving = ["waist", "left_shoulder", "left_elbow", "left_wrist", "right_shoulder", "right_elbow", "right_wrist"]
friction = "coulomb"
joints.waist = { Ia = 0.5, Fv = 3.0, Fc = 4.0 }
joints.left_shoulder = { Ia = 0.2, Fv = 2.0, Fc = 3.0 }
joints.right_shoulder = { Ia = 0.2, Fv = 2.0, Fc = 3.0 }
joints.left_elbow = { Ia = 0.1, Fv = 1.0, Fc = 1.5 }
joints.right_elbow = { Ia = 0.1, Fv = 1.0, Fc = 1.5 }
joints.left_wrist = { Ia = 0.05, Fv = 0.5, Fc = 0.8 }
joints.right_wrist = { Ia = 0.05, Fv = 0.5, Fc = 0.8 }

[control]
law = "pd"
omega_n = [20, 20, 25, 30, 20, 25, 30]
zeta = 1
reference_velocity = true
rate_hz = 500
velocity_filter = "backward"

[reference]
type = "fourier"
omega_f = 0.785398
file = "reference.csv"

[simulation]
parameters = "a_priori"
position_noise = 2e-6
disturbance = [0.4, 0.3, 0.2, 0.1, 0.3, 0.2, 0.1]

[montecarlo]
runs = 6
seed = 3

[[montecarlo.trial]]
label = "IV"
name = "iv"
signal = { cutoff_hz = "off", torque_held = true, decimation = 10 }

[[montecarlo.trial]]
label = "WLS"
name = "wls"
signal = { cutoff_hz = "off", torque_held = true, decimation = 10 }
)";

class TwoArms : public testing::Test {
 protected:
  TwoArms() {
    folder_.write("two_arms.urdf", test::two_arms());
    folder_.write("reference.csv", test::random_fourier(7, 12, 5));
    folder_.write("study.toml", study);
  }

  [[nodiscard]] std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(TwoArms, ComeOutOfTheirLogsWithinTheirIntervals) {
  const MonteCarlo plan = read_monte_carlo(path("study.toml"));
  const Robot& robot = plan.experiment.robot;
  ASSERT_TRUE(robot.chain.branches());
  ASSERT_EQ(robot.size(), 7);
  const BaseParameters base = base_parameters(robot);
  const Vector truth = base.from_standard(robot.chi_st());
  for (std::size_t trial = 0; trial < plan.trials.size(); ++trial) {
    double squares = 0.0;
    double largest = 0.0;
    Index count = 0;
    Index inside = 0;
    for (int run = 0; run < plan.runs; ++run) {
      const MonteCarloRow row = monte_carlo_run(plan, run)[trial];
      ASSERT_EQ(row.status, "identified") << plan.trials[trial].label << ", run " << run;
      const Vector error = (row.value - truth).array() / row.sigma.array();
      squares += error.squaredNorm();
      count += error.size();
      inside += (error.array().abs() < 1.96).count();
      largest = std::max(largest, error.cwiseAbs().maxCoeff());
    }
    // Some 300 errors, of which those of one log depend on each other.
    const auto n = static_cast<double>(count);
    EXPECT_NEAR(std::sqrt(squares / n), 1.0, 0.15) << plan.trials[trial].label;
    EXPECT_GE(static_cast<double>(inside) / n, 0.91) << plan.trials[trial].label;
    EXPECT_LE(largest, 4.5) << plan.trials[trial].label;
  }
}

// Both arms hang on the same torso: what one branch alone can not tell from the base is one parameter of
// both.
TEST_F(TwoArms, ShareTheParametersOfTheTorso) {
  const Robot robot = read_monte_carlo(path("study.toml")).experiment.robot;
  const BaseParameters base = base_parameters(robot);
  ASSERT_EQ(base.parameters[0].name, "ZZ1R");
  const std::string& regrouped = base.parameters[0].regrouped;
  EXPECT_NE(regrouped.find("M2"), std::string::npos) << regrouped;
  EXPECT_NE(regrouped.find("M5"), std::string::npos) << regrouped;
}

TEST_F(TwoArms, GoBackIntoTheirUrdf) {
  const Robot robot =
      read_urdf(path("two_arms.urdf"), same_part(read_monte_carlo(path("study.toml")).experiment.robot));
  std::mt19937_64 random(11);
  const Vector chi_st = test::random_urdf_parameters(robot, random);
  const RewrittenUrdf written = rewritten_urdf(path("two_arms.urdf"), robot, chi_st);
  test::expect_same_torques(written.text, robot, chi_st, random);
}

}  // namespace
}  // namespace rivid
