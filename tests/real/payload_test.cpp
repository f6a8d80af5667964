// UR10e: the same motion with 2.805 kg on the flange and without.

#include "rivid/identify/payload.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "support/real_experiment.hpp"

namespace rivid {
namespace {

constexpr double mass = 2.805;
// Those of the controller's own model, wanted currents over wanted torques of its logs.
constexpr std::array<double, 6> controllers_gains = {11.78, 11.98, 9.82, 10.69, 10.53, 10.63};

class LoadedUr10e : public test::RealExperiment {
 protected:
  LoadedUr10e() : RealExperiment("ur10e") {}

  // The logs without payload, by exact rows and weighted least squares.
  [[nodiscard]] Experiment arm_with(std::span<const double, 6> gains) const {
    Experiment arm = experiment();
    for (std::size_t j = 0; j < 6; ++j) {
      arm.robot.joints[j].drive_gain = gains[j];
    }
    arm.estimation.signal = {};
    arm.estimation.method = Wls{};
    arm.log.files = {path("unload_14harm.csv"), path("ident_30s_12harm.csv"), path("ident_40s_12harm.csv")};
    return arm;
  }

  [[nodiscard]] std::vector<Log> loaded_logs(const Experiment& arm) const {
    LogSource with = arm.log;
    with.files = {path("load_14harm.csv")};
    return read_logs(with, arm.robot);
  }

  // known  mass where it is known
  [[nodiscard]] PayloadReport identified(std::span<const double, 6> gains, const PayloadOptions& options,
                                         std::optional<double> known = {}) const {
    const Experiment arm = arm_with(gains);
    const std::vector<Log> logs = loaded_logs(arm);
    const LoadedLogs loaded{.logs = logs, .mass = known};
    return identify_payloads(arm.robot, read_logs(arm.log, arm.robot), std::span(&loaded, 1), arm.estimation,
                             options);
  }
};

TEST_F(LoadedUr10e, HasThePayloadWithinItsInterval) {
  PayloadOptions options;
  options.gain_sigma = Vector::Constant(6, 0.01);
  const PayloadReport found = identified(controllers_gains, options);
  ASSERT_TRUE(found.identified) << found.reason;
  const auto [low, high] = found.payloads[0].values[0].interval_95;
  EXPECT_LE(low, mass);
  EXPECT_GE(high, mass);
  EXPECT_LE(0.5 * (high - low), 0.06);
}

// On top of the arm as it was identified, without its logs.
TEST_F(LoadedUr10e, HasThePayloadOfAnIdentifiedArm) {
  const Experiment arm = arm_with(controllers_gains);
  const IdentifiedArm known =
      identified_arm(arm.robot, identify(arm.robot, read_logs(arm.log, arm.robot), arm.estimation));
  const std::vector<Log> logs = loaded_logs(arm);
  const LoadedLogs loaded{.logs = logs};
  PayloadOptions options;
  options.gain_sigma = Vector::Constant(6, 0.01);
  const PayloadReport found = identify_payloads(known, std::span(&loaded, 1), arm.estimation, options);
  ASSERT_TRUE(found.identified) << found.reason;
  const auto [low, high] = found.payloads[0].values[0].interval_95;
  RecordProperty("interval", std::to_string(low) + " " + std::to_string(high));
  EXPECT_LE(low, mass);
  EXPECT_GE(high, mass);
  EXPECT_LE(0.5 * (high - low), 0.07);
}

TEST_F(LoadedUr10e, TellsTheGainsFromTheKnownMass) {
  PayloadOptions options;
  options.gain_sigma = Vector::Constant(6, std::numeric_limits<double>::infinity());
  constexpr std::array<double, 6> tens = {10.0, 10.0, 10.0, 10.0, 10.0, 10.0};
  const PayloadReport found = identified(tens, options, mass);
  ASSERT_TRUE(found.identified) << found.reason;
  for (std::size_t j = 0; j < 6; ++j) {
    const double off = std::abs(found.gains[j].value / controllers_gains[j] - 1.0);
    EXPECT_LE(off, j == 0 ? 0.15 : 0.05) << found.gains[j].joint;
  }
}

}  // namespace
}  // namespace rivid
