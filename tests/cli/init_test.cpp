// rivid init: from a URDF and logs to an experiment file that is run as it is.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Outcome;

class Init : public rivid::test::IdentifyTool {};

TEST_F(Init, WritesAFileThatIsIdentifiedAsItIs) {
  const Outcome made =
      identify({"init", "scara.urdf", "scara_s2.csv", "scara_validation.csv", "--output", "new.toml"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(made.out, "");
  EXPECT_NE(made.err.find("wrote new.toml\n"), std::string::npos) << made.err;
  const Outcome run = identify({"new.toml"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("torque error on scara_validation.csv"), std::string::npos) << run.out;
  // The law that the logs chose, and what it leaves of the validation log.
  EXPECT_NE(run.err.find("friction (Fv Fc off"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("of the validation logs"), std::string::npos) << run.err;
}

TEST_F(Init, PrintsTheSameTextAndWritesNothing) {
  EXPECT_EQ(identify({"init", "scara.urdf", "scara_s2.csv", "--output", "new.toml"}).exit_code, 0);
  const std::vector<std::string> before = folder().entries();
  const Outcome printed = identify({"init", "scara.urdf", "scara_s2.csv", "--output", "new.toml", "--print"});
  EXPECT_EQ(printed.exit_code, 0);
  EXPECT_EQ(printed.out, folder().read("new.toml"));
  EXPECT_EQ(folder().entries(), before);
}

TEST_F(Init, WritesOverNothing) {
  expect_refused({"scara.toml: is there already", "--force"}, {"init", "scara.urdf", "scara_s2.csv"});
  EXPECT_EQ(identify({"init", "scara.urdf", "scara_s2.csv", "--force"}).exit_code, 0);
  EXPECT_EQ(identify({"scara.toml"}).exit_code, 0);
}

TEST_F(Init, SaysWhatIsMissingAndExitsWithOne) {
  folder().write("log.csv", "t,a1,a2\n0,1,2\n0.001,1,2\n");
  const Outcome run = identify({"init", "scara.urdf", "log.csv", "--output", "new.toml"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("no columns of positions were recognised"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("wrote new.toml, incomplete\n"), std::string::npos) << run.err;
}

TEST_F(Init, WritesADesignWithoutALog) {
  const Outcome run = identify({"init", "scara.urdf", "--output", "new.toml"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("next: rivid excite new.toml --output plan --report\n"), std::string::npos)
      << run.err;
  EXPECT_NE(folder().read("new.toml").find("[excitation.space]\n"), std::string::npos);
}

TEST_F(Init, TakesSecondsAndNanosecondsTogether) {
  std::string log = "header.stamp.sec,header.stamp.nanosec,q1,q2,v1,v2\n";
  for (int k = 0; k < 500; ++k) {
    log += std::to_string(1700000000 + k / 100) + "," + std::to_string(k % 100 * 10000000) + "," +
           std::to_string(std::sin(0.03 * k)) + "," + std::to_string(std::cos(0.05 * k)) + ",1,2\n";
  }
  folder().write("log.csv", log);
  const Outcome run = identify({"init", "scara.urdf", "log.csv", "--print"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("time = \"header.stamp.sec\""), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("500 samples at 100 Hz; jitter 0 %"), std::string::npos) << run.out;
  EXPECT_EQ(run.err.find("may be"), std::string::npos) << run.err;
}

TEST_F(Init, IsNamedToWhoGivesARobotInstead) {
  expect_refused({"scara.urdf: is a robot", "rivid init scara.urdf LOG.csv"}, {"scara.urdf"});
  // A robot with its logs is drafted for, where there is no experiment file yet.
  expect_refused({"scara.toml: is there already; rivid identify scara.toml identifies from it"},
                 {"scara.urdf", "scara_s2.csv"});
  expect_refused({"scara.urdf: is a robot, which comes before the logs"},
                 {"init", "scara_s2.csv", "scara.urdf", "--output", "new.toml"});
}

TEST_F(Init, RefusesWhatCanNotBeRead) {
  expect_refused({"missing.csv"}, {"init", "scara.urdf", "missing.csv", "--output", "new.toml"});
  expect_refused({"missing.urdf"}, {"init", "missing.urdf", "scara_s2.csv", "--output", "new.toml"});
  expect_refused({"no_link"},
                 {"init", "scara.urdf", "scara_s2.csv", "--tip", "no_link", "--output", "new.toml"});
}

}  // namespace
