// rivid check on logs of real arms: no false alarm on any of them as they are, and planted faults by
// their names.

#include "rivid/identify/check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "support/real_experiment.hpp"

namespace {

using rivid::Severity;

template <const char* Robot>
class Checked : public rivid::test::RealExperiment {
 protected:
  Checked() : RealExperiment(Robot) {}

  [[nodiscard]] std::vector<rivid::Finding> findings() const {
    const rivid::Experiment e = experiment();
    return check(e.robot, read_logs(e.log, e.robot), read_logs(e.validation, e.robot),
                 {.signal = e.estimation.signal,
                  .instrumental = std::holds_alternative<rivid::Iv>(e.estimation.method)});
  }

  // No error; what the model lacks (friction that depends on the load, say) may be a warning, but no fault of
  // the log.
  void expect_sound() const {
    static constexpr std::array lacking = {"load_friction",    "stribeck_friction", "direction_friction",
                                           "joint_elasticity", "joint_spring",      "joint_coupling",
                                           "model_mismatch",   "validation_worse",  "weak_excitation",
                                           "noise_bias",       "negative_rotor",    "clock_jitter",
                                           "friction_drives",  "torque_lag",        "validation_log_used"};
    for (const rivid::Finding& f : findings()) {
      EXPECT_TRUE(severity(f) == Severity::note || std::ranges::find(lacking, f.code) != lacking.end())
          << f.code << " " << f.subject << ": " << f.text;
    }
    EXPECT_EQ(run(experiment()).status, rivid::Status::identified);
  }

  void expect_error(std::string_view code, std::string_view subject) const {
    const std::vector<rivid::Finding> found = findings();
    EXPECT_TRUE(std::ranges::any_of(found,
                                    [&](const rivid::Finding& f) {
                                      return severity(f) == Severity::error && f.code == code &&
                                             f.subject == subject;
                                    }))
        << "no " << code << " of " << subject << "; the first finding is " << found.front().code << " of "
        << found.front().subject << ": " << found.front().text;
    // The identification alone says so too, where it does not refuse the log.
    try {
      const rivid::Identification result = run(experiment());
      EXPECT_NE(result.status, rivid::Status::identified);
      EXPECT_TRUE(std::ranges::any_of(
          result.warnings, [&](const rivid::Finding& f) { return f.code == code && f.subject == subject; }))
          << "rivid_identify: no " << code << " of " << subject;
    } catch (const rivid::InputError&) {
      SUCCEED();
    }
  }

