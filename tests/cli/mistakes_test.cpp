// Thirty typical mistakes on the command line, and the answers that they get.

#include <gtest/gtest.h>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Outcome;

class Mistake : public rivid::test::IdentifyTool {
 protected:
  void expect_answer(const std::vector<std::string>& arguments, std::string_view answer) const {
    expect_refused({answer}, arguments);
  }
};

TEST_F(Mistake, InTheNameOfAFileOrASubcommand) {
  EXPECT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0);
  expect_answer({}, "experiment is required; --help prints the usage");
  expect_answer({"scara.tml"}, "scara.tml: the experiment file can not be read: there is no such file");
  expect_answer({"scara_s2.csv"},
                "scara_s2.csv: is a log, an experiment file is required; rivid init "
                "ROBOT.urdf scara_s2.csv writes one");
  expect_answer({"scara.urdf"},
                "scara.urdf: is a robot, an experiment file is required; rivid init "
                "scara.urdf LOG.csv writes one");
  expect_answer({"check", "scara.urdf"}, "scara.urdf: is a robot, an experiment file is required");
  expect_answer({"scara_result/result.json"},
                "scara_result/result.json: is a result, an experiment file is required; rivid validate "
                "and rivid export take results");
  expect_answer({"exprot", "scara_result", "--to", "mjcf"},
                "\"exprot\" is neither a file nor a subcommand; did you mean \"export\"?");
  expect_answer({"validat", "scara_result", "scara_s2.csv"}, "did you mean \"validate\"?");
  expect_answer({"scara.toml", "second.toml"}, "\"second.toml\" is one argument too many");
  expect_answer({"scara.toml", "--log", "scara_s3.csv"}, "scara_s3.csv: there is no such file");
  expect_answer({"export", "scara.toml", "--to", "header"},
                "scara.toml: is no result.json of rivid identify");
}

TEST_F(Mistake, InAWordOfOtherPrograms) {
  EXPECT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0);
  expect_answer({"scara.toml", "--set", "decimation=5"},
                "unknown key \"decimation\"; did you mean \"signal.decimation\"?");
  expect_answer({"scara.toml", "--set", "signal.filter_hz=5"},
                "unknown key \"filter_hz\" in [signal]; did you mean \"cutoff_hz\"?");
  expect_answer({"scara.toml", "--set", "filter_hz=5"}, "did you mean \"signal.cutoff_hz\"?");
  EXPECT_TRUE(identify({"help", "init"}).out.starts_with("Writes an experiment file"));
  edit("scara.toml", "control = [\"v1\", \"v2\"]", "control = [\"v1\", { column = \"v2\", sign = -1 }]");
  EXPECT_NE(identify({"check", "scara.toml"}).out.find("in [log]: control = [\"v1\", \"v2\"]"),
            std::string::npos);
  expect_answer({"scara.toml", "--plot"}, "did you mean \"--report\"?");
  expect_answer({"export", "scara_result", "--to", "gazebo"}, "did you mean \"sdf\"?");
  expect_answer({"scara.toml", "—report"}, "begins with a long dash; did you mean \"--report\"?");
  expect_answer({"scara.toml", "–q"}, "did you mean \"-q\"?");
  folder().write("scara.yaml", "robot: scara.urdf\n");
  expect_answer({"scara.yaml"}, "scara.yaml: is YAML, experiment files are TOML; rivid init");
  expect_answer({"validate", "scara_result", "scara.toml"},
                "scara.toml: is an experiment file, a log is required");
  expect_answer({"validate", "no_result", "scara_s2.csv"}, "no_result: there is no such file");
  expect_answer({"validate", "scara.toml", "scara_s2.csv"},
                "scara.toml: is an experiment file, a result or parameters are required; rivid identify "
                "scara.toml writes the result");
  folder().write("bag/metadata.yaml", "rosbag2_bagfile_information:\n");
  expect_answer(
      {"scara.toml", "--log", "bag"},
      "bag: is the folder of a bag, a CSV file is required; the Python package rivid[ros] makes one: "
      "rivid convert bag bag.csv");
}

