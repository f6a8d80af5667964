// Drive gains that follow from what a controller logs of its own model, and those of an experiment file
// beside them.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "experiment/recognised_columns.hpp"
#include "rivid/experiment/experiment.hpp"
#include "support/normal.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

constexpr std::array<double, 2> gains = {11.5, 4.25};

// What a controller's model makes of a motion of two joints.
struct ControllerLog {
  std::array<double, 2> friction = {2.0, 0.5};  // N·m, of dry and viscous friction together
  std::array<double, 2> load = {20.0, 3.0};     // N·m
  std::array<double, 2> mean = {5.0, -1.0};     // N·m
  double noise = 0.0;                           // of the currents, correlated over some 0.1 s [A]
  double unit = 1.0;                            // of the currents [A]
  bool coupled = false;  // the second motor turns with both joints: q_m2 = q1 + q2, τ1 = τ_m1 + τ_m2
  unsigned seed = 1;

  // 20 s at 100 Hz.
  [[nodiscard]] std::string text(bool targets = true) const {
    std::mt19937_64 random(seed);
    test::Normal normal;
    std::array<double, 2> error{};
    std::string out = targets ? "t,q1,q2,i1,i2,itarget1,itarget2,tautarget1,tautarget2\n" : "t,q1,q2,i1,i2\n";
    const auto cell = [](double x) { return ',' + std::to_string(x); };
    for (int k = 0; k < 2000; ++k) {
      const double t = 0.01 * k;
      std::array<double, 2> speed{}, torque{};
      std::string positions, currents, torques;
      for (std::size_t j = 0; j < 2; ++j) {
        const double w = 1.0 + 0.4 * static_cast<double>(j);
        speed[j] = std::cos(w * t) + 0.5 * std::sin(2.7 * w * t);
        positions += cell(std::sin(w * t) / w - 0.5 * std::cos(2.7 * w * t) / (2.7 * w));
        torque[j] = load[j] * std::sin(1.7 * w * t + 0.4) + mean[j];
      }
      for (std::size_t j = 0; j < 2; ++j) {
        const double qd = j == 1 && coupled ? speed[0] + speed[1] : speed[j];
        const double sign = qd > 0.0 ? 1.0 : -1.0;
        const double losses = friction[j] * (sign + 0.4 * qd + 0.7 * sign * std::sqrt(std::abs(qd)));
        error[j] = 0.9 * error[j] + std::sqrt(1.0 - 0.81) * noise * normal(random);
        currents += cell(((torque[j] + losses) / gains[j] + error[j]) / unit);
        torques += cell(j == 0 && coupled ? torque[0] + torque[1] : torque[j]);
      }
      out += std::to_string(t) + positions + currents + (targets ? currents + torques : "") + '\n';
    }
    return out;
  }
};

class TargetGains : public testing::Test {
 protected:
  TargetGains() {
    folder_.write(
        "arm.urdf",
        "<robot name=\"arm\"><link name=\"base\"/>"
        "<joint name=\"shoulder\" type=\"continuous\"><parent link=\"base\"/><child link=\"upper\"/>"
        "<axis xyz=\"0 1 0\"/></joint><link name=\"upper\"/>"
        "<joint name=\"elbow\" type=\"continuous\"><origin xyz=\"0.5 0 0\"/><parent link=\"upper\"/>"
        "<child link=\"lower\"/><axis xyz=\"0 1 0\"/></joint><link name=\"lower\"/></robot>");
    log("a.csv", {});
  }

  void log(const char* file, const ControllerLog& of, bool targets = true) const {
    folder_.write(file, of.text(targets));
  }

  // `robot`, `columns`, `more`: lines of [robot] and [log], and sections behind these.
  [[nodiscard]] Experiment experiment(
      const std::string& robot,
      const std::string& columns = "files = \"a.csv\"\ncontrol = [\"i1\", \"i2\"]\n",
      const std::string& more = "") const {
    folder_.write("arm.toml", "[robot]\nurdf = \"arm.urdf\"\n" + robot +
                                  "\n[log]\nposition = [\"q1\", \"q2\"]\n" + columns +
                                  "\n[signal]\ndecimation = \"auto\"\n" + more);
    return read_experiment(folder_.path() / "arm.toml");
  }

  [[nodiscard]] static detail::TargetGains found(const Experiment& from) {
    const std::array sources = {from.log, from.validation};
    const auto out = detail::target_gains(sources, from.robot);
    return out.value_or(detail::TargetGains());
  }

