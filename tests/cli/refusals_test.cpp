// rivid_identify refuses bad input: one line that names the culprit, exit code 2, no output.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Outcome;
using rivid::test::outcome_of;

class Refusal : public rivid::test::IdentifyTool {};

// Logs

TEST_F(Refusal, NamesAColumnThatTheLogLacks) {
  edit("scara.toml", R"(["q1", "q2"])", R"(["q1", "qq2"])");
  expect_refused({"scara_s2.csv: there is no column \"qq2\"",
                  "the columns are t, q1, q2, v1, v2, qref1, qref2", "did you mean \"q2\"?"});
}

TEST_F(Refusal, NamesLineAndColumnOfANan) {
  set_cell("scara_s2.csv", 1842, 3, "nan");
  expect_refused({"scara_s2.csv:1842:3: column \"q2\" holds \"nan\"; values must be finite"});
}

TEST_F(Refusal, NamesLineAndColumnOfText) {
  set_cell("scara_s2.csv", 17, 4, "off");
  expect_refused({"scara_s2.csv:17:4: column \"v1\" holds \"off\", which is not a number"});
}

TEST_F(Refusal, NamesLineAndColumnOfAnEmptyCell) {
  set_cell("scara_s2.csv", 17, 4, "");
  expect_refused({"scara_s2.csv:17:4: column \"v1\" is empty"});
}

TEST_F(Refusal, NamesTheLineWithTooFewFields) {
  keep_lines("scara_s2.csv", 1000);
  folder().write("scara_s2.csv", folder().read("scara_s2.csv") + "4.995,0.1,0.2");
  expect_refused({"scara_s2.csv:1001: the line has 3 fields, 7 are required"});
}

TEST_F(Refusal, OfAnEmptyLog) {
  folder().write("scara_s2.csv", "");
  expect_refused({"scara_s2.csv: the file is empty"});
}

TEST_F(Refusal, OfALogWithNothingButAHeader) {
  keep_lines("scara_s2.csv", 1);
  expect_refused({"scara_s2.csv: the file holds a header but no data"});
}

TEST_F(Refusal, OfALogOfOneSample) {
  keep_lines("scara_s2.csv", 2);
  expect_refused({"scara_s2.csv: the log has one sample"});
}

TEST_F(Refusal, OfALogThatFiltersCanNotRunOver) {
  keep_lines("scara_s2.csv", 61);
  expect_refused({"scara_s2.csv: decimation by 20 meets 20 samples, needs at least 25"});
}

TEST_F(Refusal, OfFewerRowsThanParameters) {
  keep_lines("scara_s2.csv", 75);
  edit("scara.toml", "trim = 20 ", "rows = \"paper\"\ntrim = 20 ");
  expect_refused({"rows for 8 base parameters; more rows than parameters are needed"});
}

TEST_F(Refusal, OfAMissingLog) {
  std::filesystem::remove(folder().path() / "scara_s2.csv");
  expect_refused({"scara_s2.csv: there is no such file"});
}

TEST_F(Refusal, OfAFolderInPlaceOfALog) {
  edit("scara.toml", R"(files = ["scara_s2.csv"])", R"(files = ["."])");
  expect_refused({".: is a directory, a file is required"});
}

TEST_F(Refusal, OfALogWithoutAName) {
  edit("scara.toml", R"(files = ["scara_s2.csv"])", R"(files = [""])");
  expect_refused({"scara.toml:9:10: [log] files must name a file"});
}

TEST_F(Refusal, OfNoLogAtAll) {
  edit("scara.toml", R"(files = ["scara_s2.csv"])", "files = []");
  expect_refused({"scara.toml:9:9: [log] files must name at least one file"});
}

TEST_F(Refusal, NamesTheLineWhereTimeGoesBack) {
  set_cell("scara_s2.csv", 100, 1, "0.1");
  expect_refused({"scara_s2.csv:100 (t = 0.1 s): the time stamps are irregular", "1 reversed", "resample"});
}

TEST_F(Refusal, NamesTheLineOfAGapInTheTime) {
  std::string log = folder().read("scara_s2.csv");
  const std::size_t cut = log.find("\n5,") + 1;
  folder().write("scara_s2.csv", log.erase(cut, log.find("\n5.5,") + 1 - cut));
  expect_refused({"scara_s2.csv:1002 (t = 5.5 s): the time stamps are irregular", "1 jump"});
}

