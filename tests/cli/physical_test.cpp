// The physically consistent model as rivid_identify is asked for it, and tells it.

#include <gtest/gtest.h>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::named;
using rivid::test::Outcome;

class PhysicalModelOfTheTool : public rivid::test::IdentifyTool {
 protected:
  // The experiment with other keys in [method].
  void with(const std::string& keys) const {
    edit("scara.toml", "name = \"wls\"\n", "name = \"wls\"\n" + keys);
  }

  void expect_refusal(const std::string& keys, std::string_view words) const {
    with(keys);
    const Outcome run = identify({"scara.toml"});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  }
};

TEST_F(PhysicalModelOfTheTool, IsInTheResultLinkByLinkWithItsPrice) {
  const Json plain = result_of();
  EXPECT_FALSE(plain.contains("physical"));
  const Json result = result_of({"scara.toml", "--physical"});
  EXPECT_EQ(result["parameters"], plain["parameters"]);
  EXPECT_EQ(result["provenance"]["options"]["overrides"]["physical"], "true");
  const Json& physical = result["physical"];
  EXPECT_EQ(physical["options"]["prior"], "log_det");
  ASSERT_EQ(physical["links"].size(), 2U);
  const Json& forearm = physical["links"][1];
  EXPECT_EQ(forearm["link"], "forearm");
  EXPECT_EQ(forearm["joint"], "joint_2");
  EXPECT_EQ(forearm["parameters"].size(), 12U);
  const Json M2 = named(forearm["parameters"], "M2");
  EXPECT_EQ(M2["unit"], "kg");
  EXPECT_EQ(M2["a_priori"], 2.0);
  EXPECT_GT(M2["value"], 0.0);
  EXPECT_EQ(physical["chi"].size(), 8U);
  EXPECT_EQ(physical["fit"]["joints"].size(), 2U);
  // The fit minimises weighted errors, so that plain ones may gain a little.
  EXPECT_NEAR(physical["fit"]["relative_error"], result["fit"]["relative_error"].get<double>(), 1e-5);
  EXPECT_EQ(result["validation"][0]["physical"]["joints"].size(), 2U);
}

TEST_F(PhysicalModelOfTheTool, IsInTheTableWithItsPrice) {
  const Outcome run = identify({"scara.toml", "--physical", "--verbose"});
  for (const char* const words :
       {"Physically consistent parameters\n", "Nearest to the robot description: prior log_det with weight 1",
        "M2=", "Their price in fit", "Their price on scara_validation.csv"}) {
    EXPECT_NE(run.out.find(words), std::string::npos) << words << " is not in\n" << run.out;
  }
}

TEST_F(PhysicalModelOfTheTool, ObeysTheExperimentFile) {
  with(
      "physical = { prior = \"ridge\", weight = 10, masses = { forearm = [2.5, 3] }, total_mass = [45, 60] "
      "}\n");
  const Json physical = result_of()["physical"];
  EXPECT_EQ(physical["options"]["prior"], "ridge");
  EXPECT_EQ(physical["options"]["weight"], 10.0);
  EXPECT_EQ(physical["options"]["masses"]["forearm"][0], 2.5);
  EXPECT_EQ(physical["options"]["total_mass"][1], 60.0);
  const double M1 = named(physical["links"][0]["parameters"], "M1")["value"];
  const double M2 = named(physical["links"][1]["parameters"], "M2")["value"];
  EXPECT_GT(M2, 2.5);
  EXPECT_LT(M2, 3.0);
  EXPECT_GT(M1 + M2, 45.0);
}

TEST_F(PhysicalModelOfTheTool, CanBeRefusedInTheFile) {
  with("physical = false\n");
  EXPECT_FALSE(result_of().contains("physical"));
}

TEST_F(PhysicalModelOfTheTool, RefusesAWeightOfZero) {
  expect_refusal("physical = { weight = 0 }\n", "[method.physical] weight is 0, must be positive");
}

TEST_F(PhysicalModelOfTheTool, RefusesALinkThatTheRobotLacks) {
  expect_refusal(
      "physical.masses = { foream = [1, 2] }\n",
      "masses of link \"foream\": no moving link has this name; they are \"arm\" and \"forearm\"; did "
      "you mean \"forearm\"?");
}

TEST_F(PhysicalModelOfTheTool, RefusesBoundsThatAreNone) {
  expect_refusal("physical.masses = { forearm = 2 }\n", "forearm must be [least, most] in kg");
}

TEST_F(PhysicalModelOfTheTool, RefusesWhatIsNeitherSwitchNorTable) {
  expect_refusal("physical = 3\n", "[method] physical must be true or false, or a table of options");
}

}  // namespace