  static void expect_gains(const detail::TargetGains& found, double first, double second) {
    ASSERT_EQ(found.motors.size(), 2U);
    EXPECT_NEAR(found.motors[0].value, first, 2e-4 * std::abs(first)) << found.motors[0].missing;
    EXPECT_NEAR(found.motors[1].value, second, 2e-4 * std::abs(second)) << found.motors[1].missing;
  }

  // Joints whose gain check() names.
  [[nodiscard]] static std::vector<std::string> named(const Experiment& from) {
    std::vector<std::string> out;
    for (const Finding& finding : check(from)) {
      if (finding.code == "drive_gain_differs") {
        out.push_back(finding.subject);
      }
    }
    return out;
  }

  [[nodiscard]] const test::TemporaryFolder& folder() const { return folder_; }

 private:
  test::TemporaryFolder folder_;
};

using Names = std::vector<std::string>;

TEST_F(TargetGains, AreCurrentsOverTorquesWithoutFriction) {
  expect_gains(found(experiment("")), gains[0], gains[1]);
}

// Gears are between motor and joint; the sign follows the axes of the URDF.
TEST_F(TargetGains, AreThoseOfTheMotors) {
  expect_gains(found(experiment("drive_gain = [-1, 1]\ngear_ratio = [50, -10]")), -gains[0] / 50.0,
               gains[1] / 10.0);
  log("a.csv", {.coupled = true});
  expect_gains(found(experiment("gear_matrix = [[1, 0], [1, 1]]")), gains[0], gains[1]);
}

TEST_F(TargetGains, AreInTheUnitOfTheControlColumns) {
  log("a.csv", {.unit = 1e-3});
  expect_gains(found(experiment("",
                                "files = \"a.csv\"\ncontrol = [\"i1\", { column = \"i2\", sign = -1 }]\n"
                                "units = { control = \"mA\" }")),
               gains[0], gains[1]);
}

// A gearbox that is warm in the second log has another friction there.
TEST_F(TargetGains, AreCommonToLogsWhoseFrictionDiffers) {
  log("b.csv", {.friction = {4.0, 0.2}, .load = {15.0, 4.0}, .seed = 2});
  const auto both = found(experiment("", "files = [\"a.csv\", \"b.csv\"]\ncontrol = [\"i1\", \"i2\"]"));
  expect_gains(both, gains[0], gains[1]);
  EXPECT_EQ(both.logs, (Names{"a.csv", "b.csv"}));
}

// Nine of ten and more of the intervals hold the gains: 200, of errors that are correlated.
TEST_F(TargetGains, HaveIntervalsThatHoldThem) {
  int held = 0;
  constexpr unsigned runs = 100;
  for (unsigned seed = 1; seed <= runs; ++seed) {
    log("a.csv", {.noise = 0.03, .seed = seed});
    const auto one = found(experiment(""));
    for (std::size_t j = 0; j < 2; ++j) {
      ASSERT_EQ(one.motors[j].missing, "") << seed;
      held += static_cast<int>(std::abs(one.motors[j].value - gains[j]) < one.motors[j].half_width);
    }
  }
  // 95 % within four standard deviations of a binomial count.
  EXPECT_NEAR(held, 0.95 * 2 * runs, 4.0 * std::sqrt(0.95 * 0.05 * 2 * runs));
}

TEST_F(TargetGains, SayWhyOneIsMissing) {
  log("a.csv", {.load = {20.0, 0.0}});
  const auto constant = found(experiment(""));
  EXPECT_NEAR(constant.motors[0].value, gains[0], 2e-4 * gains[0]);
  EXPECT_EQ(constant.motors[1].missing, "its target torque hardly changes");
  log("a.csv", {.load = {20.0, 0.0}, .mean = {5.0, 0.0}});
  EXPECT_EQ(found(experiment("")).motors[1].missing, "its target torque hardly changes");
  log("a.csv", {.load = {20.0, 0.1}, .noise = 0.03});
  EXPECT_NE(found(experiment("")).motors[1].missing.find("changes too little"), std::string::npos)
      << found(experiment("")).motors[1].missing;
  log("a.csv", {.noise = 3.0});
  EXPECT_NE(found(experiment("")).motors[0].missing.find("% of its target current"), std::string::npos);
  const std::string words = constant.text(experiment("").robot);
  EXPECT_NE(words.find("drive_gain = [11.5, ?] by the target currents and torques of a.csv"),
            std::string::npos)
      << words;
  EXPECT_NE(words.find("; elbow: its target torque hardly changes"), std::string::npos) << words;
}