TEST_F(Refusal, OfBinaryRubbishFitsOnOneLine) {
  std::string rubbish;
  for (int i = 0; i < 5000; ++i) {
    rubbish += static_cast<char>(1 + (i * 37) % 255);
  }
  folder().write("scara_s2.csv", rubbish);
  expect_refused({"scara_s2.csv"});
}

TEST_F(Refusal, OfTorquesThatAreAllZero) {
  rewrite_rows("scara_s2.csv",
               [](const std::string& line) { return line.substr(0, line.find(',')) + ",0,0,0,0,0,0"; });
  edit("scara.toml", "trim = 20 ", "rows = \"paper\"\ntrim = 20 ");
  expect_refused(
      {"scara_s2.csv: the torques are zero in every row; check the columns. A log without torque needs the "
       "law and gains"});
}

TEST_F(Refusal, OfATorqueThatIsZeroAndWouldHaveInfiniteWeight) {
  rewrite_rows("scara_s2.csv", [](const std::string& line) {
    std::size_t v2 = 0;
    for (int column = 1; column < 5; ++column) {
      v2 = line.find(',', v2) + 1;
    }
    return line.substr(0, v2) + "0" + line.substr(line.find(',', v2));
  });
  edit("scara.toml", "trim = 20 ", "rows = \"paper\"\ntrim = 20 ");
  expect_refused({"joint \"joint_2\": its torque is zero in every row"}, {"scara.toml", "--method", "wls"});
}

TEST_F(Refusal, OfAPipeInPlaceOfALog) {
  ASSERT_EQ(::mkfifo((folder().path() / "pipe").c_str(), 0600), 0);
  expect_refused({"pipe: is a pipe that nothing came through"}, {"scara.toml", "--log", "pipe"});
}

TEST_F(Refusal, OfPositionsThatOverflow) {
  set_cell("scara_s2.csv", 500, 2, "1e308");
  expect_refused({"scara_s2.csv: joint \"joint_2\": positions or torques are so large that they overflow"});
}

TEST_F(Refusal, OfAScaleThatTorquesOverflowWith) {
  edit("scara.toml", R"(control = ["v1", "v2"])",
       R"(control = [{ column = "v1", scale = 1e300 }, { column = "v2", scale = 1e300 }])");
  expect_refused({"[log.control] scale is 1e+300, must lie between -1e+15 and 1e+15"});
}

TEST_F(Refusal, OfAValidationLogNamesThatLog) {
  set_cell("scara_validation.csv", 1842, 3, "nan");
  expect_refused({"scara_validation.csv:1842:3: column \"q2\" holds \"nan\""});
}

TEST_F(Refusal, OfOtherColumnsInTheValidationLog) {
  edit("scara.toml", R"(files = ["scara_validation.csv"])",
       "files = [\"scara_validation.csv\"]\nposition = [\"a1\", \"a2\"]");
  expect_refused({"scara_validation.csv: there is no column \"a1\""});
}

// Columns

TEST_F(Refusal, OfAWrongNumberOfColumns) {
  edit("scara.toml", R"(position = ["q1", "q2"])", R"(position = ["q1"])");
  expect_refused({"scara.toml:11:12: [log] position names 1 column, must name one for each of the 2 joints"});
}

TEST_F(Refusal, OfAColumnListedTwice) {
  edit("scara.toml", R"(position = ["q1", "q2"])", R"(position = ["q1", "q1"])");
  expect_refused({"scara.toml:11:12: [log] position lists column \"q1\" twice"});
}

TEST_F(Refusal, OfAPositionAsTorque) {
  edit("scara.toml", R"(control = ["v1", "v2"])", R"(control = ["v1", "q2"])");
  expect_refused({"scara.toml:12:11: [log] control lists column \"q2\", which is listed as a position"});
}

TEST_F(Refusal, OfColumnZero) {
  edit("scara.toml", R"(position = ["q1", "q2"])", "position = [0, 1]");
  expect_refused({"scara.toml:11:13: [log] position is column 0; columns count from 1"});
}

