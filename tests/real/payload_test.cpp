// UR10e: the same motion with 2.805 kg on the flange and without.

#include "rivid/identify/payload.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "support/real_experiment.hpp"

namespace rivid {
namespace {

constexpr double mass = 2.805;
// Those of the controller's own model, wanted currents over wanted torques of its logs.
constexpr std::array<double, 6> controllers_gains = {11.78, 11.98, 9.82, 10.69, 10.53, 10.63};

class LoadedUr10e : public test::RealExperiment {
 protected:
  LoadedUr10e() : RealExperiment("ur10e") {}

  // From exact rows.
  [[nodiscard]] Payload identified(std::span<const double, 6> gains, const PayloadOptions& options) const {
    Experiment arm = experiment();
    for (std::size_t j = 0; j < 6; ++j) {
      arm.robot.joints[j].drive_gain = gains[j];
    }
    arm.estimation.signal = {};
    LogSource with = arm.log;
    with.files = {path("load_14harm.csv")};
    arm.log.files = {path("unload_14harm.csv"), path("ident_30s_12harm.csv"), path("ident_40s_12harm.csv")};
    arm.estimation.method = Wls{};
    return identify_payload(arm.robot, read_logs(arm.log, arm.robot), read_logs(with, arm.robot),
                            arm.estimation, options);
  }
};

TEST_F(LoadedUr10e, HasThePayloadWithinItsInterval) {
  PayloadOptions options;
  options.gain_sigma = Vector::Constant(6, 0.01);
  const Payload found = identified(controllers_gains, options);
  ASSERT_TRUE(found.identified) << found.reason;
  const auto [low, high] = found.values[0].interval_95;
  EXPECT_LE(low, mass);
  EXPECT_GE(high, mass);
  EXPECT_LE(0.5 * (high - low), 0.06);
}

TEST_F(LoadedUr10e, TellsTheGainsFromTheKnownMass) {
  PayloadOptions options{.mass = mass};
  options.gain_sigma = Vector::Constant(6, std::numeric_limits<double>::infinity());
  constexpr std::array<double, 6> tens = {10.0, 10.0, 10.0, 10.0, 10.0, 10.0};
  const Payload found = identified(tens, options);
  ASSERT_TRUE(found.identified) << found.reason;
  for (std::size_t j = 0; j < 6; ++j) {
    const double off = std::abs(found.gains[j].value / controllers_gains[j] - 1.0);
    EXPECT_LE(off, j == 0 ? 0.15 : 0.05) << found.gains[j].joint;
  }
}

}  // namespace
}  // namespace rivid
