// Experiment files that a hint changes: what else is written there stays, and what is new is read as it was
// meant.

#include "experiment/changed_text.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "experiment/from_program.hpp"
#include "rivid/error.hpp"

namespace rivid::detail {
namespace {

const std::filesystem::path file = std::filesystem::path(RIVID_DATA) / "scara" / "edited.toml";

// An experiment of the SCARA with that [log], a comment with letters of several bytes before it.
std::string with_log(const std::string& log) {
  return "# größer\n[robot]\nurdf = \"scara.urdf\"  # as built\n\n[log]\nfiles = [\"scara_s2.csv\"]\n" + log;
}

ChangedText changed(const std::string& text, const std::vector<Change>& changes) {
  const Experiment experiment = experiment_of_text(file, text);
  return changed_text(text, experiment, read_logs(experiment.log, experiment.robot).front(), changes);
}

TEST(ChangedText, KeepsWhatIsNotChanged) {
  const std::string text = with_log("torque_lag = 1.5  # größer\nrate_hz = 200\n");
  const ChangedText out = changed(text, {{.key = "log.torque_lag", .numbers = {2.0}}});
  EXPECT_EQ(out.text, with_log("torque_lag = 3.5  # größer\nrate_hz = 200\n"));
  EXPECT_EQ(out.lines, (std::vector<std::string>{"[log]", "torque_lag = 3.5"}));
}

TEST(ChangedText, FindsAPlaceForANewKey) {
  const std::string text = with_log("");
  const ChangedText out = changed(text, {{.key = "robot.gravity", .numbers = {0.0, 0.0, 9.81}},
                                         {.key = "robot.friction", .joint = "joint_2", .word = "load"},
                                         {.key = "signal.torque_held", .word = "true"}});
  const Experiment then = experiment_of_text(file, out.text);
  EXPECT_EQ(then.robot.chain.gravity, Eigen::Vector3d(0.0, 0.0, 9.81));
  EXPECT_EQ(then.robot.joints[0].friction, Friction::symmetric);
  EXPECT_EQ(then.robot.joints[1].friction, Friction::load);
  EXPECT_TRUE(then.estimation.signal.held());
  EXPECT_NE(out.text.find("# as built"), std::string::npos);
  // Tables that stand within a line, and a second change of the same key.
  const ChangedText again = changed(
      "robot = { urdf = \"scara.urdf\", joints = { joint_2 = {} } }\nlog = { files = [\"scara_s2.csv\"] }\n",
      {{.key = "robot.friction", .joint = "joint_2", .word = "load"},
       {.key = "robot.friction", .joint = "joint_2", .word = "root"},
       {.key = "log.torque_lag", .numbers = {1.0}}});
  const Experiment of_lines = experiment_of_text(file, again.text);
  EXPECT_EQ(of_lines.robot.joints[1].friction, Friction::root);
  EXPECT_EQ(of_lines.log.torque_lag, 1.0);
}

TEST(ChangedText, ChangesColumnsWithTheirUnitsAndZeros) {
  const std::string text = with_log(
      "position = [{ column = \"q1\", unit = \"deg\", offset = 0.5 }, 3]\ncontrol = [\"v1\", \"v2\"]\n");
  const ChangedText out =
      changed(text, {{"log.position.scale", "joint_1", {-2.0}},
                     {"log.position.offset", "joint_1", {0.25}},
                     {.key = "log.torque.column", .joint = "joint_1", .word = "joint_2"},
                     {.key = "log.torque.column", .joint = "joint_2", .word = "joint_1"}});
  const LogOptions then = experiment_of_text(file, out.text).log.columns;
  const LogOptions before = experiment_of_text(file, text).log.columns;
  EXPECT_DOUBLE_EQ(then.position[0].scale, -2.0 * before.position[0].scale);
  EXPECT_DOUBLE_EQ(then.position[0].offset, -0.75);
  EXPECT_EQ(then.position[1].name, "#3");
  EXPECT_EQ(then.control[0].name, "v2");
  EXPECT_EQ(then.control[1].name, "v1");
}

TEST(ChangedText, ListsAllColumnsWhereItListsTorques) {
  const ChangedText out = changed(with_log(""), {{"log.torque.scale", "joint_2", {0.5}}});
  const Experiment then = experiment_of_text(file, out.text);
  const Log log = read_logs(then.log, then.robot).front();
  EXPECT_EQ(log.q_r.cols(), 2);
  EXPECT_DOUBLE_EQ(then.log.columns.control.at(1).scale, 0.5);
}

TEST(ChangedText, AddsACoupling) {
  const Change change = {"robot.coupling", "joint_2", {-1.0}, "joint_1"};
  const Experiment then = experiment_of_text(file, changed(with_log(""), {change}).text);
  ASSERT_EQ(then.robot.couplings.size(), 1U);
  EXPECT_EQ(then.robot.couplings[0].motor, 1);
  EXPECT_EQ(then.robot.couplings[0].joints, std::vector{0});
  EXPECT_EQ(then.robot.couplings[0].ratios, std::vector{-1.0});
}

TEST(ChangedText, RefusesAFileWithoutAPlace) {
  const std::string text = "robot.urdf = \"scara.urdf\"\nlog.files = [\"scara_s2.csv\"]\n";
  EXPECT_THROW(changed(text, {{.key = "log.torque_lag", .numbers = {1.0}}}), InputError);
}

}  // namespace
}  // namespace rivid::detail