TEST_F(Refusal, OfAColumnBehindTheLast) {
  edit("scara.toml", R"(position = ["q1", "q2"])", "position = [2, 99]");
  expect_refused({"scara_s2.csv: there is no column #99; the lines have 7 fields"});
}

TEST_F(Refusal, NamesAnUnknownUnitOfAColumn) {
  edit("scara.toml", R"(["q1", "q2"])", R"([{ column = "q1", unit = "degg" }, "q2"])");
  expect_refused(
      {"scara.toml:11:", "[log.position] unit: \"degg\" is no known unit", "did you mean \"deg\"?"});
}

TEST_F(Refusal, NamesAnUnknownUnitOfAQuantity) {
  edit("scara.toml", R"(time = "t")", "time = \"t\"\nunits = { position = \"degs\" }");
  expect_refused(
      {"scara.toml:11:22: [log.units] position: \"degs\" is no known unit", "did you mean \"deg\"?"});
}

TEST_F(Refusal, OfASignThatIsNone) {
  edit("scara.toml", R"(["q1", "q2"])", R"([{ column = "q1", sign = 2 }, "q2"])");
  expect_refused({"[log.position] sign is 2, must be 1 or -1"});
}

TEST_F(Refusal, OfAMistypedKeyOfAColumn) {
  edit("scara.toml", R"(["q1", "q2"])", R"([{ colum = "q1" }, "q2"])");
  expect_refused({"unknown key \"colum\" in [log.position]; did you mean \"column\"?"});
}

// Robots

TEST_F(Refusal, NamesTheLinkWithANegativeMass) {
  edit("scara.urdf", R"(<mass value="2"/>)", R"(<mass value="-2"/>)");
  expect_refused({"scara.urdf:36: link \"forearm\": mass is -2 kg, must not be negative"});
}

TEST_F(Refusal, NamesTheLinkWithADecimalComma) {
  edit("scara.urdf", R"(<mass value="2"/>)", R"(<mass value="1,5"/>)");
  expect_refused({"scara.urdf:36: link \"forearm\": <mass value=\"1,5\"> must be a finite number"});
}

TEST_F(Refusal, NamesTheLinkWithAnImpossibleInertia) {
  edit("scara.urdf", R"(izz="0.03262")", R"(izz="-1")");
  expect_refused({"scara.urdf:37: link \"forearm\": its inertia is not positive semidefinite"});
}

TEST_F(Refusal, NamesTheJointWithAZeroAxis) {
  edit("scara.urdf", "<axis xyz=\"0 0 1\"/>\n    <limit lower=\"-4.5\"",
       "<axis xyz=\"0 0 0\"/>\n    <limit lower=\"-4.5\"");
  expect_refused({"scara.urdf:", "joint \"joint_2\": its axis is \"0 0 0\", must not be zero"});
}

TEST_F(Refusal, OfAXacroFileTellsHowToExpandIt) {
  edit(
      "scara.urdf", R"(<robot name="scara">)",
      R"(<robot name="scara" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="a" value="1"/>)");
  expect_refused({"scara.urdf:8: <xacro:property> is not URDF; this is a xacro file, expand it first"});
}

TEST_F(Refusal, OfARobotFileThatIsNoXml) {
  edit("scara.toml", R"(urdf = "scara.urdf")", R"(urdf = "scara_s2.csv")");
  expect_refused({"scara_s2.csv: is not XML, must be a URDF"});
}

TEST_F(Refusal, OfAMissingRobotFile) {
  edit("scara.toml", R"(urdf = "scara.urdf")", R"(urdf = "nope.urdf")");
  expect_refused({"nope.urdf: there is no such file"});
}

TEST_F(Refusal, OfARobotFileWithoutAName) {
  edit("scara.toml", R"(urdf = "scara.urdf")", R"(urdf = "")");
  expect_refused({"scara.toml:3:8: [robot] urdf must name a file"});
}

TEST_F(Refusal, OfTwoRobots) {
  edit("scara.toml", R"(urdf = "scara.urdf")", "urdf = \"scara.urdf\"\nmdh = \"scara.csv\"");
  expect_refused({"scara.toml:2:1: [robot] names both urdf and mdh, must name one"});
}

TEST_F(Refusal, OfABaseForATable) {
  edit("scara.toml", R"(urdf = "scara.urdf")", "mdh = \"scara.csv\"\nbase = \"arm\"");
  expect_refused({"scara.toml:4:8: [robot] base goes with urdf"});
}