  // The columns of the seven or fewer joints, one of them with a sign, two of them exchanged.
  static std::string columns(const std::string& key, const std::string& symbol, int joints, int turned,
                             int first = 0, int second = 0) {
    std::string out = key + " = [";
    for (int j = 1; j <= joints; ++j) {
      const int from = j == first ? second : j == second ? first : j;
      out += "{ column = \"" + symbol + std::to_string(from) + "\", sign = " + (j == turned ? "-1" : "1") +
             " }, ";
    }
    return out + "]\n";
  }
};

constexpr char panda[] = "panda";
constexpr char ur10e[] = "ur10e";
constexpr char emps[] = "emps";
constexpr char tx40[] = "tx40";
constexpr char kuka_kr300[] = "kuka_kr300";
constexpr char ur10_vrep[] = "ur10_vrep";

using CheckedPanda = Checked<panda>;
using CheckedUr10e = Checked<ur10e>;
using CheckedEmps = Checked<emps>;
using CheckedTx40 = Checked<tx40>;
using CheckedKuka = Checked<kuka_kr300>;
using CheckedVrep = Checked<ur10_vrep>;

TEST_F(CheckedPanda, IsSound) { expect_sound(); }
TEST_F(CheckedUr10e, IsSound) { expect_sound(); }
TEST_F(CheckedEmps, IsSound) { expect_sound(); }
TEST_F(CheckedTx40, IsSound) { expect_sound(); }
TEST_F(CheckedKuka, IsSound) { expect_sound(); }
TEST_F(CheckedVrep, IsSound) { expect_sound(); }

TEST_F(CheckedEmps, IsSoundWithItsReference) {
  edit("control = [\"v1\"]", "control = [\"v1\"]\nreference = [\"qref1\"]");
  expect_sound();
}

TEST_F(CheckedKuka, IsSoundWithItsReferenceAndVelocities) {
  edit("rate_hz = 250",
       "rate_hz = 250\n" + columns("reference", "qref", 6, 0) + columns("velocity", "qd", 6, 0));
  expect_sound();
}

TEST_F(CheckedUr10e, IsSoundOnOtherMotions) {
  for (const char* const file : {"ident_40s_12harm", "unload_14harm"}) {
    SCOPED_TRACE(file);
    edit("files = [\"ur10e/ident_30s_12harm.csv\"]", std::string("files = [\"ur10e/") + file + ".csv\"]");
    expect_sound();
    edit(std::string("files = [\"ur10e/") + file + ".csv\"]", "files = [\"ur10e/ident_30s_12harm.csv\"]");
  }
}

// One log alone excites weakly, see KukaKr300.OneLogAloneExcitesWeakly.
TEST_F(CheckedKuka, WarnsOfOneLogAlone) {
  edit("files = [\"kuka_kr300/kr300_A.csv\", \"kuka_kr300/kr300_B.csv\"]",
       "files = [\"kuka_kr300/kr300_A.csv\"]");
  const auto found = findings();
  EXPECT_TRUE(std::ranges::any_of(found, [](const rivid::Finding& f) {
    return severity(f) == Severity::warning && f.code == "weak_excitation";
  }));
}

// All six of the published gains are more than 5 % from those of the controller's own model, which three logs
// agree on.
TEST_F(CheckedUr10e, NamesTheJointsWhoseDriveGainIsNotTheControllers) {
  const auto named = [this] {
    const std::vector<rivid::Finding> all = check(experiment());
    EXPECT_TRUE(std::ranges::any_of(all, [](const rivid::Finding& f) {
      return f.code == "target_gains" &&
             f.text.find("target currents and torques of 3 logs") != std::string::npos;
    }));
    return std::ranges::count(all, "drive_gain_differs", &rivid::Finding::code);
  };
  EXPECT_EQ(named(), 0);
  edit("drive_gain = [11.78, 11.98, 9.82, 10.69, 10.53, 10.63]",
       "drive_gain = [10.0, 10.6956, 8.4566, 9.0029, 9.48, 10.1232]");
  EXPECT_EQ(named(), 6);
  edit("drive_gain = [10.0, 10.6956, 8.4566, 9.0029, 9.48, 10.1232]",
       "drive_gain = [11.78, 11.98, 9.82, 10.69, 10.53, 12.0]");
  EXPECT_EQ(named(), 1);
}

TEST_F(CheckedUr10e, NamesTheJointsThatALogDoesNotMove) {
  edit("files = [\"ur10e/ident_30s_12harm.csv\"]", "files = [\"ur10e/jointwise_2.csv\"]");
  expect_error("joint_still", "shoulder_pan_joint");
  expect_error("joint_still", "wrist_3_joint");
}

TEST_F(CheckedPanda, NamesATorqueWithTheWrongSign) {
  edit("rate_hz = 1000",
       "rate_hz = 1000\n" + columns("position", "q", 7, 0) + columns("torque", "tau", 7, 3));
  expect_error("torque_sign", "joint_3");
}

TEST_F(CheckedPanda, NamesAPositionWithTheWrongSign) {
  edit("rate_hz = 1000",
       "rate_hz = 1000\n" + columns("position", "q", 7, 6) + columns("torque", "tau", 7, 0));
  expect_error("position_sign", "joint_6");
}

TEST_F(CheckedPanda, NamesExchangedJoints) {
  edit("rate_hz = 1000",
       "rate_hz = 1000\n" + columns("position", "q", 7, 0, 3, 5) + columns("torque", "tau", 7, 0, 3, 5));
  expect_error("joint_order", "joint_3 and joint_5");
}

TEST_F(CheckedPanda, NamesARateThatItsOwnVelocitiesContradict) {
  edit("rate_hz = 1000", "rate_hz = 100");
  edit("cutoff_hz = 20\n", "cutoff_hz = 2\n");
  expect_error("time_scale", "all joints");
}

TEST_F(CheckedPanda, NamesGravityUpsideDown) {
  edit("gravity = [0, 0, -9.80665]", "gravity = [0, 0, 9.80665]");
  expect_error("gravity_direction", "base_link");
}

TEST_F(CheckedUr10e, NamesGravityOfAnotherMounting) {
  edit("friction = ", "gravity = [9.81, 0, 0]\nfriction = ");
  expect_error("gravity_direction", "base_link");
}

TEST_F(CheckedUr10e, NamesExchangedTorques) {
  edit("control = [\"i1\", \"i2\", \"i3\"", "control = [\"i1\", \"i3\", \"i2\"");
  expect_error("torque_order", "shoulder_lift_joint and elbow_joint");
}

TEST_F(CheckedUr10e, NamesATorqueWithTheWrongSign) {
  edit("\"i5\"", "{ column = \"i5\", sign = -1 }");
  expect_error("torque_sign", "wrist_2_joint");
}

TEST_F(CheckedUr10e, NamesADriveGainThatIsMissing) {
  edit("drive_gain = [11.78, 11.98, 9.82, 10.69, 10.53, 10.63]", "drive_gain = 1");
  expect_error("torque_unit", "all joints");
}

TEST_F(CheckedUr10e, NamesADelay) {
  edit("irregular = ", "torque_lag = -20\nirregular = ");
  expect_error("torque_delay", "all joints");
}

TEST_F(CheckedTx40, NamesExchangedPositions) {
  edit("\"q5\", \"q6\"", "\"q6\", \"q5\"");
  expect_error("position_order", "joint_5 and joint_6");
}

TEST_F(CheckedTx40, NamesAnotherUnitWithoutAnyMassesKnown) {
  edit("\"tau6\"]", "\"tau6\"]\nunits = { torque = \"kNm\" }");
  expect_error("torque_unit", "all joints");
}

TEST_F(CheckedEmps, NamesMillimetres) {
  edit("position = [\"q1\"]", "position = [{ column = \"q1\", scale = 1000 }]");
  expect_error("position_unit", "joint_1");
}

TEST_F(CheckedEmps, NamesAForceWithTheWrongSign) {
  edit("control = [\"v1\"]", "control = [{ column = \"v1\", sign = -1 }]");
  expect_error("torque_sign", "joint_1");
}

TEST_F(CheckedEmps, NamesADelayOfTwentySamples) {
  edit("control = [\"v1\"]", "control = [\"v1\"]\ntorque_lag = -20");
  expect_error("torque_delay", "all joints");
}

TEST_F(CheckedVrep, NamesExchangedTorques) {
  edit("\"tau2\", \"tau3\"", "\"tau3\", \"tau2\"");
  expect_error("torque_order", "joint_2 and joint_3");
}

}  // namespace
