// SIGKILL at any moment of any tool: each file is the old one or the new one, and what goes on from an
// interrupted run ends as if there had been none. RIVID_FAULT_ROUNDS=N makes N times as many kills.

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <random>
#include <regex>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::content_of;
using rivid::test::Outcome;
using rivid::test::outcome_of;
using rivid::test::Process;

using Command = std::vector<std::string>;
using Clock = std::chrono::steady_clock;

// Files of a folder by their names.
using Files = std::map<std::string, std::string>;

constexpr int kills_of_a_round = 4;
constexpr unsigned seed = 20261122;

int kills() {
  const char* const text = std::getenv("RIVID_FAULT_ROUNDS");
  return kills_of_a_round * (text == nullptr ? 1 : std::atoi(text));
}

// What a simulation took is not the same twice.
std::string without_times(const std::string& content) {
  static const std::regex seconds("\"seconds\": [^,\n]*");
  return std::regex_replace(content, seconds, "\"seconds\"");
}

class Kills : public rivid::test::IdentifyTool {
 protected:
  Kills() {
    constexpr std::size_t lines = 1500;
    keep_lines("scara_s2.csv", lines);
    keep_lines("scara_validation.csv", lines);
    for (const char* const file : {"simulate_s1.toml", "montecarlo_s1.toml"}) {
      provide(file);
    }
    for (const char* const file : {"six_axis.urdf", "excite.toml"}) {
      folder().write(file, content_of(std::filesystem::path(RIVID_DATA) / "six_axis" / file));
    }
    EXPECT_EQ(identify({"scara.toml", "--physical", "--output", "model"}).exit_code, 0);
  }

  [[nodiscard]] Files files_of(const std::string& name) const {
    Files out;
    const std::filesystem::path path = folder().path() / name;
    if (!std::filesystem::exists(path)) {
      return out;
    }
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
      out[entry.path().filename().string()] = without_times(content_of(entry.path()));
    }
    return out;
  }

  // Runs a command to its end; what it took.
  [[nodiscard]] double seconds_of(const Command& command) const {
    const auto begin = Clock::now();
    const Outcome run = outcome_of(command, folder().path());
    EXPECT_EQ(run.exit_code, 0) << command.front() << ": " << run.err;
    return std::chrono::duration<double>(Clock::now() - begin).count();
  }

  // Starts a command and kills it at a moment of a run that takes so long, or shortly after; again and
  // earlier where it has ended by then, for the run that was timed may have had to wait for other processes.
  void kill(const Command& command, double seconds) {
    for (bool killed = false; !killed; seconds *= 0.7) {
      std::uniform_real_distribution<double> moment(0.0, 1.1 * seconds);
      Process process(command, folder().path());
      ::usleep(static_cast<useconds_t>(1e6 * moment(random_)));
      process.send(SIGKILL);
      killed = process.wait().signal == SIGKILL;
    }
  }

  // Two commands write other contents into the folder "out" in turn, and are killed.
  void expect_old_or_new(const Command& one, const Command& other) {
    std::array<Files, 2> whole;
    double seconds = 0.0;
    for (const int k : {1, 0}) {
      seconds = seconds_of(k == 0 ? one : other);
      whole[static_cast<std::size_t>(k)] = files_of("out");
    }
    ASSERT_FALSE(whole[0].empty());
    EXPECT_NE(whole[0], whole[1]) << "else nothing tells them";
    for (int k = 0; k < kills(); ++k) {
      kill(k % 2 == 0 ? other : one, seconds);
      Files found = files_of("out");
      std::erase_if(found, [](const auto& file) { return file.first.starts_with(".rivid-"); });
      ASSERT_EQ(found.size(), whole[0].size()) << "seed " << seed << ", kill " << k;
      for (const auto& [name, content] : found) {
        ASSERT_TRUE(content == whole[0][name] || content == whole[1][name])
            << name << ", seed " << seed << ", kill " << k << ":\n"
            << content;
      }
    }
    (void)seconds_of(one);
    EXPECT_EQ(files_of("out"), whole[0]) << "the next run sweeps";
  }

  std::mt19937_64 random_{seed};
};