TEST_F(Refusal, OfALinkThatTheRobotLacks) {
  edit("scara.toml", R"(urdf = "scara.urdf")", "urdf = \"scara.urdf\"\ntip = \"fore_arm\"");
  expect_refused({"scara.urdf: tip is \"fore_arm\", but no link is called so; did you mean \"forearm\"?"});
}

TEST_F(Refusal, OfAnUnknownJointListsTheJoints) {
  edit("scara.toml", "joints.joint_2 =", "joints.jonit_2 =");
  expect_refused(
      {"scara.toml:6:", "jonit_2 is no joint of robot \"scara\", which has \"joint_1\" and \"joint_2\"",
       "did you mean \"joint_2\"?"});
}

TEST_F(Refusal, OfADriveGainOfZeroNamesTheJoint) {
  edit("scara.toml", "gravity =", "drive_gain = [1.0, 0.0]\ngravity =");
  expect_refused({"[robot] joint \"joint_2\": drive_gain", "not zero"});
}

TEST_F(Refusal, OfLengthsThatOverflowNamesTheJoint) {
  edit("scara.urdf", R"(<origin xyz="0.5 0 0" rpy="0 0 0"/>)", R"(<origin xyz="1e200 0 0" rpy="0 0 0"/>)");
  expect_refused(
      {"scara.urdf: ",
       "joint \"joint_2\": its frame lies 1e+200 m from the one before, must be at most 1000000 m"});
}

TEST_F(Refusal, OfAGravityThatOverflows) {
  edit("scara.toml", "gravity = [0, 0, -9.81]", "gravity = [1e10, 0, -9.81]");
  expect_refused({"gravity is 1e+10 m/s², must be at most 1000000"});
}

TEST_F(Refusal, OfTwoJointsOfOneNameInATable) {
  folder().write("twins.csv", "joint,type,alpha,a,d,theta\na,R,0,0,0,0\na,R,0,0.5,0,0\n");
  folder().write("twins.toml",
                 "[robot]\nmdh = \"twins.csv\"\n[log]\nfiles = \"scara_s2.csv\"\n[signal]\ncutoff_hz = 20\n");
  expect_refused({"twins.csv: ", "two joints are called \"a\"; names must differ"}, {"twins.toml"});
}

TEST_F(Refusal, NamesTheLineOfATableThatIsNoNumber) {
  folder().write("table.csv", "\xEF\xBB\xBFjoint,type,alpha,a,d,theta\n1,R,0,0,0,0\n2,R,0,1;5,0,0\n");
  folder().write("table.toml",
                 "[robot]\nmdh = \"table.csv\"\n[log]\nfiles = \"scara_s2.csv\"\n[signal]\ncutoff_hz = 20\n");
  expect_refused({"table.csv:3: 7 fields, the header has 6"}, {"table.toml"});
}

// The experiment file

TEST_F(Refusal, OfAnUnknownKeySuggestsTheRightOne) {
  edit("scara.toml", "decimation = 20", "decimaton = 14");
  expect_refused({"scara.toml:20:1: unknown key \"decimaton\" in [signal]; did you mean \"decimation\"?"});
}

TEST_F(Refusal, OfAMistypedRequiredKeySuggestsTheRightOne) {
  edit("scara.toml", "cutoff_hz = 20", "cuttoff_hz = 20");
  expect_refused({"scara.toml:17:1: unknown key \"cuttoff_hz\" in [signal]; did you mean \"cutoff_hz\"?"});
}

TEST_F(Refusal, OfAMistypedSectionSuggestsTheRightOne) {
  edit("scara.toml", "[signal]", "[singal]");
  expect_refused({"scara.toml:16:", "unknown key \"singal\"; did you mean \"signal\"?"});
}

TEST_F(Refusal, OfAnUnknownKeyOfAJoint) {
  edit("scara.toml", "joints.joint_2 = { friction", "joints.joint_2 = { fricton");
  expect_refused(
      {"scara.toml:6:20: unknown key \"fricton\" in [robot.joints.joint_2]; did you mean \"friction\"?"});
}

