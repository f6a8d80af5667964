// A hobby servo without torque or current: goal and position alone, and a known weight on its arm.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "rivid/experiment/experiment.hpp"
#include "support/real_data.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

class BamServo : public test::RealData {
 protected:
  BamServo() : RealData("bam_servo") {}

  // 1.13 kg at 0.12 m, of which the parameters are known in units of the drive gain alone: torque per rad
  // between goal and position. The duty ends at 0.27 rad, with which the fast motion has the least residual.
  static constexpr double first_moment = 1.13 * 0.12;

  // load  whether the servo's own load is the control signal, in place of the law
  [[nodiscard]] Identification found(const std::string& log, double drive_gain, bool load = false) const {
    folder_.write("servo.toml",
                  "[robot]\nurdf = \"" + path("pendulum.urdf") +
                      "\"\ngravity = [0, 0, -9.81]\njoints.servo = { friction = \"coulomb\", drive_gain = " +
                      std::to_string(drive_gain) + " }\n[log]\nfiles = [\"" + path(log) +
                      "\"]\ntime = \"t\"\nposition = [\"q\"]\nirregular = \"resample\"\n" +
                      (load ? "control = [\"load\"]\n"
                            : "reference = [\"goal\"]\n[control]\nlaw = \"pid\"\nK_p = 1\nK_d = 0\n"
                              "v_tau_max = 0.27\n") +
                      "[method]\nname = \"wls\"\n");
    return run(read_experiment(folder_.path() / "servo.toml"));
  }
  static const ParameterEstimate& parameter(const Identification& of, const std::string& name) {
    return *std::ranges::find(of.parameters, name, &ParameterEstimate::name);
  }

  test::TemporaryFolder folder_;
};

TEST_F(BamServo, OneMotionWithAKnownMassGivesTheGainThatOthersAgreeWith) {
  constexpr double guess = 30.0;
  const Identification unscaled = found("feetech_1.csv", guess);
  EXPECT_EQ(unscaled.status, Status::identified) << unscaled.reasons.front();
  const double gain = guess * first_moment / -parameter(unscaled, "MZ1").value;
  const Identification scaled = found("feetech_1.csv", gain);
  const ParameterEstimate& J = parameter(scaled, "YY1R");
  EXPECT_NEAR(parameter(scaled, "MZ1").value, -first_moment, 1e-6 * first_moment);
  for (const char* const log : {"feetech_3.csv", "feetech_4.csv"}) {
    const Identification other = found(log, gain);
    EXPECT_EQ(other.status, Status::identified) << log;
    const ParameterEstimate& MZ = parameter(other, "MZ1");
    EXPECT_LE(MZ.interval_95[0], -first_moment) << log;
    EXPECT_GE(MZ.interval_95[1], -first_moment) << log;
    RecordProperty(std::string(log) + " m g l [N·m]",
                   std::to_string(-9.81 * MZ.value) + " ± " + std::to_string(9.81 * MZ.sigma));
    const ParameterEstimate& J_other = parameter(other, "YY1R");
    EXPECT_LE(J_other.interval_95[0], J.interval_95[1]) << log;
    EXPECT_GE(J_other.interval_95[1], J.interval_95[0]) << log;
  }
}

// 0.49 kg at 0.1 m; of the other motions the torque is off in part, or saturated.
TEST_F(BamServo, ItsLoadHasOneGainByTheKnownMass) {
  constexpr double moment = 0.49 * 0.1;
  const double gain = moment / -parameter(found("xl330_1.csv", 1.0, true), "MZ1").value;
  RecordProperty("drive gain [N·m]", std::to_string(gain));
  const Identification other = found("xl330_4.csv", gain, true);
  EXPECT_EQ(other.status, Status::identified);
  EXPECT_NEAR(parameter(other, "MZ1").value, -moment, 0.25 * parameter(other, "MZ1").sigma);
}

}  // namespace
}  // namespace rivid
