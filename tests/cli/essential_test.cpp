// Essential parameters and the prefilter as an experiment file asks for them, and as rivid_identify tells
// them.

#include <gtest/gtest.h>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;

class EssentialParametersOfTheTool : public rivid::test::IdentifyTool {
 protected:
  void with(const std::string& keys) const { edit("scara.toml", "[method]\n", "[method]\n" + keys); }
};

TEST_F(EssentialParametersOfTheTool, AreInResultAndTableBesideTheFullSet) {
  const Json plain = result_of();
  EXPECT_FALSE(plain.contains("essential"));
  // The log tells all eight of them; a level at which one in 1e30 would be kept by chance lets some go.
  with("essential = { significance = 1e-30 }\n");
  const Json result = result_of();
  EXPECT_EQ(result["parameters"], plain["parameters"]);
  const Json& essential = result["essential"];
  EXPECT_EQ(essential["significance"], 1e-30);
  ASSERT_GE(essential["eliminated"].size(), 1U);
  EXPECT_EQ(essential["eliminated"].size() + essential["parameters"].size(), 8U);
  EXPECT_EQ(essential["eliminated"][0]["name"], "Fv1");
  EXPECT_GT(essential["eliminated"][0]["F"], 10.0);
  EXPECT_GE(essential["eliminated"][0]["p"], 1e-30);
  EXPECT_EQ(essential["parameters"][0]["name"], "ZZ1R");
  EXPECT_GT(essential["parameters"][0]["sigma"], 0.0);
  EXPECT_GT(essential["fit"]["relative_error"], result["fit"]["relative_error"]);
  EXPECT_EQ(result["validation"][0]["essential"]["joints"].size(), 2U);
  const Outcome run = identify({"scara.toml", "--verbose"});
  for (const char* const words :
       {"Essential parameters: ", " of 8", "eliminated", "Their price on scara_validation.csv"}) {
    EXPECT_NE(run.out.find(words), std::string::npos) << words << " is not in\n" << run.out;
  }
}

TEST_F(EssentialParametersOfTheTool, AreAllWhereTheLogTellsAll) {
  with("essential = true\n");
  const Json result = result_of();
  EXPECT_EQ(result["essential"]["parameters"].size(), 8U);
  EXPECT_EQ(result["essential"]["p"], 1.0);
}

TEST_F(EssentialParametersOfTheTool, PrefilterIsToldInResultAndTable) {
  folder().write("scara.toml",
                 rivid::test::content_of(std::filesystem::path(RIVID_DATA) / "scara/scara_iv.toml"));
  with("prefilter = 12\n");
  const Json result = result_of();
  const Json& prefilter = result["prefilter"];
  ASSERT_EQ(prefilter["noise"].size(), 2U);
  EXPECT_EQ(prefilter["noise"][0]["joint"], result["robot"]["joints"][0]["name"]);
  EXPECT_EQ(prefilter["noise"][1]["ar"].size(), 12U);
  EXPECT_EQ(prefilter["without"]["chi"].size(), 8U);
  EXPECT_EQ(prefilter["without"]["sigma"].size(), 8U);
  const Outcome run = identify({"scara.toml", "--verbose"});
  EXPECT_NE(run.out.find("prefilter: autoregressive noise of order 12, 12 taken off"), std::string::npos)
      << run.out;
}

}  // namespace