TEST_F(Refusal, OfAMissingSection) {
  std::string text = folder().read("scara.toml");
  const std::size_t log = text.find("[log]");
  folder().write("scara.toml", text.erase(log, text.find("[signal]") - log));
  expect_refused({"scara.toml: section [log] is missing"});
}

TEST_F(Refusal, OfASyntaxErrorNamesLineAndColumn) {
  edit("scara.toml", "order = 4", "order = = 4");
  expect_refused({"scara.toml:18:9: "});
}

TEST_F(Refusal, OfAKeyWrittenTwice) {
  edit("scara.toml", "order = 4", "order = 4\norder = 5");
  expect_refused({"scara.toml:19:", "'order'"});
}

TEST_F(Refusal, OfAWrongTypeSaysWhichIsRight) {
  edit("scara.toml", "decimation = 20", "decimation = 1.5");
  expect_refused({"scara.toml:20:14: [signal] decimation must be a whole number"});
}

TEST_F(Refusal, OfANumberInQuotes) {
  edit("scara.toml", "cutoff_hz = 20", "cutoff_hz = \"20\"");
  expect_refused({"scara.toml:17:13: [signal] cutoff_hz must be a frequency in Hz"});
}

TEST_F(Refusal, OfAMissingExperimentFile) {
  expect_refused({"nope.toml: the experiment file can not be read: there is no such file"}, {"nope.toml"});
}

TEST_F(Refusal, OfAFolderInPlaceOfTheExperimentFile) {
  expect_refused({".: is a directory, a file is required"}, {"."});
}

TEST_F(Refusal, OfALogInPlaceOfTheExperimentFile) {
  expect_refused({"scara_s2.csv: is a log, an experiment file is required"}, {"scara_s2.csv"});
}

// Settings

TEST_F(Refusal, OfACutOffAboveHalfTheRateNamesBoth) {
  edit("scara.toml", "cutoff_hz = 20", "cutoff_hz = 150");
  expect_refused({"scara_s2.csv: cutoff_hz is 150 Hz, must lie below f_m / 2 = 100 Hz"});
}

TEST_F(Refusal, OfATorqueCutOffAboveHalfTheRateNamesItsKey) {
  edit("scara.toml", "cutoff_hz = 20", "cutoff_hz = 20\ntorque_cutoff_hz = 100");
  expect_refused({"scara_s2.csv: torque_cutoff_hz is 100 Hz, must lie below f_m / 2 = 100 Hz"});
}

TEST_F(Refusal, OfAnOrderThatNoFilterHas) {
  edit("scara.toml", "order = 4", "order = 1000000000");
  expect_refused({"scara.toml:18:9: [signal] order is 1000000000, must lie between 1 and 20"});
}

TEST_F(Refusal, OfANumberThatWouldWrapAround) {
  edit("scara.toml", "order = 4", "order = 4294967300");
  expect_refused({"scara.toml:18:9: [signal] order is 4294967300, that is out of range"});
}

TEST_F(Refusal, OfANegativeDecimation) {
  edit("scara.toml", "decimation = 20", "decimation = -3");
  expect_refused({"scara.toml:20:14: [signal] decimation is -3, must be at least 1"});
}

TEST_F(Refusal, OfADecimationThatLeavesNothing) {
  edit("scara.toml", "decimation = 20", "decimation = 1000000");
  expect_refused({"scara_s2.csv: decimation by 1000000 meets 3961 samples"});
}

TEST_F(Refusal, OfATrimThatLeavesNothing) {
  edit("scara.toml", "trim = 20 ", "trim = 2001 ");
  expect_refused(
      {"scara_s2.csv: no row is left of 4001 samples after trimming 2001 at the beginning and 2001 at the "
       "end"});
}

TEST_F(Refusal, OfAWindowBesideTheLogTellsItsSpan) {
  edit("scara.toml", "cutoff_hz = 20", "cutoff_hz = 20\nwindow = [100, 200]");
  expect_refused({"scara_s2.csv: no row is left", "time window 100 to 200 s", "the log spans 0 to 20 s"});
}

TEST_F(Refusal, OfAVelocityThresholdThatNoRowReachesNamesTheJoint) {
  edit("scara.toml", "trim = 20 ", "rows = \"paper\"\nvelocity_threshold = [0.1, 50] ");
  expect_refused({"scara_s2.csv: joint \"joint_2\" never moves faster than velocity_threshold 50"});
}

