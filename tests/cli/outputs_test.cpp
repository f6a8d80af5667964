// What the tools write destroys nothing: not their inputs, not each other, nothing that is no regular file.

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <chrono>
#include <thread>

#include "rivid/input.hpp"
#include "rivid/model/urdf.hpp"
#include "support/identify_tool.hpp"

namespace {

using rivid::test::content_of;
using rivid::test::Json;
using rivid::test::Outcome;
using rivid::test::outcome_of;
using rivid::test::Process;

class Outputs : public rivid::test::IdentifyTool {
 protected:
  // Through a shell, with its redirections and limits.
  [[nodiscard]] Outcome shell(const std::string& script) const {
    return outcome_of({"/bin/sh", "-c", script}, folder().path());
  }
};

TEST_F(Outputs, AreRefusedWhereTheyAreInputs) {
  const std::string urdf = folder().read("scara.urdf");
  ASSERT_EQ(identify({"scara.toml", "--physical", "--quiet"}).exit_code, 0);
  std::filesystem::create_symlink("scara_result/result.json", folder().path() / "link.urdf");
  const auto expect_refused_export = [&](std::string_view words, const std::string& file) {
    expect_refused({words}, {"export", "scara_result", "--to", "urdf", "--force", "--output", file});
  };
  expect_refused_export("link.urdf: is an input of this run (scara_result/result.json)", "link.urdf");
  expect_refused_export("scara.urdf: is an input of this run", "scara.urdf");
  expect_refused_export("./scara.urdf: is an input of this run (scara.urdf)", "./scara.urdf");
  EXPECT_EQ(folder().read("scara.urdf"), urdf);
}

TEST_F(Outputs, OfAnIdentificationSpareItsLogs) {
  for (const std::string file : {"scara_s2.csv", "scara_validation.csv"}) {
    const std::string content = folder().read(file);
    expect_refused({file + ": is an input of this run"}, {"scara.toml", "--write-rows", file});
    EXPECT_EQ(folder().read(file), content);
  }
}

TEST_F(Outputs, AreRefusedWhereTheyAreEachOther) {
  ASSERT_EQ(identify({"scara.toml", "--physical", "--quiet"}).exit_code, 0);
  expect_refused({"out.py: is written twice"},
                 {"export", "scara_result", "--to", "drake", "--output", "out.py"});
}

TEST_F(Outputs, OfAnotherKindAreRefusedWithoutForce) {
  ASSERT_EQ(identify({"scara.toml", "--physical", "--quiet"}).exit_code, 0);
  folder().write("notes.txt", "mine");
  expect_refused({"notes.txt: is there already and is no .h file"},
                 {"export", "scara_result", "--to", "header", "--output", "notes.txt"});
  EXPECT_EQ(
      identify({"export", "scara_result", "--to", "header", "--output", "notes.txt", "--force"}).exit_code,
      0);
  EXPECT_NE(folder().read("notes.txt").find("#ifndef"), std::string::npos);
}

TEST_F(Outputs, AreReplacedWhereRividWroteThem) {
  for (int run = 0; run < 2; ++run) {
    EXPECT_EQ(identify({"scara.toml", "--report", "--write-rows", "rows.csv", "--quiet"}).exit_code, 0);
  }
}

TEST_F(Outputs, ThatRividDidNotWriteAreReplacedByForceAlone) {
  provide("scara_s1.csv");
  std::filesystem::create_directory(folder().path() / "scara_result");
  folder().write("scara_result/result.json", "{\"mine\": 1}");
  expect_refused({"result.json: is there already and was not written by rivid", "--force replaces it"},
                 {"scara.toml"});
  EXPECT_EQ(identify({"scara.toml", "--physical", "--force", "--quiet"}).exit_code, 0);
  // The experiment's own log, where --log names another.
  const std::string log = folder().read("scara_s2.csv");
  expect_refused({"scara_s2.csv: is there already and was not written by the last run"},
                 {"scara.toml", "--log", "scara_s1.csv", "--write-rows", "scara_s2.csv"});
  EXPECT_EQ(folder().read("scara_s2.csv"), log);
  folder().write("other.urdf", "<robot name=\"other\"/>");
  expect_refused({"other.urdf: is there already and was not written by rivid"},
                 {"export", "scara_result", "--to", "urdf", "--output", "other.urdf"});
}

TEST_F(Outputs, ThatWereEditedSinceAreReplacedByForceAlone) {
  const auto simulate = [&](const std::string& option) {
    return outcome_of({RIVID_SIMULATE, "simulate_s2.toml", "--output", ".", "--quiet", option},
                      folder().path());
  };
  provide("simulate_s2.toml");
  provide("truth.json");
  folder().write("log.csv", "recorded");
  EXPECT_EQ(simulate("--dry-run").exit_code, 2);
  EXPECT_EQ(simulate("--force").exit_code, 0);
  EXPECT_EQ(simulate("--dry-run").exit_code, 0);
  folder().write("log.csv", folder().read("log.csv") + "9,9\n");
  const Outcome refused = simulate("--dry-run");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("or was edited since"), std::string::npos) << refused.err;
}

