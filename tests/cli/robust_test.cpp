// Robust estimation as an experiment file or the command line asks for it, and as rivid_identify tells it.

#include <gtest/gtest.h>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;

class RobustEstimationByTheTool : public rivid::test::IdentifyTool {
 protected:
  void with(const std::string& keys) const { edit("scara.toml", "[method]\n", "[method]\n" + keys); }
};

TEST_F(RobustEstimationByTheTool, IsInResultAndTable) {
  const Json plain = result_of();
  EXPECT_FALSE(plain.contains("robust"));
  with("robust = \"bisquare\"\nrobust_tuning = 5\nphysical = true\nessential = true\n");
  const Json result = result_of();
  const Json& robust = result["robust"];
  EXPECT_EQ(robust["loss"], "bisquare");
  EXPECT_EQ(robust["tuning"], 5.0);
  EXPECT_GE(robust["rounds"], 2);
  EXPECT_EQ(robust["joints"].size(), 2U);
  EXPECT_EQ(robust["joints"][1]["name"], result["robot"]["joints"][1]["name"]);
  EXPECT_EQ(robust["joints"][1]["rows"], result["fit"]["joints"][1]["rows"]);
  EXPECT_GT(robust["joints"][1]["scale"], 0.0);
  EXPECT_GT(robust["joints"][1]["below_one"], robust["joints"][1]["below_half"]);
  ASSERT_EQ(robust["without"]["chi"].size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(robust["without"]["chi"][i], plain["parameters"][i]["value"]);
  }
  EXPECT_TRUE(result.contains("physical"));
  EXPECT_TRUE(result.contains("essential"));
  const Outcome run = identify({"scara.toml", "--verbose"});
  for (const char* const words : {", bisquare: identified", "Weights of the rows", "no weight", "below 1/2",
                                  "Bisquare loss, tuning 5, in ", "moves the most, by "}) {
    EXPECT_NE(run.out.find(words), std::string::npos) << words << " is not in\n" << run.out;
  }
}

TEST_F(RobustEstimationByTheTool, IsAlsoAFlag) {
  const Outcome huber = identify({"scara.toml", "--robust", "huber"});
  EXPECT_NE(huber.out.find(", Huber: identified"), std::string::npos) << huber.out;
  with("robust = \"huber\"\n");
  const Outcome off = identify({"scara.toml", "--robust", "off"});
  EXPECT_EQ(off.out.find("Weights of the rows"), std::string::npos) << off.out;
}

TEST_F(RobustEstimationByTheTool, IsInTheReport) {
  with("robust = \"huber\"\n");
  ASSERT_EQ(identify({"scara.toml", "--report", "--output", "out"}).exit_code, 0);
  const std::string page = rivid::test::content_of(folder().path() / "out" / "report.html");
  EXPECT_NE(page.find("loss, tuning 1.345, in "), std::string::npos);
}

TEST_F(RobustEstimationByTheTool, WorksWithInstruments) {
  folder().write("scara.toml",
                 rivid::test::content_of(std::filesystem::path(RIVID_DATA) / "scara/scara_iv.toml"));
  const Outcome run = identify({"scara.toml", "--robust", "bisquare"});
  EXPECT_NE(run.out.find("IDIM-IV, bisquare: identified"), std::string::npos) << run.out;
}

}  // namespace
