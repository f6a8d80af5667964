// What has no end or no meaning is refused or given up, with the reason; no run is left with numbers that are
// none.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>
#include <sstream>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::content_of;
using rivid::test::Json;
using rivid::test::Outcome;
using rivid::test::outcome_of;

class Budgets : public rivid::test::IdentifyTool {
 protected:
  // Through a shell, ended after minutes: a hang is exit code 124.
  [[nodiscard]] Outcome shell(const std::string& script) const {
    return outcome_of({"/bin/sh", "-c", script}, folder().path());
  }
  std::string identifier = "timeout 300 '" + std::string(RIVID_IDENTIFY) + "' ";
  std::string montecarlo = "timeout 300 '" + std::string(RIVID_MONTECARLO) + "' ";
};

TEST_F(Budgets, OfThreadsAreThoseOfTheMachine) {
  provide("montecarlo_s1.toml");
  // The memory for the stacks of a thousand threads is not there.
  for (const std::string& tool : {identifier + "scara.toml", montecarlo + "montecarlo_s1.toml --runs 2"}) {
    const Outcome run = shell("ulimit -v 300000; " + tool + " --threads 1024");
    EXPECT_EQ(run.exit_code, 0) << tool << ": " << run.err;
  }
}

TEST_F(Budgets, OfRunsStartsAndSecondsAreTold) {
  provide("montecarlo_s1.toml");
  const std::string excite = "timeout 30 '" + std::string(RIVID_EXCITE) + "' ";
  for (const auto& [command, words] :
       {std::pair(montecarlo + "montecarlo_s1.toml --runs 1000000000",
                  "--runs: it is 1000000000, must be at most 1000000"),
        std::pair(montecarlo + "montecarlo_s1.toml --set montecarlo.runs=1000000000",
                  "runs is 1000000000, must be at most 1000000"),
        std::pair(excite + "'" RIVID_DATA "/six_axis/excite.toml' --seconds 0",
                  "--seconds: it is 0 s, must lie between 1 and 1000000"),
        std::pair(excite + "'" RIVID_DATA "/six_axis/excite.toml' --set excitation.samples=100000",
                  "samples is 100000, must be at most 10000"),
        std::pair(excite + "'" RIVID_DATA "/six_axis/excite.toml' --set excitation.limits.lower=-1e300",
                  "lower is -1e+300 rad, m, must lie between -10000 and 10000")}) {
    const Outcome run = shell("ulimit -v 2000000; " + command);
    EXPECT_EQ(run.exit_code, 2) << command << run.err;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  }
}