TEST_F(Outputs, OfAnotherExperimentOfTheSameNameAreKept) {
  ASSERT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0);
  const std::string before = folder().read("scara_result/result.json");
  std::filesystem::create_directory(folder().path() / "other");
  for (const char* const file : {"scara.toml", "scara.urdf", "scara_s2.csv", "scara_validation.csv"}) {
    folder().write(std::string("other/") + file, folder().read(file));
  }
  expect_refused({"scara_result: holds what was made from scara.toml, not from other/scara.toml", "--output"},
                 {"other/scara.toml"});
  EXPECT_EQ(identify({"./scara.toml", "--quiet"}).exit_code, 0);
  EXPECT_EQ(identify({"other/scara.toml", "--quiet", "--output", "other/result"}).exit_code, 0);
}

TEST_F(Outputs, AreRefusedWhereAPipeIs) {
  ASSERT_EQ(identify({"scara.toml", "--physical", "--quiet"}).exit_code, 0);
  ASSERT_EQ(::mkfifo((folder().path() / "pipe.urdf").c_str(), 0600), 0);
  expect_refused({"pipe.urdf: is no regular file"},
                 {"export", "scara_result", "--to", "urdf", "--output", "pipe.urdf"});
  EXPECT_TRUE(std::filesystem::is_fifo(folder().path() / "pipe.urdf"));
}

TEST_F(Outputs, OfInitAreNotItsInputs) {
  expect_refused({"scara_s2.csv: is an input of this run"},
                 {"init", "scara.urdf", "scara_s2.csv", "--output", "scara_s2.csv", "--force"});
}

TEST_F(Outputs, AreNotWrittenWhereAFileWouldBeTooLarge) {
  const Outcome run = shell("ulimit -f 4; exec '" + std::string(RIVID_IDENTIFY) + "' scara.toml");
  EXPECT_EQ(run.signal, 0);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("result.json: can not be written: File too large"), std::string::npos) << run.err;
  EXPECT_TRUE(std::filesystem::is_empty(folder().path() / "scara_result"));
}

TEST_F(Outputs, OfOneRunCarryItsName) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  ASSERT_EQ(identify({"export", "scara_result", "--to", "header", "--output", "model.h"}).exit_code, 0);
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  const std::string run = result["provenance"]["run"];
  EXPECT_EQ(run.size(), 16U);
  EXPECT_NE(folder().read("scara_result/report.html").find(run), std::string::npos);
  EXPECT_NE(folder().read("model.h").find("run " + run), std::string::npos);
  ASSERT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0);
  EXPECT_EQ(Json::parse(folder().read("scara_result/result.json"))["provenance"]["run"], run);
  ASSERT_EQ(identify({"scara.toml", "--set", "signal.decimation=10"}).exit_code, 0);
  EXPECT_NE(Json::parse(folder().read("scara_result/result.json"))["provenance"]["run"], run);
}

TEST_F(Outputs, ThatAreModelsCarryItToo) {
  ASSERT_EQ(identify({"scara.toml", "--physical", "--quiet"}).exit_code, 0);
  const std::string run = Json::parse(folder().read("scara_result/result.json"))["provenance"]["run"];
  for (const std::string format : {"urdf", "mjcf", "sdf"}) {
    const std::string file = "model." + std::string(format == "mjcf" ? "xml" : format);
    ASSERT_EQ(identify({"export", "scara_result", "--to", format, "--output", file}).exit_code, 0) << format;
    EXPECT_NE(folder().read(file).find("run " + run), std::string::npos) << format;
  }
}

