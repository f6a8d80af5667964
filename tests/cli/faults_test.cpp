// System calls that fail: exit code 2 or 3 with a reason, and nothing that was there is lost.
// RIVID_FAULT_ROUNDS=N makes N times as many runs.

#include <gtest/gtest.h>

#include <cstdlib>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
using rivid::test::Outcome;
using rivid::test::outcome_of;
using rivid::test::Process;

class Faults : public rivid::test::IdentifyTool {
 protected:
  Faults() {
    EXPECT_EQ(identify(arguments).exit_code, 0);
    result = folder().read("scara_result/result.json");
    page = folder().read("scara_result/report.html");
  }

  static int rounds() {
    const char* const text = std::getenv("RIVID_FAULT_ROUNDS");
    return text == nullptr ? 1 : std::atoi(text);
  }

  [[nodiscard]] std::vector<std::string> left_behind() const {
    std::vector<std::string> out = folder().entries();
    std::erase_if(out, [](const std::string& name) { return name.find("/.rivid-") == std::string::npos; });
    return out;
  }

  const std::vector<std::string> arguments = {"scara.toml", "--report"};
  std::string result;
  std::string page;
};

TEST_F(Faults, OfSystemCallsLoseNothingAndAreTold) {
  const std::string mark = (folder().path() / "mark").string();
  int happened = 0;
  for (int round = 0; round < rounds(); ++round) {
    for (const char* const call : {"write", "read", "fsync", "open", "rename"}) {
      for (const char* const error : {"ENOSPC", "EIO", "EINTR", "SHORT"}) {
        for (int which = 1; which <= 10; ++which) {
          std::filesystem::remove(mark);
          std::vector<std::string> command = {
              "/usr/bin/env", "LD_PRELOAD=" RIVID_INJECT,
              "RIVID_FAULT=" + std::string(call) + ":" + error + ":" + std::to_string(which),
              "RIVID_FAULT_MARK=" + mark};
          for (const std::string& part : rivid::test::identify_command(arguments)) {
            command.push_back(part);
          }
          const Outcome run = outcome_of(command, folder().path());
          if (!std::filesystem::exists(mark)) {
            EXPECT_EQ(run.exit_code, 0) << run.err;
            break;  // there are no further calls
          }
          ++happened;
          const std::string what =
              std::string(call) + " " + error + " " + std::to_string(which) + ": " + run.err;
          EXPECT_EQ(run.signal, 0) << what;
          EXPECT_TRUE(run.exit_code == 0 || run.exit_code == 2 || run.exit_code == 3) << what;
          EXPECT_TRUE(run.exit_code == 0 || run.err.find("rivid_identify: ") != std::string::npos) << what;
          const bool whole = run.exit_code == 0 || run.err.find("standard output") != std::string::npos;
          EXPECT_TRUE(!whole || folder().read("scara_result/result.json") == result) << what;
          EXPECT_EQ(folder().read("scara_result/report.html"), page) << what;
          EXPECT_EQ(folder().read("scara_result/result.json"), result) << what;
          EXPECT_EQ(left_behind(), std::vector<std::string>()) << what;
        }
      }
    }
  }
  EXPECT_GT(happened, 80);
  RecordProperty("faults", happened);
}

TEST_F(Faults, OfAKillLeaveOldOrNewFilesAndNoPartOfOne) {
  const int kills = 20 * rounds();
  for (int k = 0; k < kills; ++k) {
    Process process(rivid::test::identify_command(arguments), folder().path());
    ::usleep(static_cast<useconds_t>(100000 * k / kills));
    process.send(SIGKILL);
    (void)process.wait();
    EXPECT_EQ(folder().read("scara_result/result.json"), result);
    EXPECT_EQ(folder().read("scara_result/report.html"), page);
  }
  EXPECT_EQ(identify(arguments).exit_code, 0);
  EXPECT_EQ(left_behind(), std::vector<std::string>()) << "the next run sweeps";
}

}  // namespace