TEST_F(Budgets, FilesThatNestDeeperThanTheStackAreRefused) {
  std::string key = "a";
  for (int k = 0; k < 300'000; ++k) {
    key += ".a";
  }
  folder().write("deep.toml", key + " = 1\n");
  for (const char* const program : {RIVID_IDENTIFY, RIVID_SIMULATE, RIVID_MONTECARLO, RIVID_EXCITE}) {
    const Outcome run = shell("timeout 30 '" + std::string(program) + "' deep.toml");
    EXPECT_EQ(run.exit_code, 2) << program << run.err;
    EXPECT_NE(run.err.find("deep.toml:1: a key has more than 64 parts"), std::string::npos) << run.err;
  }
  folder().write("deep.json", std::string(100'000, '[') + std::string(100'000, ']'));
  const Outcome run = shell(identifier + "validate deep.json scara_s2.csv");
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_NE(run.err.find("deep.json: lists and objects within each other go deeper than 64"),
            std::string::npos)
      << run.err;
}

TEST_F(Budgets, NumbersThatSayNothingAreNotPrinted) {
  const auto with_columns = [&](const std::string& name, const auto& change) {
    folder().write(name, content_of(std::filesystem::path(RIVID_DATA) / "scara" / "scara_s2.csv"));
    rewrite_rows(name, [&](const std::string& line) {
      std::vector<std::string> cells;
      std::istringstream in(line);
      for (std::string cell; std::getline(in, cell, ',');) {
        cells.push_back(cell);
      }
      change(cells);  // t, q1, q2, v1, v2, qref1, qref2
      std::string out;
      for (const std::string& cell : cells) {
        out += (out.empty() ? "" : ",") + cell;
      }
      return out;
    });
  };
  using Cells = std::vector<std::string>;
  with_columns("held.csv", [](Cells& c) { c[1] = c[5] = "0.3"; });
  with_columns("tiny.csv", [](Cells& c) {
    for (const std::size_t i : {3U, 4U}) {
      c[i] = std::to_string(std::stod(c[i])) + "e-15";
    }
  });
  with_columns("zero.csv", [](Cells& c) { std::fill(c.begin() + 1, c.end(), "0"); });
  with_columns("hours.csv", [](Cells& c) { c[0] = std::to_string(std::stod(c[0])) + "e300"; });
  ASSERT_EQ(shell(identifier + "scara.toml --quiet").exit_code, 0);
  folder().write("forecast.toml", "robot.urdf = \"scara.urdf\"\n[excitation]\nduration = 5\nrate_hz = 200\n");
  const std::string forecast = "timeout 30 '" + std::string(RIVID_EXCITE) + "' forecast forecast.toml ";
  const std::string online = "timeout 30 '" + std::string(RIVID_ONLINE) + "' --result scara_result ";
  const std::regex nonsense("\\bnan\\b|\\binf\\b|e\\+1[0-9]|e\\+[2-9][0-9]|[0-9]{16}");
  for (const std::string& command : {forecast + "held.csv", forecast + "zero.csv",
                                     identifier + "compare scara_result scara.urdf --log zero.csv",
                                     identifier + "compare scara_result scara.urdf --log held.csv",
                                     identifier + "validate scara_result tiny.csv",
                                     identifier + "scara.toml --validate tiny.csv --output v",
                                     identifier + "scara.toml --log held.csv --output h",
                                     identifier + "check scara.toml --set log.files=held.csv",
                                     online + "held.csv", online + "zero.csv --gains 100"}) {
    const Outcome run = shell(command);
    EXPECT_LE(run.exit_code, 2) << command << run.err;
    std::smatch found;
    const std::string said = run.out + run.err;
    EXPECT_FALSE(std::regex_search(said, found, nonsense)) << command << "\n"
                                                           << found.str() << " in\n"
                                                           << said;
  }
  const Outcome hours = shell(identifier + "scara.toml --log hours.csv --set log.rate_hz=200 --output t");
  EXPECT_EQ(hours.exit_code, 0);
  EXPECT_NE(hours.err.find("irregular: 4001 samples; steps of 5e+297 to "), std::string::npos) << hours.err;
  EXPECT_EQ(hours.err.find("jitter"), std::string::npos) << hours.err;
  const Json held = Json::parse(folder().read("h/result.json"));
  const Json& tests = held["tests"]["residuals"][0];
  EXPECT_TRUE(tests["autocorrelation"].is_null() && tests["whiteness"]["p"].is_null()) << tests;
}

TEST_F(Budgets, OfTicksAreTold) {
  provide("scara_iv.toml");
  edit("scara_iv.toml", "rate_hz = 200\n", "rate_hz = 1e6\n");
  const Outcome run = shell(identifier + "scara_iv.toml");
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_NE(run.err.find("ticks of the controller"), std::string::npos) << run.err;
}

TEST_F(Budgets, OfSimulationsEndTheIteration) {
  provide("scara_iv.toml");
  for (const char* const budget : {"max_steps=50", "max_seconds=1e-9"}) {
    const Outcome run = shell(identifier + "scara_iv.toml --set method.simulation." + budget);
    EXPECT_EQ(run.exit_code, 1) << run.err;
    const Json result = Json::parse(folder().read("scara_iv_result/result.json"));
    EXPECT_EQ(result["status"], "gave_up");
    const std::string reason = result["reasons"][0];
    EXPECT_NE(reason.find("is used up; simulation in [method] has the budgets"), std::string::npos) << reason;
  }
}

TEST_F(Budgets, OfThePhysicalModelEndWithNumbersThatOverflow) {
  for (const char* const mass : {"1e60", "1e150", "1e300"}) {
    provide("scara.urdf");
    edit("scara.urdf", "<mass value=\"40\"/>", "<mass value=\"" + std::string(mass) + "\"/>");
    const Outcome run = shell(identifier + "scara.toml --physical");
    EXPECT_TRUE(run.exit_code >= 0 && run.exit_code <= 3) << mass << ": " << run.exit_code << run.err;
  }
  for (const char* const inertia : {"1e-20", "1e-100", "1e-300"}) {
    provide("scara.urdf");
    edit("scara.urdf", "ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1.3\" iyz=\"0\" izz=\"2.04\"",
         "ixx=\"" + std::string(inertia) + "\" ixy=\"0\" ixz=\"0\" iyy=\"" + inertia + "\" iyz=\"0\" izz=\"" +
             inertia + "\"");
    const Outcome run = shell(identifier + "scara.toml --physical");
    EXPECT_TRUE(run.exit_code >= 0 && run.exit_code <= 3) << inertia << ": " << run.exit_code << run.err;
  }
}

TEST_F(Budgets, NothingIsIdentifiedWithoutAValue) {
  edit("scara.toml", "position = [\"q1\", \"q2\"]",
       "position = [{ column = \"q1\", scale = 1e-9 }, { column = \"q2\", scale = 1e-9 }]");
  const Outcome run = shell(identifier + "scara.toml");
  ASSERT_TRUE(std::filesystem::exists(folder().path() / "scara_result/result.json")) << run.err;
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  const bool whole = std::ranges::none_of(
      result["parameters"], [](const Json& p) { return p["value"].is_null() || p["sigma"].is_null(); });
  EXPECT_EQ(run.exit_code == 0, result["status"] == "identified");
  EXPECT_TRUE(whole || result["status"] != "identified") << run.out;
}

TEST_F(Budgets, CorrelationsWithAJointThatIsHeldStillAreWithinOne) {
  rewrite_rows("scara_s2.csv", [](const std::string& line) {
    const std::size_t begin = line.find(',') + 1;
    return line.substr(0, begin) + "0.25" + line.substr(line.find(',', begin));
  });
  const Outcome run = shell(identifier + "scara.toml --json");
  EXPECT_EQ(run.exit_code, 1) << run.err;
  const std::regex correlation("correlation\"?:? \\(?(-?[0-9.e+-]+)");
  int found = 0;
  for (std::sregex_iterator at(run.out.begin(), run.out.end(), correlation), end; at != end; ++at) {
    EXPECT_LE(std::abs(std::stod((*at)[1])), 1.0) << at->str();
    ++found;
  }
  EXPECT_GT(found, 0);
}

TEST_F(Budgets, RunsOfWhichNoneIsIdentifiedAreNoSuccess) {
  provide("montecarlo_iv.toml");
  const Outcome run = shell(
      montecarlo + "montecarlo_iv.toml --runs 2 --set method.max_iterations=1 --set reference.durations=0.5");
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_NE(run.out.find("0 of 2 runs identified"), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("nan"), std::string::npos) << run.out;
}

TEST_F(Budgets, FlippedBitsOfRowsAreSeen) {
  provide("montecarlo_s1.toml");
  ASSERT_EQ(shell(montecarlo + "montecarlo_s1.toml --runs 2").exit_code, 0);
  const std::string file = "montecarlo_s1_montecarlo/runs.csv";
  // One flipped byte, wherever: the same summary, or a refusal.
  const std::string summary = folder().read("montecarlo_s1_montecarlo/summary.json");
  const std::string rows = folder().read(file);
  const std::string again = montecarlo + "montecarlo_s1.toml --runs 2 --quiet";
  int refused = 0;
  for (std::size_t i = 7; i < rows.size(); i += rows.size() / 40) {
    std::string flipped = rows;
    flipped[i] = static_cast<char>(flipped[i] ^ 1);
    folder().write(file, flipped);
    const Outcome run = shell(again);
    refused += run.exit_code == 2 ? 1 : 0;
    EXPECT_TRUE(run.exit_code == 2 || folder().read("montecarlo_s1_montecarlo/summary.json") == summary)
        << "byte " << i;
  }
  EXPECT_GT(refused, 30);
}

TEST_F(Budgets, EscapeSequencesOfNamesDoNotReachTheScreen) {
  for (const std::string& arguments :
       {std::string("init scara.urdf scara_s2.csv --output 1"), std::string("scara.toml --output 2"),
        std::string("scara.toml --dry-run --output 3")}) {
    const Outcome run = shell(identifier + arguments + "'a\x1B[31m\xC2\x9Bm.toml'");
    EXPECT_LT(run.exit_code, 2) << run.err;
    EXPECT_EQ((run.out + run.err).find('\x1B'), std::string::npos) << arguments << run.err;
    EXPECT_EQ((run.out + run.err).find("\xC2\x9B"), std::string::npos) << arguments << run.err;
  }
}

TEST_F(Budgets, HelpThatCanNotBePrintedIsNoSuccess) {
  for (const char* const program : {RIVID_IDENTIFY, RIVID_SIMULATE, RIVID_MONTECARLO}) {
    EXPECT_EQ(shell("'" + std::string(program) + "' --help > /dev/full").exit_code, 2);
    EXPECT_EQ(shell("'" + std::string(program) + "' --version >&-").exit_code, 2);
  }
}

// Half of the sampling rate but for a billionth is a filter that never forgets.
TEST_F(Budgets, AFilterThatNeverSettlesIsRefused) {
  for (const char* const command : {"check scara.toml", "scara.toml"}) {
    const Outcome run = shell(identifier + command + " --set signal.cutoff_hz=99.9999999");
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_NE(run.err.find("cutoff_hz is 99.9999999 Hz, must be at most"), std::string::npos) << run.err;
  }
}

TEST_F(Budgets, EscapeSequencesOfFilesDoNotReachTheScreen) {
  edit("scara.urdf", "<robot name=\"scara\">", "<robot name=\"sc&#xC2;&#x9B;31mara\">");
  std::string log = folder().read("scara_s2.csv");
  log.replace(log.find("qref1"), 5, "\x1B[31m\xFF");
  folder().write("scara_s2.csv", log);
  for (const std::string& arguments :
       {std::string("scara.toml"), std::string("scara.toml --set log.position='[\"a\",\"b\"]'"),
        std::string("scara.toml --dry-run"), std::string("init scara.urdf scara_s2.csv --print")}) {
    const Outcome run = shell(identifier + arguments);
    for (const std::string* text : {&run.out, &run.err}) {
      EXPECT_EQ(text->find('\x1B'), std::string::npos) << arguments;
      EXPECT_EQ(text->find('\xFF'), std::string::npos) << arguments;
      EXPECT_EQ(text->find("\xC2\x9B"), std::string::npos) << arguments;
    }
  }
  folder().write("esc.urdf", "<robot name=\"a\x1B[31m\"><link name=\"l\"/></robot>");
  const Outcome refused = shell(identifier + "init esc.urdf scara_s2.csv");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("has a control character in attribute name"), std::string::npos) << refused.err;
}

}  // namespace
