// The program rivid: its subcommands, and the tools that are links to it.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;

class OneProgram : public rivid::test::IdentifyTool {
 protected:
  [[nodiscard]] Outcome rivid(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), RIVID_PROGRAM);
    return rivid::test::outcome_of(arguments, folder().path());
  }

  void expect_refused_as_rivid(const std::vector<std::string>& arguments, std::string_view words) const {
    std::vector<std::string> command = arguments;
    command.insert(command.begin(), RIVID_PROGRAM);
    expect_refused_by("rivid", command, {words});
  }
};

TEST_F(OneProgram, PrintsItsHelpWithoutAnArgument) {
  const Outcome alone = rivid({});
  EXPECT_EQ(alone.exit_code, 0);
  for (const char* const word :
       {"init", "check", "identify", "validate", "compare", "payload", "export", "excite", "simulate",
        "study", "online", "convert", "play", "explain", "demo"}) {
    EXPECT_NE(alone.out.find("\nrivid " + std::string(word) + " "), std::string::npos) << word;
  }
  EXPECT_LE(std::ranges::count(alone.out, '\n'), 40);
  EXPECT_EQ(rivid({"help"}).out, alone.out);
  EXPECT_EQ(rivid({"--help"}).out, alone.out);
}

TEST_F(OneProgram, HasTheToolsAsSubcommandsInItsOwnWords) {
  const Outcome check = rivid({"check", "scara.toml"});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_EQ(check.out, identify({"check", "scara.toml"}).out);
  const Outcome help = rivid({"help", "init"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.out, rivid({"init", "--help"}).out);
  EXPECT_NE(help.out.find("rivid init [OPTIONS]"), std::string::npos) << help.out;
  EXPECT_EQ(help.out.find("rivid_identify"), std::string::npos) << help.out;
  EXPECT_EQ(identify({"help", "init"}).out, help.out);
  EXPECT_TRUE(rivid({"--version"}).out.starts_with("rivid "));
  expect_refused_as_rivid({"scara_s2.csv"}, "\"scara_s2.csv\" is no subcommand");
  expect_refused_as_rivid({"identify", "scara_s2.csv"}, "rivid init ROBOT.urdf scara_s2.csv writes one");
}

TEST_F(OneProgram, SaysWhatWasMeant) {
  expect_refused_as_rivid({"chek", "scara.toml"}, "\"chek\" is no subcommand; did you mean \"check\"?");
  expect_refused_as_rivid({"scara.toml"}, "rivid identify scara.toml identifies the robot");
  expect_refused_as_rivid({"scara.urdf", "scara_s2.csv"}, "rivid identify scara.urdf LOG.csv identifies it");
}

TEST_F(OneProgram, PrintsJsonThoughItIsQuiet) {
  const Outcome result = rivid({"identify", "scara.toml", "--json", "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(Json::parse(result.out).at("status"), "identified");
  EXPECT_EQ(result.out, folder().read("scara_result/result.json"));
  const Outcome check = rivid({"check", "scara.toml", "--json", "--quiet"});
  EXPECT_TRUE(Json::parse(check.out).at("usable").get<bool>());
  EXPECT_EQ(rivid({"identify", "scara.toml", "--quiet"}).out, "");
}

TEST_F(OneProgram, IdentifiesFromARobotAndItsLogs) {
  const std::vector<std::string> command = {"identify", "scara.urdf", "scara_s2.csv", "scara_validation.csv",
                                            "--report"};
  expect_refused_as_rivid(command,
                          "scara.toml: is there already; rivid identify scara.toml identifies from it");
  std::filesystem::remove(folder().path() / "scara.toml");
  const Outcome run = rivid(command);
  EXPECT_LT(run.exit_code, 2) << run.err;
  EXPECT_NE(run.err.find("wrote scara.toml"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("open " + (folder().path() / "scara_result/report.html").string()),
            std::string::npos)
      << run.err;
  EXPECT_NE(run.out.find("torque error on scara_validation.csv"), std::string::npos) << run.out;
  EXPECT_TRUE(std::filesystem::exists(folder().path() / "scara_result/report.html"));
}

TEST_F(OneProgram, KeepsQuietAndWritesNothingWhereThatIsAsked) {
  std::filesystem::remove(folder().path() / "scara.toml");
  const Outcome dry = rivid({"identify", "scara.urdf", "scara_s2.csv", "--dry-run"});
  EXPECT_NE(dry.out.find("urdf = \"scara.urdf\""), std::string::npos) << dry.out;
  EXPECT_FALSE(std::filesystem::exists(folder().path() / "scara.toml"));
  const Outcome quiet = rivid({"identify", "scara.urdf", "scara_s2.csv", "--quiet"});
  EXPECT_EQ(quiet.out + quiet.err, "");
  EXPECT_TRUE(std::filesystem::exists(folder().path() / "scara_result/result.json"));
}

TEST_F(OneProgram, ShowsADemo) {
  const Outcome run = rivid({"demo", "shown"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("$ rivid simulate shown/simulate.toml"), std::string::npos) << run.err;
  EXPECT_NE(run.out.find("52 base parameters"), std::string::npos) << run.out;
  EXPECT_TRUE(run.err.ends_with("open " + (folder().path() / "shown/result/report.html").string() + "\n"))
      << run.err;
  const Outcome again = rivid({"demo", "shown"});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.err.find("is there already"), std::string::npos) << again.err;
  const Outcome forced = rivid({"demo", "shown", "--force"});
  EXPECT_EQ(forced.exit_code, 0) << forced.err;
}

}  // namespace
