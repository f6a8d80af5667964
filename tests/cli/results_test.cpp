// What rivid_identify prints, writes and returns.

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::content_of;
using rivid::test::identify_command;
using rivid::test::Json;
using rivid::test::named;
using rivid::test::Outcome;
using rivid::test::outcome_of;
using rivid::test::parameter;
using rivid::test::Process;

constexpr const char* result_file = "scara_result/result.json";

class Identify : public rivid::test::IdentifyTool {
 protected:
  [[nodiscard]] bool wrote_a_result() const {
    return std::filesystem::exists(folder().path() / "scara_result");
  }
};

TEST_F(Identify, FindsTheTruthOfTheScaraWithinItsIntervals) {
  const Json result = result_of();
  EXPECT_EQ(result["status"], "identified");
  EXPECT_EQ(result["method"], "wls");
  const Json truth = Json::parse(content_of(std::filesystem::path(RIVID_DATA) / "scara/truth.json"));
  for (const Json& p : result["parameters"]) {
    const double value = truth["parameters"][p["name"].get<std::string>()]["value"];
    EXPECT_LE(p["interval_95"][0], value) << p["name"];
    EXPECT_GE(p["interval_95"][1], value) << p["name"];
  }
}

TEST_F(Identify, PrintsTheTableAndSaysWhatItWrote) {
  const Outcome run = identify({"scara.toml"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_TRUE(run.out.starts_with("IDIM-WLS: identified, 8 of 8 base parameters from 353 rows")) << run.out;
  EXPECT_EQ(run.out.find("Validation on scara_validation.csv"), std::string::npos) << run.out;
  EXPECT_TRUE(
      run.err.ends_with("wrote scara_result/result.json\n"
                        "next: rivid export scara_result --to header\n"))
      << run.err;
  const Outcome all = identify({"scara.toml", "--verbose"});
  EXPECT_NE(all.out.find("Validation on scara_validation.csv"), std::string::npos) << all.out;
}

TEST_F(Identify, DryRunWritesNothingAndTellsThePlan) {
  const auto before = folder().entries();
  const Outcome run = identify({"scara.toml", "--dry-run"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const char* const word :
       {"\"scara\", 2 joints", "8 base parameters", "scara_s2.csv: 4001 samples at 200 Hz",
        "scara_validation.csv", "wls", "would write scara_result/result.json"}) {
    EXPECT_NE(run.out.find(word), std::string::npos) << word << " is not in\n" << run.out;
  }
  EXPECT_EQ(folder().entries(), before);
}

TEST_F(Identify, JsonOnStandardOutputIsTheWrittenResult) {
  const Outcome run = identify({"scara.toml", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, folder().read(result_file));
  EXPECT_EQ(Json::parse(run.out)["status"], "identified");
}

TEST_F(Identify, QuietPrintsNothing) {
  const Outcome run = identify({"scara.toml", "--quiet"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(run.err, "");
  EXPECT_TRUE(wrote_a_result());
}

TEST_F(Identify, GivesTheSameWithSeveralThreads) {
  const Outcome alone = identify({"scara.toml"});
  const Outcome several = identify({"scara.toml", "--threads", "3"});
  EXPECT_EQ(several.exit_code, 0);
  EXPECT_EQ(several.out, alone.out);
  EXPECT_EQ(identify({"scara.toml", "--threads", "0"}).exit_code, 0);
  EXPECT_EQ(identify({"scara.toml", "--threads", "-1"}).exit_code, 2);
}

TEST_F(Identify, QuietPrintsNothingInADryRunEither) {
  const Outcome run = identify({"scara.toml", "--quiet", "--dry-run"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out + run.err, "");
  EXPECT_FALSE(wrote_a_result());
}

TEST_F(Identify, VersionAndHelpSucceedWithoutAnExperiment) {
  const Outcome version = identify({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_TRUE(version.out.starts_with("rivid ")) << version.out;
  const Outcome help = identify({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* const word :
       {"--method", "--log", "--validate", "--output", "--json", "--dry-run", "Exit codes"}) {
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(version.err + help.err, "");
}

TEST_F(Identify, TwoRunsGiveTheSameBytes) {
  EXPECT_EQ(identify({"scara.toml"}).exit_code, 0);
  const std::string first = folder().read(result_file);
  EXPECT_EQ(identify({"scara.toml"}).exit_code, 0);
  EXPECT_EQ(folder().read(result_file), first);
}

TEST_F(Identify, FlagsOverrideTheExperimentAndAreKept) {
  std::filesystem::copy_file(folder().path() / "scara_s2.csv", folder().path() / "other.csv");
  const Json plain = result_of();
  EXPECT_TRUE(plain["provenance"]["options"]["overrides"].empty());
  EXPECT_EQ(plain["validation"][0]["file"], "scara_validation.csv");
  const Json result = result_of({"scara.toml", "--method", "wls", "--log", "scara_validation.csv",
                                 "--validate", "scara_s2.csv", "other.csv"});
  const Json expected = {
      {"method", "wls"}, {"log", "scara_validation.csv"}, {"validate", "scara_s2.csv other.csv"}};
  EXPECT_EQ(result["provenance"]["options"]["overrides"], expected);
  EXPECT_EQ(result["method"], "wls");
  ASSERT_EQ(result["validation"].size(), 2U);
  EXPECT_EQ(result["validation"][0]["file"], "scara_s2.csv");
  EXPECT_EQ(result["validation"][1]["file"], "other.csv");
  EXPECT_EQ(result["validation"][0]["relative_error"], result["validation"][1]["relative_error"]);
  EXPECT_NE(parameter(result, "ZZ1R")["value"], parameter(plain, "ZZ1R")["value"]);
}

TEST_F(Identify, WeightedLeastSquaresWeightsEachJoint) {
  const Json ols = result_of({"scara.toml", "--method", "ols"});
  EXPECT_EQ(ols["fit"]["weights"], Json({1.0, 1.0}));
  const Json wls = result_of({"scara.toml", "--method", "wls"});
  EXPECT_GT(wls["fit"]["weights"][1], wls["fit"]["weights"][0]);
  EXPECT_LT(parameter(wls, "Fc2")["sigma"], parameter(ols, "Fc2")["sigma"]);
}

TEST_F(Identify, NamesItsInputsWithTheirChecksums) {
  const Json inputs = result_of()["provenance"]["inputs"];
  std::vector<std::string> paths;
  for (const Json& input : inputs) {
    paths.push_back(input["path"]);
    EXPECT_EQ(input["sha256"].get<std::string>().size(), 64U);
  }
  EXPECT_EQ(paths,
            (std::vector<std::string>{"scara.toml", "scara.urdf", "scara_s2.csv", "scara_validation.csv"}));
}

TEST_F(Identify, PathsAreRelativeToTheExperimentFile) {
  const Json here = result_of();
  std::filesystem::create_directory(folder().path() / "elsewhere");
  const Outcome run =
      outcome_of(identify_command({"../scara.toml", "--output", "there"}), folder().path() / "elsewhere");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json there = Json::parse(folder().read("elsewhere/there/result.json"));
  EXPECT_EQ(there["parameters"], here["parameters"]);
}

TEST_F(Identify, LogsOnTheCommandLineAreRelativeToTheWorkingDirectory) {
  std::filesystem::create_directory(folder().path() / "elsewhere");
  std::filesystem::rename(folder().path() / "scara_s2.csv", folder().path() / "elsewhere/mine.csv");
  const Outcome run =
      outcome_of(identify_command({"../scara.toml", "--log", "mine.csv"}), folder().path() / "elsewhere");
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(Identify, MakesTheOutputFolder) {
  EXPECT_EQ(identify({"scara.toml", "--output", "a/b/c"}).exit_code, 0);
  EXPECT_EQ(Json::parse(folder().read("a/b/c/result.json"))["status"], "identified");
}

TEST_F(Identify, TakesNamesWithBlanksUmlautsAndQuotes) {
  const std::string odd = "Läufe 日本 \"1\"";
  std::filesystem::create_directory(folder().path() / odd);
  for (const char* const file : {"scara.toml", "scara.urdf", "scara_s2.csv", "scara_validation.csv"}) {
    std::filesystem::rename(folder().path() / file, folder().path() / odd / file);
  }
  const Outcome run = identify({odd + "/scara.toml"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(Json::parse(folder().read(result_file))["validation"][0]["file"], odd + "/scara_validation.csv");
}

TEST_F(Identify, WritesJsonForANameThatIsNoUtf8) {
  const std::string odd = "run\xff.csv";
  std::filesystem::copy_file(folder().path() / "scara_validation.csv", folder().path() / odd);
  const Json result = result_of({"scara.toml", "--validate", odd});
  EXPECT_EQ(result["validation"][0]["file"], "run\xEF\xBF\xBD.csv");
}

TEST_F(Identify, AJointThatNeverMovesIsRankDeficient) {
  rewrite_rows("scara_s2.csv", [](const std::string& line) {
    const std::size_t q1 = line.find(',') + 1;
    const std::size_t q2 = line.find(',', q1) + 1;
    return line.substr(0, q2) + "0.3" + line.substr(line.find(',', q2));
  });
  const Json result = result_of({"scara.toml"}, 1);
  EXPECT_EQ(result["status"], "rank_deficient");
  const std::string reasons = result["reasons"].dump();
  EXPECT_NE(reasons.find("of 8"), std::string::npos) << reasons;
  for (const char* const name : {"Fv2", "Fc2"}) {
    EXPECT_NE(reasons.find(name), std::string::npos) << name << " is not in " << reasons;
    EXPECT_TRUE(parameter(result, name)["value"].is_null());
    EXPECT_TRUE(parameter(result, name)["sigma"].is_null());
  }
  EXPECT_TRUE(parameter(result, "Fc1")["value"].is_number());
  EXPECT_EQ(result["fit"]["joints"][1]["rows"], 0);
  EXPECT_TRUE(result["fit"]["centred_relative_error"].is_number());
}

TEST_F(Identify, SaysWhenStandardOutputIsFull) {
  Process full(identify_command({"scara.toml"}), folder().path(), "/dev/full");
  const Outcome run = full.wait();
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err, "rivid_identify: error: standard output can not be written to\n");
}

TEST_F(Identify, AnInterruptionLeavesNoPartOfAResult) {
  // Many logs make a run that lasts; interrupted at different moments it has written all or nothing.
  std::vector<std::string> command = identify_command({"scara.toml", "--log"});
  command.insert(command.end(), 40, "scara_s2.csv");
  const auto before = folder().entries();
  for (int milliseconds = 1; milliseconds < 300; milliseconds *= 2) {
    Process process(command, folder().path());
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    process.send(SIGINT);
    const Outcome run = process.wait();
    if (run.signal == 0) {
      EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 130) << run.exit_code << run.err;
    } else {
      EXPECT_EQ(run.signal, SIGINT);  // the program had not begun
    }
    if (std::filesystem::exists(folder().path() / result_file)) {
      EXPECT_EQ(Json::parse(folder().read(result_file))["status"], "identified");
      std::filesystem::remove(folder().path() / result_file);
    }
    std::error_code none;
    std::filesystem::remove(folder().path() / "scara_result", none);  // only if it is empty
    EXPECT_EQ(folder().entries(), before) << "after " << milliseconds << " ms";
  }
}

}  // namespace