TEST_F(Refusal, OfAVelocityThresholdForTooManyJoints) {
  edit("scara.toml", "trim = 20 ", "velocity_threshold = [0.1, 0.1, 0.1] ");
  expect_refused(
      {"scara.toml:21:22: [signal] velocity_threshold has 3 entries, must have one for each of the 2 "
       "joints"});
}

TEST_F(Refusal, OfResamplingToARateThatNoMemoryHolds) {
  edit("scara.toml", "\n\n[signal]", "\nresample_hz = 1e9\n\n[signal]");
  expect_refused({"scara_s2.csv: resampling to 1e+09 Hz, recorded at 200 Hz; at most 100 times"});
}

TEST_F(Refusal, OfANegativeResamplingRateNamesItsKey) {
  edit("scara.toml", "\n\n[signal]", "\nresample_hz = -5\n\n[signal]");
  expect_refused({"scara.toml:15:15: [log] resample_hz is -5 Hz, must be positive"});
}

// The command line

TEST_F(Refusal, OfNoArguments) { expect_refused({"experiment is required", "--help"}, {}); }

TEST_F(Refusal, OfAnUnknownMethodListsTheMethods) {
  expect_refused(
      {"--method: \"lms\" is none of \"auto\", \"ols\", \"wls\", \"iv\", \"didim\" and \"output_error\""},
      {"scara.toml", "--method", "lms"});
}

TEST_F(Refusal, OfAnUnknownMethodInTheExperimentFile) {
  edit("scara.toml", R"(name = "wls")", R"(name = "lms")");
  expect_refused(
      {"scara.toml:24:8: [method] name is \"lms\", must be one of \"ols\", \"wls\", \"iv\", \"auto\", "
       "\"didim\" and \"output_error\""});
}

TEST_F(Refusal, OfAnUnknownFlag) { expect_refused({"--foo"}, {"scara.toml", "--foo"}); }

TEST_F(Refusal, OfAFlagWithoutItsFile) { expect_refused({"--log"}, {"scara.toml", "--log"}); }

TEST_F(Refusal, OfAMissingLogOnTheCommandLine) {
  expect_refused({"nope.csv: there is no such file"}, {"scara.toml", "--log", "nope.csv"});
}

TEST_F(Refusal, OfAnOutputFolderThatIsAFile) {
  expect_refused({"scara.urdf/result.json: can not be written: Not a directory"},
                 {"scara.toml", "--output", "scara.urdf"});
}

TEST_F(Refusal, OfAnOutputFolderBelowAFile) {
  expect_refused({"scara.urdf/x/result.json: can not be written"},
                 {"scara.toml", "--output", "scara.urdf/x"});
}

TEST_F(Refusal, OfAnOutputFolderThatIsReadOnly) {
  std::filesystem::create_directory(folder().path() / "locked");
  ::chmod((folder().path() / "locked").c_str(), 0500);
  if (::geteuid() == 0) {
    GTEST_SKIP() << "root may write everywhere";
  }
  expect_refused({"locked/result.json: can not be written: Permission denied"},
                 {"scara.toml", "--output", "locked"});
}

TEST_F(Refusal, StaysOnOneLineForANameOfTwoLines) {
  expect_refused({"two?lines.toml: the experiment file can not be read"}, {"two\nlines.toml"});
}

TEST_F(Refusal, HappensInADryRunAsWell) {
  edit("scara.toml", "cutoff_hz = 20", "cutoff_hz = 150");
  expect_refused({"cutoff_hz is 150 Hz"}, {"scara.toml", "--dry-run"});
}

TEST_F(Refusal, IsToldWhenQuiet) {
  edit("scara.toml", "cutoff_hz = 20", "cutoff_hz = 150");
  expect_refused({"cutoff_hz is 150 Hz"}, {"scara.toml", "--quiet"});
}

TEST_F(Refusal, LeavesAnEarlierResultAlone) {
  ASSERT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0);
  const std::string earlier = folder().read("scara_result/result.json");
  set_cell("scara_s2.csv", 1842, 3, "nan");
  expect_refused({"scara_s2.csv:1842:3"});
  EXPECT_EQ(folder().read("scara_result/result.json"), earlier);
}

}  // namespace