TEST_F(TargetGains, NeedTheirColumns) {
  log("b.csv", {}, false);
  EXPECT_TRUE(found(experiment("", "files = \"b.csv\"\ncontrol = [\"i1\", \"i2\"]")).motors.empty());
  const auto one = found(experiment("", "files = [\"b.csv\", \"a.csv\"]\ncontrol = [\"i1\", \"i2\"]"));
  expect_gains(one, gains[0], gains[1]);
  EXPECT_EQ(one.logs, Names{"a.csv"});
}

TEST_F(TargetGains, AreANoteOfCheck) {
  const std::vector<Finding> findings = check(experiment("drive_gain = [11.5, 4.25]"));
  const auto note = std::ranges::find(findings, "target_gains", &Finding::code);
  ASSERT_NE(note, findings.end());
  EXPECT_NE(note->text.find("drive_gain = [11.5, 4.25]"), std::string::npos) << note->text;
  EXPECT_TRUE(std::ranges::is_sorted(findings, std::ranges::greater(), severity));
}

TEST_F(TargetGains, NameTheJointWhoseDriveGainIsAnother) {
  EXPECT_EQ(named(experiment("drive_gain = [11.5, 4.25]")), Names{});
  EXPECT_EQ(named(experiment("drive_gain = [11.1, 4.10]")), Names{})
      << "4 % are within what such models know";
  EXPECT_EQ(named(experiment("drive_gain = [11.5, 3.4]")), Names{"elbow"});
  EXPECT_EQ(named(experiment("drive_gain = [12.5, 4.25]")), Names{"shoulder"});
  EXPECT_EQ(named(experiment("")), (Names{"shoulder", "elbow"})) << "nothing is said of them";
  EXPECT_EQ(named(experiment("drive_gain = [-11.5, 4.25]")), Names{}) << "the axis is turned";
  EXPECT_EQ(named(experiment("drive_gain = [0.23, 0.425]\ngear_ratio = [50, 10]")), Names{});
  EXPECT_EQ(named(experiment("drive_gain = [11.5, 4.25]\ngear_ratio = [50, 1]")), Names{"shoulder"});
}

TEST_F(TargetGains, SayByHowMuchTheTorquesAreOff) {
  const std::vector<Finding> findings = check(experiment("drive_gain = [11.5, 3.4]"));
  const auto finding = std::ranges::find(findings, "drive_gain_differs", &Finding::code);
  ASSERT_NE(finding, findings.end());
  EXPECT_EQ(severity(*finding), Severity::warning);
  EXPECT_NE(finding->text.find("drive_gain is 3.4, by the controller's own model 4.25 ± "), std::string::npos)
      << finding->text;
  EXPECT_NE(finding->text.find("are 20 % too small"), std::string::npos) << finding->text;
}

// A gain that the numbers leave open is not held against anyone.
TEST_F(TargetGains, AllowWhatTheirIntervalsAllow) {
  log("a.csv", {.load = {20.0, 0.8}, .noise = 0.03, .seed = 3});
  const Experiment near = experiment("drive_gain = [11.5, 4.5]");
  const auto targets = found(near);
  ASSERT_EQ(targets.motors[1].missing, "");
  ASSERT_GT(1.5 * targets.motors[1].half_width, std::abs(targets.motors[1].value - 4.5)) << "of this seed";
  ASSERT_GT(std::abs(targets.motors[1].value - 4.5), 0.05 * targets.motors[1].value) << "of this seed";
  EXPECT_EQ(named(near), Names{});
}

TEST_F(TargetGains, AreOfNoUseBesideTorquesAndWhereGainsAreEstimated) {
  EXPECT_EQ(named(experiment("drive_gain = 1", "files = \"a.csv\"\ntorque = [\"i1\", \"i2\"]")), Names{});
  EXPECT_EQ(named(experiment("drive_gain = 1", "files = \"a.csv\"\ncontrol = [\"i1\", \"i2\"]",
                             "[method]\ngains = \"estimate\"\n")),
            Names{});
}

TEST_F(TargetGains, DoNotStopACheckWhereTheyCanNotBeRead) {
  std::string text = ControllerLog().text();
  const std::size_t row = text.rfind('\n', text.size() - 2);
  text.replace(text.rfind(','), std::string::npos, ",nan\n");
  ASSERT_LT(row, text.size());
  folder().write("a.csv", text);
  const std::vector<Finding> findings = check(experiment("drive_gain = [11.5, 3.4]"));
  EXPECT_TRUE(std::ranges::any_of(findings, [](const Finding& finding) {
    return finding.code == "log_note" &&
           finding.text.find("\"tautarget2\" holds \"nan\"") != std::string::npos;
  }));
  EXPECT_TRUE(
      std::ranges::none_of(findings, [](const Finding& finding) { return finding.code == "target_gains"; }));
}

}  // namespace
}  // namespace rivid
