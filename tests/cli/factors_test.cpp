// rivid factors and merge: logs reduced one by one, identified together.

#include <gtest/gtest.h>

#include "rivid/experiment/factors_file.hpp"
#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;

class Factors : public rivid::test::IdentifyTool {
 protected:
  Factors() {
    make("scara_s2.csv", "one.factors");
    make("scara_validation.csv", "two.factors");
  }

  void make(const std::string& log, const std::string& file, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"factors", "scara.toml", "--log", log, "--output", file, "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome run = identify(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  [[nodiscard]] Json merged(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "merge");
    arguments.emplace_back("--json");
    const Outcome run = identify(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return Json::parse(run.out);
  }
};

TEST_F(Factors, MergedAreIdentifiedAsTheLogsTogetherBitByBit) {
  const Json together = result_of({"scara.toml", "--log", "scara_s2.csv", "scara_validation.csv", "--quiet"});
  const Json apart = merged({"one.factors", "two.factors"});
  ASSERT_EQ(apart["status"], "identified");
  ASSERT_EQ(apart["parameters"].size(), together["parameters"].size());
  for (std::size_t i = 0; i < apart["parameters"].size(); ++i) {
    EXPECT_EQ(apart["parameters"][i]["value"], together["parameters"][i]["value"]);
    EXPECT_EQ(apart["parameters"][i]["regrouping"], together["parameters"][i]["regrouping"]);
  }
  Json fit = together["fit"];
  fit["reference_error"] = nullptr;  // of rows that factors do not have
  EXPECT_EQ(apart["fit"], fit);
  EXPECT_EQ(apart["covariance"]["kind"], "blocks");
  EXPECT_EQ(apart["provenance"]["inputs"].size(), 5U) << "experiment, robot, validation and both logs";
}

TEST_F(Factors, AFileOfMergedFactorsStandsForItsLogs) {
  const Outcome run = identify({"merge", "one.factors", "two.factors", "--output", "both.factors"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("wrote both.factors"), std::string::npos) << run.err;
  const Outcome table = identify({"merge", "both.factors", "--report", "--verbose"});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_NE(table.out.find("(classical), divided by 0.866 to undo the decimation"), std::string::npos)
      << table.out;
  EXPECT_TRUE(std::filesystem::exists(folder().path() / "scara_result/report.html"));
  const Json from_both = merged({"both.factors"});
  const Json from_each = merged({"one.factors", "two.factors"});
  EXPECT_EQ(from_both["parameters"], from_each["parameters"]);
  EXPECT_EQ(from_both["provenance"]["inputs"], from_each["provenance"]["inputs"]);
}

TEST_F(Factors, CarryTheRunThatWroteThem) {
  const auto run_of = [&](const std::string& file) {
    return rivid::read_factors(folder().path() / file).run;
  };
  const std::string one = run_of("one.factors");
  EXPECT_EQ(one.size(), 16U) << one;
  EXPECT_NE(run_of("two.factors"), one);
  make("scara_s2.csv", "again.factors");
  EXPECT_EQ(run_of("again.factors"), one);
  make("scara_s2.csv", "blocks.factors", {"--blocks", "1"});
  EXPECT_NE(run_of("blocks.factors"), one);
  ASSERT_EQ(identify({"merge", "one.factors", "two.factors", "--output", "both.factors"}).exit_code, 0);
  EXPECT_EQ(run_of("both.factors").size(), 16U);
  EXPECT_NE(run_of("both.factors"), one);
}

TEST_F(Factors, WithoutARunCanBeReadAndMerged) {
  rivid::FactorsFile old = rivid::read_factors(folder().path() / "one.factors");
  old.run.clear();
  const std::string content = encoded(old);
  EXPECT_EQ(content.find("\"run\""), std::string::npos) << "as versions before wrote it";
  folder().write("old.factors", content);
  EXPECT_EQ(rivid::read_factors(folder().path() / "old.factors").run, "");
  EXPECT_EQ(merged({"old.factors", "two.factors"})["parameters"],
            merged({"one.factors", "two.factors"})["parameters"]);
}

TEST_F(Factors, RowsThatAreChosenByTheNoiseAreThoseOfTheExperimentsLogs) {
  edit("scara.toml", "decimation = 20\n", "");
  edit("scara.toml", "cutoff_hz = 20\n", "");
  edit("scara.toml", "order = 4\n", "");
  make("scara_s2.csv", "open.factors");
  make("scara_validation.csv", "open2.factors");
  const Json of_log = result_of({"scara.toml", "--quiet"});
  const Json of_factors = merged({"open.factors"});
  ASSERT_EQ(of_factors["parameters"].size(), of_log["parameters"].size());
  for (std::size_t i = 0; i < of_log["parameters"].size(); ++i) {
    EXPECT_EQ(of_factors["parameters"][i]["value"], of_log["parameters"][i]["value"]);
  }
  EXPECT_EQ(merged({"open.factors", "open2.factors"})["status"], "identified");
}

TEST_F(Factors, OfAnotherRobotOrWithOtherSettingsAreRefused) {
  make("scara_validation.csv", "coarse.factors", {"--set", "signal.decimation=10"});
  expect_refused({"coarse.factors", "signal.decimation is [10]", "[20]"},
                 {"merge", "one.factors", "coarse.factors"});
  expect_refused({"one.factors", "signal.decimation is [20]", "the experiment"},
                 {"merge", "one.factors", "--set", "signal.decimation=10"});
  expect_refused({"one.factors", "scara_s2.csv", "twice"}, {"merge", "one.factors", "one.factors"});
  edit("scara.toml", "gravity = [0, 0, -9.81]", "gravity = [0, -9.81, 0]");
  expect_refused({"another robot"}, {"merge", "one.factors"});
}

TEST_F(Factors, MethodsThatNeedSamplesAreRefused) {
  expect_refused({"robust estimation", "from the logs"},
                 {"merge", "one.factors", "--set", "method.robust=huber"});
  expect_refused({"hac"}, {"merge", "one.factors", "--set", "method.covariance=hac"});
}

TEST_F(Factors, WrongFilesAreRefused) {
  expect_refused({"scara_s2.csv", "holds no factors"}, {"merge", "scara_s2.csv"});
  expect_refused({"missing.factors"}, {"merge", "one.factors", "missing.factors"});
  expect_refused({"must end in .factors"}, {"factors", "scara.toml", "--output", "one.txt"});
  const std::string content = folder().read("one.factors");
  folder().write("short.factors", content.substr(0, content.size() / 2));
  expect_refused({"short.factors", "truncated or damaged"}, {"merge", "short.factors"});
  folder().write("header.factors", content.substr(0, 10));
  expect_refused({"header.factors", "truncated"}, {"merge", "header.factors"});
  folder().write("empty.factors", "");
  expect_refused({"empty.factors", "holds no factors"}, {"merge", "empty.factors"});
  std::string damaged = content;
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 1);
  folder().write("damaged.factors", damaged);
  expect_refused({"damaged.factors", "checksum"}, {"merge", "damaged.factors"});
  std::string newer = content;
  newer[8] = 2;
  folder().write("newer.factors", newer);
  expect_refused({"newer.factors", "version 2"}, {"merge", "newer.factors"});
  std::filesystem::rename(folder().path() / "scara.toml", folder().path() / "moved.toml");
  expect_refused({"scara.toml is not there", "--experiment"}, {"merge", "one.factors"});
  EXPECT_EQ(merged({"one.factors", "--experiment", "moved.toml"})["status"], "identified");
}

}  // namespace
