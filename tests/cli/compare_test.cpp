// rivid compare and validate: models judged on logs.

#include <gtest/gtest.h>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;

class Compare : public rivid::test::IdentifyTool {
 protected:
  Compare() { EXPECT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0); }

  [[nodiscard]] Json compared(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "compare");
    arguments.emplace_back("--json");
    const Outcome run = identify(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return Json::parse(run.out);
  }
};

TEST_F(Compare, ValidateHasTheErrorsThatTheResultHas) {
  const Outcome run = identify({"validate", "scara_result", "scara_validation.csv", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json comparison = Json::parse(run.out);
  const Json validation = Json::parse(folder().read("scara_result/result.json"))["validation"][0];
  ASSERT_EQ(comparison["models"].size(), 1U);
  // Sums of squares in another order.
  constexpr double rounding = 1e-12;
  const double error = validation["relative_error"];
  EXPECT_NEAR(comparison["models"][0]["relative_error"], error, rounding * error);
  for (std::size_t j = 0; j < 2; ++j) {
    const double of_joint = validation["joints"][j]["relative_error"];
    EXPECT_NEAR(comparison["models"][0]["joints"][j], of_joint, rounding * of_joint);
  }
}

TEST_F(Compare, AResultPredictsBetterThanAUrdfThatIsWrong) {
  edit("scara.urdf", "<mass value=\"2\"/>", "<mass value=\"4\"/>");
  const Json comparison = compared({"scara_result", "scara.urdf", "--log", "scara_validation.csv"});
  EXPECT_EQ(comparison["models"][0]["name"], "scara_result");
  const Json& test = comparison["tests"][0];
  EXPECT_EQ(test["better"], "scara_result");
  EXPECT_LT(test["p"], 0.01);
  EXPECT_LT(test["ratio"], 0.5);
  const Outcome run = identify({"compare", "scara_result", "scara.urdf", "--log", "scara_validation.csv"});
  EXPECT_NE(run.out.find("scara_result predicts better than scara.urdf (p"), std::string::npos) << run.out;
}

TEST_F(Compare, RolloutsJudgeBesideTheRobotDescription) {
  edit("scara.urdf", "<mass value=\"2\"/>", "<mass value=\"4\"/>");
  const Outcome run = identify({"validate", "scara_result", "scara_validation.csv", "--rollout"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(
      run.out.find("open loop: scara_result moves more like the robot than robot description after 0.1 s"),
      std::string::npos)
      << run.out;
  const Outcome again = identify({"validate", "scara_result", "scara_validation.csv", "--rollout", "--json",
                                  "--report", "--output", "made"});
  const Json found = Json::parse(again.out)["rollouts"]["found"];
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0]["drive"], "torques");
  EXPECT_EQ(found[0]["horizon"], 0.1);
  EXPECT_EQ(found[0]["tests"][0]["better"], "scara_result");
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_LT(found[0]["models"][0]["velocity"][j], found[0]["models"][1]["velocity"][j]) << j;
  }
  EXPECT_NE(folder().read("made/comparison.html").find("Position error of joint_1 over the horizon"),
            std::string::npos);
}

TEST_F(Compare, RolloutsLieInTheWindowOfTheLog) {
  const auto windows = [&](const std::string& window) {
    const Outcome run = identify({"validate", "scara_result", "scara_validation.csv", "--rollout", "--json",
                                  "--set", "signal.window=" + window});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const Json all = Json::parse(run.out);
    for (const Json& found : all["rollouts"]["found"]) {
      if (found["drive"] == "torques" && found["horizon"] == 1.0) {
        return found["windows"].get<int>();
      }
    }
    return 0;
  };
  EXPECT_EQ(windows("[2, 5.1]"), 3);
  EXPECT_EQ(windows("[2, 8.1]"), 6);
}

TEST_F(Compare, AModelIsAsGoodAsItself) {
  const Json comparison =
      compared({"scara_result", "scara_result/result.json", "--log", "scara_validation.csv"});
  EXPECT_EQ(comparison["tests"][0]["ratio"], 1.0);
  EXPECT_EQ(comparison["tests"][0]["p"], 1.0);
  EXPECT_TRUE(comparison["tests"][0]["better"].is_null());
  for (const Json& change : comparison["changes"][0]["parameters"]) {
    EXPECT_EQ(change["z"], 0.0) << change;
  }
}

TEST_F(Compare, WhatChangedIsInStandardDeviationsOfBothResults) {
  Json other = Json::parse(folder().read("scara_result/result.json"));
  for (Json& parameter : other["parameters"]) {
    if (parameter["name"] == "Fc1") {
      parameter["value"] = parameter["value"].get<double>() + 20.0 * parameter["sigma"].get<double>();
    }
  }
  folder().write("later_result/result.json", other.dump());
  const Json comparison = compared({"scara_result", "later_result", "--log", "scara_validation.csv"});
  const Json& change = comparison["changes"][0]["parameters"][0];
  EXPECT_EQ(change["name"], "Fc1");
  EXPECT_NEAR(change["z"], 20.0 / std::sqrt(2.0), 1e-9);
  const Outcome run = identify({"compare", "scara_result", "later_result", "--log", "scara_validation.csv"});
  EXPECT_NE(
      run.out.find("1 parameter of 8 changed by more than the standard deviations of both results explain"),
      std::string::npos)
      << run.out;
}

TEST_F(Compare, TakesParameterFiles) {
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  std::string csv = "name,value\n";
  for (const Json& parameter : result["parameters"]) {
    csv += parameter["name"].get<std::string>() + "," + parameter["value"].dump() + "\n";
  }
  folder().write("mine.csv", csv);
  const Json comparison = compared({"mine.csv", "scara_result", "--log", "scara_validation.csv"});
  EXPECT_NEAR(comparison["models"][0]["relative_error"].get<double>(),
              comparison["models"][1]["relative_error"].get<double>(), 1e-12);
}

TEST_F(Compare, WritesJsonAndAPageWhereAsked) {
  const Outcome run =
      identify({"validate", "scara_result", "scara_validation.csv", "--output", "out", "--report"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(run.err.ends_with("wrote out/comparison.json\nwrote out/comparison.html\n")) << run.err;
  EXPECT_EQ(Json::parse(folder().read("out/comparison.json"))["format"], 1);
  const std::string page = folder().read("out/comparison.html");
  EXPECT_NE(page.find("scara_result"), std::string::npos);
  EXPECT_NE(page.find("id=\"errors-0\""), std::string::npos);
}

TEST_F(Compare, RefusesWhatItCanNotJudge) {
  expect_refused({"--log is required"}, {"compare", "scara_result", "scara.urdf"});
  expect_refused(
      {"none of the models is a result, which knows how logs are read; --experiment EXPERIMENT.toml says it"},
      {"compare", "scara.urdf", "--log", "scara_s2.csv"});
  expect_refused({"--report needs --output"}, {"validate", "scara_result", "scara_s2.csv", "--report"});
  std::filesystem::rename(folder().path() / "scara.toml", folder().path() / "moved.toml");
  expect_refused(
      {"scara_result/result.json: its experiment file scara.toml is not there; --experiment says how"},
      {"validate", "scara_result", "scara_s2.csv"});
  EXPECT_EQ(identify({"validate", "scara_result", "scara_s2.csv", "--experiment", "moved.toml"}).exit_code,
            0);
}

}  // namespace