Command with(Command command, const Command& more) {
  command.insert(command.end(), more.begin(), more.end());
  return command;
}

TEST_F(Kills, OfAnIdentification) {
  const Command tool = {RIVID_IDENTIFY, "scara.toml", "--report", "--physical", "--output", "out"};
  expect_old_or_new(with(tool, {"--set", "signal.decimation=10"}),
                    with(tool, {"--set", "signal.decimation=20"}));
}

TEST_F(Kills, OfAnExport) {
  const Command tool = {RIVID_IDENTIFY, "export", "model", "--to", "pinocchio", "--output", "out/model.urdf"};
  std::filesystem::create_directory(folder().path() / "out");
  ASSERT_EQ(
      identify({"scara.toml", "--physical", "--output", "other", "--set", "signal.decimation=40"}).exit_code,
      0);
  Command other = tool;
  other[2] = "other";
  expect_old_or_new(tool, other);
}

TEST_F(Kills, OfAComparison) {
  const Command tool = {RIVID_IDENTIFY, "compare", "model", "--report", "--output", "out", "--log"};
  expect_old_or_new(with(tool, {"scara_s2.csv"}), with(tool, {"scara_validation.csv"}));
}

TEST_F(Kills, OfASimulation) {
  const Command tool = {RIVID_SIMULATE, "simulate_s1.toml",        "--output", "out",
                        "--set",        "reference.durations=0.5", "--seed"};
  expect_old_or_new(with(tool, {"1"}), with(tool, {"2"}));
}

// The moment that few kills meet: the table of a run has taken its place, its document has not.
TEST_F(Kills, BetweenATableAndItsDocumentLeaveTheTableARivids) {
  const Command tool = {RIVID_SIMULATE, "simulate_s1.toml",        "--output", "out",
                        "--set",        "reference.durations=0.5", "--seed"};
  (void)seconds_of(with(tool, {"1"}));
  const std::string before = folder().read("out/simulation.json");
  (void)seconds_of(with(tool, {"2"}));
  folder().write("out/.rivid-abcdef", folder().read("out/simulation.json"));
  folder().write("out/simulation.json", before);
  (void)seconds_of(with(tool, {"3"}));
  EXPECT_EQ(files_of("out").size(), 2U);
  folder().write("out/simulation.json", before);
  EXPECT_EQ(outcome_of(with(tool, {"3"}), folder().path()).exit_code, 2) << "nobody's table";
}

TEST_F(Kills, OfAReplay) {
  const Command tool = {RIVID_ONLINE, "scara_s2.csv", "--result", "model/result.json",
                        "--output",   "out",          "--gains"};
  expect_old_or_new(with(tool, {"0"}), with(tool, {"5"}));
}

TEST_F(Kills, OfAnExcitation) {
  const Command tool = {RIVID_EXCITE, "excite.toml",
                        "--starts",   "1",
                        "--set",      "excitation.evaluations=3",
                        "--set",      "excitation.duration=4",
                        "--set",      "excitation.rate_hz=100",
                        "--output",   "out",
                        "--seed"};
  expect_old_or_new(with(tool, {"1"}), with(tool, {"2"}));
}

TEST_F(Kills, OfAStudyGoOnToTheSameSummary) {
  const Command tool = {RIVID_MONTECARLO, "montecarlo_s1.toml",      "--runs",   "3",  "--report",
                        "--set",          "reference.durations=0.3", "--output", "out"};
  const double seconds = seconds_of(tool);
  const Files whole = files_of("out");
  for (int k = 0; k < kills(); ++k) {
    std::filesystem::remove_all(folder().path() / "out");
    kill(tool, seconds);
    (void)seconds_of(tool);
    Files found = files_of("out");
    for (const char* const file : {"summary.json", "report.html"}) {
      ASSERT_EQ(found[file], whole.at(file)) << "seed " << seed << ", kill " << k;
    }
    ASSERT_EQ(found.size(), whole.size()) << "seed " << seed << ", kill " << k;
  }
}

}  // namespace
