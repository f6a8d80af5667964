// rivid_online: a log replayed as a control loop would have seen it.

#include <gtest/gtest.h>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Outcome;

class Online : public rivid::test::IdentifyTool {
 protected:
  Online() { EXPECT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0); }

  [[nodiscard]] static std::vector<std::string> command(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), RIVID_ONLINE);
    return arguments;
  }
  [[nodiscard]] Outcome online(std::vector<std::string> arguments) const {
    return rivid::test::outcome_of(command(std::move(arguments)), folder().path());
  }
  void expect_refused_online(const std::vector<std::string>& arguments,
                             const std::vector<std::string_view>& words) const {
    expect_refused_by("rivid_online", command(arguments), words);
  }
};

TEST_F(Online, ReplaysALogIntoATableAndAPage) {
  const Outcome run = online({"scara_validation.csv", "--result", "scara_result/result.json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(run.out.starts_with("scara_validation.csv, 200 Hz\n")) << run.out;
  EXPECT_NE(run.out.find("at the end: no payload (less than "), std::string::npos) << run.out;
  EXPECT_TRUE(run.err.ends_with(
      "wrote scara_validation_online/online.csv\nwrote scara_validation_online/online.html\n"))
      << run.err;
  const std::string table = folder().read("scara_validation_online/online.csv");
  EXPECT_TRUE(table.starts_with("t,mass,mass_half_width,"));
  // A record each 0.05 s, and the header.
  const auto samples = std::ranges::count(folder().read("scara_validation.csv"), '\n') - 1;
  EXPECT_EQ(std::ranges::count(table, '\n'), (samples + 9) / 10 + 1);
  EXPECT_TRUE(folder().read("scara_validation_online/online.html").starts_with("<!DOCTYPE html>"));
}

TEST_F(Online, TakesColumnsFromTheExperimentFileAndTheFolderOfAResult) {
  std::string log = folder().read("scara_validation.csv");
  log.replace(0, log.find('\n'), "time,a,b,c,d,e,f");
  folder().write("other.csv", log);
  edit("scara.toml", "time = \"t\"", "time = \"time\"");
  edit("scara.toml", "position = [\"q1\", \"q2\"]", "position = [\"a\", \"b\"]");
  edit("scara.toml", "control = [\"v1\", \"v2\"]", "control = [\"c\", \"d\"]");
  edit("scara.toml", "reference = [\"qref1\", \"qref2\"]", "reference = [\"e\", \"f\"]");
  const Outcome run = online(
      {"other.csv", "--result", "scara_result", "--experiment", "scara.toml", "--quiet", "--output", "out"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out + run.err, "");
  const Outcome plain = online({"scara_validation.csv", "--result", "scara_result", "--output", "plain"});
  EXPECT_EQ(plain.exit_code, 0) << plain.err;
  EXPECT_EQ(folder().read("out/online.csv"), folder().read("plain/online.csv"));
}

TEST_F(Online, SparesItsExperimentFile) {
  const std::string experiment = folder().read("scara.toml");
  folder().write("scara.csv", experiment);
  std::filesystem::create_directory(folder().path() / "out");
  std::filesystem::create_symlink("../scara.csv", folder().path() / "out/online.csv");
  expect_refused_online(
      {"scara_validation.csv", "--result", "scara_result", "--experiment", "scara.csv", "--output", "out"},
      {"out/online.csv: is an input of this run (scara.csv)"});
  EXPECT_EQ(folder().read("scara.csv"), experiment);
}

TEST_F(Online, RefusesWhatItCanNotReplay) {
  expect_refused_online({"scara_validation.csv"}, {"--result is required"});
  expect_refused_online({"scara_validation.csv", "--result", "none.json"}, {"none.json"});
  expect_refused_online({"none.csv", "--result", "scara_result"}, {"none.csv"});
  expect_refused_online({"scara_validation.csv", "--result", "scara_result", "--learn", "soon"},
                        {"--learn: \"soon\" must be a number"});
  expect_refused_online({"scara_validation.csv", "--result", "scara_result", "--gains", "1e300"},
                        {"--gains: it is 1e+300 %, must be at most 100"});
  expect_refused_online({"scara_validation.csv", "--result", "scara_result", "--learn", "1e300"},
                        {"--learn: it is 1e+300 s, must be at most 1000000"});
  expect_refused_online({"scara_validation.csv", "--result", "scara_result", "--gain", "1"},
                        {"\"--gain\" is no option of rivid online; did you mean \"--gains\"?"});
  expect_refused_online({"a.csv", "b.csv", "--result", "scara_result"}, {"is one argument too many"});
}

TEST_F(Online, AResultThatIsNotIdentifiedNeedsForce) {
  edit("scara_result/result.json", "\"status\": \"identified\"", "\"status\": \"doubtful\"");
  expect_refused_online({"scara_validation.csv", "--result", "scara_result"}, {"doubtful"});
  EXPECT_EQ(online({"scara_validation.csv", "--result", "scara_result", "--force", "--quiet"}).exit_code, 0);
}

TEST_F(Online, ReplacesTablesOfOthersByForceAlone) {
  const std::vector<std::string> command = {
      "scara_validation.csv", "--result", "scara_result", "--output", "out", "--quiet"};
  for (int run = 0; run < 2; ++run) {
    EXPECT_NE(online(command).exit_code, 2);
  }
  folder().write("out/online.csv", "mine");
  const Outcome refused = online(command);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("online.csv: is there already"), std::string::npos) << refused.err;
  std::vector<std::string> forced = command;
  forced.emplace_back("--force");
  EXPECT_NE(online(forced).exit_code, 2);
  EXPECT_NE(folder().read("out/online.csv"), "mine");
}

}  // namespace
