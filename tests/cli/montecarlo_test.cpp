// rivid_montecarlo: going on after a stop, the same runs whatever the threads, what it refuses.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::named;
using rivid::test::Outcome;
using rivid::test::outcome_of;
using rivid::test::Process;

constexpr const char* summary_file = "montecarlo_s1_montecarlo/summary.json";
constexpr const char* runs_file = "montecarlo_s1_montecarlo/runs.csv";
constexpr const char* inputs_file = "montecarlo_s1_montecarlo/inputs.sha256";
constexpr const char* report_file = "montecarlo_s1_montecarlo/report.html";

class MonteCarlo : public rivid::test::IdentifyTool {
 protected:
  MonteCarlo() { provide("montecarlo_s1.toml"); }

  static std::vector<std::string> command(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {RIVID_MONTECARLO, "montecarlo_s1.toml"});
    return arguments;
  }

  // summary.json of so many runs.
  [[nodiscard]] std::string summary_of(const std::vector<std::string>& arguments) const {
    const Outcome run = outcome_of(command(arguments), folder().path());
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return folder().read(summary_file);
  }

  void expect_refused(const std::vector<std::string_view>& words) const {
    expect_refused_by("rivid_montecarlo", command({}), words);
  }
};

TEST_F(MonteCarlo, GivesTheSameWhateverTheThreadsAndTheOrder) {
  const std::string one = summary_of({"--runs", "8", "--threads", "1", "--restart"});
  EXPECT_EQ(summary_of({"--runs", "8", "--threads", "3", "--restart"}), one);
  // The last runs first: the first ones are taken out and made again.
  const std::string rows = folder().read(runs_file);
  const std::size_t header = rows.find('\n') + 1;
  folder().write(runs_file, rows.substr(0, header) + rows.substr(rows.find("\n5,") + 1));
  EXPECT_EQ(summary_of({"--runs", "8"}), one);
}