TEST_F(Mistake, InTheNameOfAnOption) {
  EXPECT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0);
  expect_answer({"scara.toml", "--metod", "wls"},
                "\"--metod\" is no option of rivid identify; did you mean \"--method\"?");
  expect_answer({"scara.toml", "--metod=wls"}, "did you mean \"--method\"?");
  expect_answer({"scara.toml", "--thread", "2"}, "did you mean \"--threads\"?");
  expect_answer({"check", "scara.toml", "--jsn"},
                "\"--jsn\" is no option of rivid check; did you mean \"--json\"?");
  expect_answer({"scara.toml", "-Q"}, "\"-Q\" is no option of rivid identify; --help prints the usage");
  expect_answer({"scara.toml", "--write-urdf", "x.urdf"},
                "--write-urdf is now rivid export RESULT --to urdf");
  expect_answer({"scara.toml", "--sidecar", "drake"},
                "--sidecar is now rivid export RESULT --to mjcf|drake|pinocchio");
  expect_answer({"export", "scara_result"}, "--to is required");
  expect_answer({"validate", "scara_result"}, "logs is required");
}

TEST_F(Mistake, InAValue) {
  EXPECT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0);
  expect_answer({"scara.toml", "--method", "least-squares"},
                "--method: \"least-squares\" is none of \"auto\", \"ols\", \"wls\", \"iv\", \"didim\" and "
                "\"output_error\"");
  expect_answer({"scara.toml", "--robust", "hubber"}, "did you mean \"huber\"?");
  expect_answer({"export", "scara_result", "--to", "pinochio"}, "did you mean \"pinocchio\"?");
  expect_answer({"scara.toml", "--threads", "many"}, "--threads");
  expect_answer({"scara.toml", "--color", "sometimes"},
                "--color: \"sometimes\" is none of \"auto\", \"always\" and "
                "\"never\"");
  expect_answer({"scara.toml", "--set", "signal.cutof_hz=3"},
                "--set signal.cutof_hz=3: unknown key \"cutof_hz\" in [signal]; did you mean \"cutoff_hz\"?");
  expect_answer({"scara.toml", "--set", "signal.cutoff_hz"},
                "is no setting; a key and its value are required: signal.decimation=5");
  expect_answer({"explain", "torque_sgn"}, "did you mean \"torque_sign\"?");
  expect_answer({"export", "scara_result", "--to", "urdf"}, "identify with --physical");
}

TEST_F(Mistake, InTheExperimentFile) {
  const std::string good = folder().read("scara.toml");
  const auto with = [&](std::string_view from, std::string_view to) {
    folder().write("scara.toml", good);
    edit("scara.toml", from, to);
  };
  with("\"v1\"", "\"v11\"");
  expect_answer({"scara.toml"}, "did you mean \"v1\"?");
  with("[signal]", "[signal]\ntorque_cutoff_hz = off  # no filter");
  expect_answer({"scara.toml"}, "; a word needs quotes: torque_cutoff_hz = \"off\"");
  with("\"scara.urdf\"", "\"scara.udrf\"");
  expect_answer({"scara.toml"}, "scara.udrf");
}

TEST_F(Mistake, IsNoneInWhatIsShort) {
  EXPECT_EQ(identify({"scara.toml", "-q", "-o", "out", "--threads", "0"}).exit_code, 0);
  EXPECT_FALSE(folder().read("out/result.json").empty());
  const Outcome verbose = identify({"scara.toml", "-v"});
  EXPECT_EQ(verbose.exit_code, 0);
  EXPECT_TRUE(verbose.err.starts_with("robot       scara.urdf: ")) << verbose.err;
}

TEST_F(Mistake, IsColouredWhereThatIsAskedFor) {
  EXPECT_NE(identify({"no.toml", "--color=always"}).err.find("\033[1;31merror\033[0m: no.toml"),
            std::string::npos);
  EXPECT_EQ(identify({"no.toml"}).err.find('\033'), std::string::npos);
  EXPECT_EQ(identify({"no.toml", "--color", "never"}).err.find('\033'), std::string::npos);
}

}  // namespace