TEST_F(Outputs, ThatNameHostileFilesAreXmlWithoutEscapeSequences) {
  const std::string name = "a--\x1B[31m-->\xFF.toml";
  folder().write(name, folder().read("scara.toml"));
  ASSERT_EQ(identify({name, "--physical", "--output", "result", "--quiet"}).exit_code, 0);
  for (const std::string format : {"urdf", "mjcf", "sdf"}) {
    const std::string file = "model." + format;
    ASSERT_EQ(identify({"export", "result", "--to", format, "--output", file}).exit_code, 0) << format;
    const std::string model = folder().read(file);
    EXPECT_EQ(model.find('\x1B'), std::string::npos) << format;
    EXPECT_EQ(model.find('\xFF'), std::string::npos) << format;
    const std::size_t begin = model.find("Written by rivid");
    ASSERT_NE(begin, std::string::npos) << format;
    const std::string comment = model.substr(begin, model.find("--", begin) - begin);
    EXPECT_NE(comment.find(".toml, physically consistent parameters, run "), std::string::npos) << comment;
  }
  EXPECT_EQ(rivid::read_urdf(folder().path() / "model.urdf").joints.size(), 2U);
}

TEST_F(Outputs, ThatHaveNoPlaceForANameAreKnownByTheirHash) {
  ASSERT_EQ(identify({"scara.toml", "--write-rows", "rows.csv", "--quiet"}).exit_code, 0);
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  ASSERT_EQ(result["provenance"]["outputs"].size(), 1U);
  EXPECT_EQ(result["provenance"]["outputs"][0]["path"], "rows.csv");
  EXPECT_EQ(result["provenance"]["outputs"][0]["sha256"], rivid::sha256(folder().read("rows.csv")));
  folder().write("simulate_s2.toml", content_of(RIVID_DATA "/scara/simulate_s2.toml"));
  ASSERT_EQ(outcome_of({RIVID_SIMULATE, "simulate_s2.toml", "--quiet"}, folder().path()).exit_code, 0);
  const Json simulation = Json::parse(folder().read("simulate_s2_simulation/simulation.json"));
  EXPECT_EQ(simulation["provenance"]["outputs"][0]["sha256"],
            rivid::sha256(folder().read("simulate_s2_simulation/log.csv")));
}

TEST_F(Outputs, DoNotTakeWhatIsMeantForAClosedScreen) {
  const std::string montecarlo =
      "'" + std::string(RIVID_MONTECARLO) + "' montecarlo_s1.toml --runs 2 --output ";
  provide("montecarlo_s1.toml");
  ASSERT_EQ(shell(montecarlo + "open").exit_code, 0);
  const Outcome closed = shell(montecarlo + "closed >&-");
  EXPECT_EQ(closed.exit_code, 2) << closed.err;
  EXPECT_NE(closed.err.find("standard output can not be written to"), std::string::npos) << closed.err;
  EXPECT_EQ(std::ranges::count(folder().read("closed/runs.csv"), '\n'),
            std::ranges::count(folder().read("open/runs.csv"), '\n'));
  EXPECT_EQ(shell(montecarlo + "none <&- >&- 2>&-").exit_code, 2);
}

// Signals that come while the program reads and computes: earlier, where it was quicker than the run before.
TEST_F(Outputs, AreOldOrNewWhenASignalEndsTheProgram) {
  using Clock = std::chrono::steady_clock;
  ASSERT_EQ(identify({"scara.toml"}).exit_code, 0);
  const std::string old = folder().read("scara_result/result.json");
  std::vector<std::string> command =
      rivid::test::identify_command({"scara.toml", "--output", "new", "--log"});
  command.insert(command.end(), 200, "scara_s2.csv");
  const auto begin = Clock::now();
  ASSERT_LE(outcome_of(command, folder().path()).exit_code, 1) << "a result, whatever is said of equal logs";
  const auto whole = Clock::now() - begin;
  command[3] = "scara_result";
  for (const auto& [signal, code] : {std::pair(SIGINT, 130), std::pair(SIGTERM, 143)}) {
    // Not before the program has a handler, and before it ends.
    Outcome run;
    constexpr int most_attempts = 30;
    auto until = whole / 4;
    for (int attempt = 0; attempt < most_attempts && run.exit_code <= 1; ++attempt) {
      folder().write("scara_result/result.json", old);
      Process process(command, folder().path());
      std::this_thread::sleep_for(until);
      process.send(signal);
      run = process.wait();
      until = run.exit_code >= 0 ? until / 2 : until + whole / 16;
    }
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_EQ(folder().read("scara_result/result.json"), old);
  }
  EXPECT_EQ(std::ranges::distance(std::filesystem::directory_iterator(folder().path() / "scara_result")), 1);
}

}  // namespace