TEST_F(MonteCarlo, PartsThatAreMergedHaveTheBitsOfOneStudy) {
  const std::string one = summary_of({"--runs", "7", "--report"});
  const std::string page = folder().read(report_file);
  for (const char* const first : {"4", "0"}) {
    const Outcome run =
        outcome_of(command({"--first-run", first, "--runs", first == std::string("4") ? "3" : "4", "--output",
                            std::string("part_") + first, "--quiet"}),
                   folder().path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  const auto merge = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {RIVID_MONTECARLO, "merge", "montecarlo_s1.toml", "--output", "all"});
    return arguments;
  };
  const Outcome run = outcome_of(merge({"part_4", "part_0", "--runs", "7", "--report"}), folder().path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(folder().read("all/summary.json"), one);
  EXPECT_EQ(folder().read("all/report.html"), page);
  // A part that was made twice counts once.
  std::filesystem::copy(folder().path() / "part_4", folder().path() / "again");
  std::filesystem::remove_all(folder().path() / "all");
  ASSERT_EQ(outcome_of(merge({"part_4", "again", "part_0", "--runs", "7"}), folder().path()).exit_code, 0);
  EXPECT_EQ(folder().read("all/summary.json"), one);
  std::filesystem::remove_all(folder().path() / "all");

  expect_refused_by("rivid_montecarlo", merge({"part_4", "--runs", "7"}),
                    {"runs 0 to 3", "--first-run 0 --runs 4"});
  expect_refused_by("rivid_montecarlo", merge({"part_0", "part_4"}), {"runs 7 to 299", "--runs says"});
  expect_refused_by("rivid_montecarlo", merge({"part_0", "missing"}), {"missing: holds no runs.csv"});
  expect_refused_by("rivid_montecarlo", command({"--first-run", "3"}), {"--runs"});
  edit("montecarlo_s1.toml", "position_noise = 2e-5", "position_noise = 3e-5");
  expect_refused_by("rivid_montecarlo", merge({"part_0"}), {"part_0", "other input files"});
}

TEST_F(MonteCarlo, ADryRunTellsWhatIsThereAndWritesNothing) {
  const auto dry = [&] {
    const auto before = folder().entries();
    const Outcome run = outcome_of(command({"--runs", "5", "--dry-run"}), folder().path());
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(folder().entries(), before);
    return run.out;
  };
  EXPECT_NE(dry().find("runs        5, of which 0 are done\n"), std::string::npos);
  (void)summary_of({"--runs", "3"});
  const std::string told = dry();
  EXPECT_NE(told.find("runs        5, of which 3 are done\n"), std::string::npos) << told;
  EXPECT_TRUE(
      told.ends_with("would write montecarlo_s1_montecarlo/runs.csv\n"
                     "would write montecarlo_s1_montecarlo/inputs.sha256\n"
                     "would write montecarlo_s1_montecarlo/summary.json\n"))
      << told;
}

TEST_F(MonteCarlo, GoesOnAfterAStopAndEndsWithTheSameBits) {
  const std::string whole = summary_of({"--runs", "30", "--report"});
  const std::string page = folder().read(report_file);
  std::filesystem::remove_all(folder().path() / "montecarlo_s1_montecarlo");
  Process stopped(command({"--runs", "30", "--threads", "1"}), folder().path());
  // Killed as soon as some runs are there.
  for (int look = 0; look < 1000; ++look) {
    std::error_code none;
    if (std::filesystem::file_size(folder().path() / runs_file, none) > 4000 && !none) {
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  stopped.send(SIGKILL);
  ASSERT_EQ(stopped.wait().signal, SIGKILL);
  ASSERT_FALSE(std::filesystem::exists(folder().path() / summary_file));
  // In the middle of a line, as a kill may leave it.
  const std::string rows = folder().read(runs_file);
  folder().write(runs_file, rows.substr(0, rows.size() - 30));
  EXPECT_EQ(summary_of({"--runs", "30"}), whole);
  EXPECT_FALSE(std::filesystem::exists(folder().path() / report_file)) << "nobody asked for it";
  EXPECT_EQ(summary_of({"--runs", "30", "--report"}), whole);
  EXPECT_EQ(folder().read(report_file), page);
}

TEST_F(MonteCarlo, TellsWhatTheErrorBarsAreWorth) {
  const Json summary = Json::parse(summary_of({"--runs", "40"}));
  ASSERT_EQ(summary["trials"].size(), 6U);
  const Json& exact = summary["trials"][1];
  EXPECT_EQ(exact["label"], "IV; exact rows");
  EXPECT_EQ(exact["identified"], 40);
  for (const Json& p : exact["parameters"]) {
    // Four binomial deviations below 95 %.
    EXPECT_GE(p["coverage"], 0.81) << p;
    EXPECT_LE(std::abs(p["bias_in_spreads"].get<double>()), 4.0 / std::sqrt(40.0)) << p;
  }
  // The floor of the paper's rows.
  EXPECT_LT(named(summary["trials"][4]["parameters"], "Fv2")["coverage"], 0.3);
}

TEST_F(MonteCarlo, RefusesToGoOnWithOtherInputs) {
  (void)summary_of({"--runs", "2"});
  edit("montecarlo_s1.toml", "position_noise = 2e-5", "position_noise = 3e-5");
  expect_refused({"holds runs of other input files", "--restart"});
  (void)summary_of({"--runs", "2", "--restart"});
}

TEST_F(MonteCarlo, RefusesRunsThatDoNotSayWhatTheyAreMadeFrom) {
  (void)summary_of({"--runs", "2"});
  std::filesystem::remove(folder().path() / inputs_file);
  expect_refused({"has runs.csv without the inputs.sha256", "--restart"});
  (void)summary_of({"--runs", "2", "--restart"});
  // Not even --restart writes over a file of others.
  folder().write(inputs_file, "0123  mine.csv\n");
  expect_refused_by("rivid_montecarlo", command({"--restart"}), {"inputs.sha256: is not of rivid study"});
  EXPECT_EQ(folder().read(inputs_file), "0123  mine.csv\n");
}

TEST_F(MonteCarlo, TwoAtATimeDoNotShareAFolder) {
  Process first(command({"--runs", "1000", "--threads", "1"}), folder().path());
  while (!std::filesystem::exists(folder().path() / inputs_file)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  expect_refused({"montecarlo_s1_montecarlo: another rivid study writes there"});
  first.send(SIGTERM);
  EXPECT_EQ(first.wait().exit_code, 143);
}

TEST_F(MonteCarlo, RowsThatAreRemovedMeanwhileAreWrittenAgain) {
  const std::string whole = summary_of({"--runs", "40"});
  const std::string rows = folder().read(runs_file);
  std::filesystem::remove_all(folder().path() / "montecarlo_s1_montecarlo");
  Process running(command({"--runs", "40", "--threads", "1"}), folder().path());
  while (!std::filesystem::exists(folder().path() / inputs_file)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::filesystem::remove(folder().path() / runs_file);
  ASSERT_EQ(running.wait().exit_code, 0);
  EXPECT_EQ(folder().read(summary_file), whole);
  EXPECT_EQ(std::ranges::count(folder().read(runs_file), '\n'), std::ranges::count(rows, '\n'));
}

TEST_F(MonteCarlo, SparesItsInputs) {
  const std::string urdf = folder().read("scara.urdf");
  std::filesystem::create_directory(folder().path() / "montecarlo_s1_montecarlo");
  std::filesystem::create_symlink("../scara.urdf", folder().path() / inputs_file);
  expect_refused({"inputs.sha256: is an input of this run (scara.urdf)"});
  std::filesystem::remove_all(folder().path() / "montecarlo_s1_montecarlo");
  (void)summary_of({"--runs", "2"});
  expect_refused_by(
      "rivid_montecarlo",
      {RIVID_MONTECARLO, "merge", "montecarlo_s1.toml", "montecarlo_s1_montecarlo", "--runs", "2"},
      {"runs.csv: is an input of this run"});
  EXPECT_EQ(folder().read("scara.urdf"), urdf);
}

TEST_F(MonteCarlo, RefusesFaultsOfTheFile) {
  edit("montecarlo_s1.toml", "seed = 1", "seed = -1");
  expect_refused({"montecarlo_s1.toml:27:8: [montecarlo] seed is -1, must not be negative"});
  edit("montecarlo_s1.toml", "seed = -1", "sead = 1");
  expect_refused({"unknown key \"sead\" in [montecarlo]"});
  edit("montecarlo_s1.toml", "sead = 1", "");
  edit("montecarlo_s1.toml", "label = \"WLS; exact rows\"", "label = \"WLS, exact rows\"");
  expect_refused({"[montecarlo.trial] label", "without a comma"});
  edit("montecarlo_s1.toml", "label = \"WLS, exact rows\"", "label = \"IV; exact rows\"");
  expect_refused({"\"IV; exact rows\" is that of another trial"});
}

}  // namespace
