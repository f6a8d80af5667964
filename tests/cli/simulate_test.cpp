// rivid_simulate: what it prints, writes and returns, and what rivid_identify makes of it.

#include <gtest/gtest.h>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::content_of;
using rivid::test::Json;
using rivid::test::named;
using rivid::test::Outcome;
using rivid::test::outcome_of;
using rivid::test::parameter;

constexpr const char* log_file = "simulate_s2_simulation/log.csv";
constexpr const char* summary_file = "simulate_s2_simulation/simulation.json";

class Simulate : public rivid::test::IdentifyTool {
 protected:
  Simulate() { provide("simulate_s2.toml"); }

  static std::vector<std::string> command(const std::vector<std::string>& arguments) {
    std::vector<std::string> out = {RIVID_SIMULATE};
    out.insert(out.end(), arguments.begin(), arguments.end());
    return out;
  }

  [[nodiscard]] Outcome simulate(const std::vector<std::string>& arguments = {"simulate_s2.toml"}) const {
    return outcome_of(command(arguments), folder().path());
  }

  /// simulation.json of a run.
  [[nodiscard]] Json summary_of(const std::vector<std::string>& arguments = {"simulate_s2.toml"},
                                int exit_code = 0) const {
    const Outcome run = simulate(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_EQ(run.signal, 0);
    return Json::parse(folder().read(summary_file));
  }

  void expect_refused(const std::vector<std::string_view>& words,
                      const std::vector<std::string>& arguments = {"simulate_s2.toml"}) const {
    expect_refused_by("rivid_simulate", command(arguments), words);
  }

  /// Replaces the whole line that begins so.
  void set_line(std::string_view begin, const std::string& to) const {
    std::string text = folder().read("simulate_s2.toml");
    const std::size_t at = text.find("\n" + std::string(begin)) + 1;
    ASSERT_NE(at, 0U) << begin;
    folder().write("simulate_s2.toml", text.replace(at, text.find('\n', at) - at, to));
  }

  void add_to_simulation(const std::string& line) const {
    folder().write("simulate_s2.toml", folder().read("simulate_s2.toml") + line + "\n");
  }
};

TEST_F(Simulate, WritesALogFromWhichTheTruthIsIdentified) {
  const Json simulated = summary_of();
  EXPECT_EQ(simulated["outcome"], "completed");
  const Json result = result_of({"scara.toml", "--log", log_file});
  const Json truth = Json::parse(content_of(std::filesystem::path(RIVID_DATA) / "scara/truth.json"));
  for (const Json& p : result["parameters"]) {
    const double value = parameter(simulated, p["name"].get<std::string>())["value"];
    EXPECT_NEAR(value, truth["parameters"][p["name"].get<std::string>()]["value"], 1e-12) << p["name"];
    EXPECT_LE(p["interval_95"][0], value) << p["name"];
    EXPECT_GE(p["interval_95"][1], value) << p["name"];
  }
}

// The last digits may be those of another machine's sine.
TEST_F(Simulate, MakesTheCommittedLogs) {
  for (const std::string log : {"s1", "s2", "validation"}) {
    const std::filesystem::path scara = std::filesystem::path(RIVID_DATA) / "scara";
    const Outcome run = simulate({(scara / ("simulate_" + log + ".toml")).string(), "--output", "made"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    std::istringstream made(folder().read("made/log.csv"));
    std::istringstream committed(content_of(scara / ("scara_" + log + ".csv")));
    std::string a;
    std::string b;
    std::getline(made, a);
    std::getline(committed, b);
    ASSERT_EQ(a, b);
    int rows = 0;
    while (std::getline(made, a, rows % 7 == 6 ? '\n' : ',')) {
      std::getline(committed, b, rows % 7 == 6 ? '\n' : ',');
      ASSERT_NEAR(std::stod(a), std::stod(b), 1e-6) << log << ", cell " << rows;
      ++rows;
    }
    EXPECT_EQ(rows, 7 * 4001);
    EXPECT_FALSE(std::getline(committed, b));
  }
}

TEST_F(Simulate, TellsWhatHappened) {
  const Json summary = summary_of();
  EXPECT_EQ(summary["format"], 1);
  EXPECT_EQ(summary["samples"], 4001);
  EXPECT_EQ(summary["rate_hz"], 200.0);
  EXPECT_EQ(summary["seed"], 2002);
  EXPECT_EQ(summary["control"]["law"], "PD");
  EXPECT_EQ(summary["control"]["gains"]["k_v"], Json({7.488, 1.24}));
  EXPECT_GT(named(summary["joints"], "joint_1")["largest_tracking_error"], 1.0);
  EXPECT_GT(named(summary["friction"], "joint_2")["mode_changes"], 2);
  for (const char* const member : {"steps", "right_hand_sides", "restarts", "mode_changes", "seconds"}) {
    EXPECT_GT(summary["effort"][member], 0.0) << member;
  }
  std::vector<std::string> inputs;
  for (const Json& input : summary["provenance"]["inputs"]) {
    inputs.push_back(input["path"]);
    EXPECT_EQ(input["sha256"].get<std::string>().size(), 64U);
  }
  EXPECT_EQ(inputs, (std::vector<std::string>{"simulate_s2.toml", "scara.urdf"}));
}

TEST_F(Simulate, PrintsTheSummary) {
  const Outcome run = simulate();
  EXPECT_TRUE(run.out.starts_with("Simulation: completed, 4001 samples at 200 Hz\n")) << run.out;
  EXPECT_NE(run.out.find("joint_1: largest tracking error"), std::string::npos) << run.out;
  EXPECT_TRUE(run.err.ends_with(
      "wrote simulate_s2_simulation/log.csv\nwrote simulate_s2_simulation/simulation.json\n"))
      << run.err;
  const Outcome json = simulate({"simulate_s2.toml", "--json"});
  EXPECT_EQ(json.out, folder().read(summary_file));
  const Outcome quiet = simulate({"simulate_s2.toml", "--quiet"});
  EXPECT_EQ(quiet.out + quiet.err, "");
  const Outcome help = simulate({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* const word : {"--seed", "--parameters", "--output", "--json", "--quiet", "Exit codes"}) {
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  }
}

TEST_F(Simulate, TheSeedDecidesTheLog) {
  EXPECT_EQ(simulate().exit_code, 0);
  const std::string first = folder().read(log_file);
  EXPECT_EQ(simulate().exit_code, 0);
  EXPECT_EQ(folder().read(log_file), first);
  const Json summary = summary_of({"simulate_s2.toml", "--seed", "7"});
  EXPECT_NE(folder().read(log_file), first);
  EXPECT_EQ(summary["provenance"]["options"]["overrides"], Json({{"seed", "7"}}));
}

TEST_F(Simulate, TakesParametersFromAResultAndFromItsOwnSummary) {
  EXPECT_EQ(summary_of()["outcome"], "completed");
  const Json result = result_of();
  const Json of_result = summary_of(
      {"simulate_s2.toml", "--parameters", "scara_result/result.json", "--output", "simulate_s2_simulation"});
  for (const Json& p : result["parameters"]) {
    EXPECT_NEAR(parameter(of_result, p["name"].get<std::string>())["value"].get<double>(),
                p["value"].get<double>(), 1e-12);
  }
  folder().write("earlier.json", folder().read(summary_file));
  set_line("parameters =", "parameters = \"earlier.json\"");
  const Json again = summary_of();
  EXPECT_EQ(again["parameters"], of_result["parameters"]);
  EXPECT_EQ(again["provenance"]["inputs"][2]["path"], "earlier.json");
  // It would be gone if the next simulation took its place.
  set_line("parameters =", std::string("parameters = \"") + summary_file + "\"");
  EXPECT_EQ(simulate().exit_code, 2);
  EXPECT_EQ(Json::parse(folder().read(summary_file)), again);
}

// Outcomes

TEST_F(Simulate, ParametersThatAreNoRobotEndItWithTheReason) {
  folder().write("odd.toml",
                 "ZZ1R = 3.44\nFv1 = 0.03\nFc1 = 0.82\nZZ2 = 0.001\nMX2 = 0.242\nMY2 = 0.014\n"
                 "Fv2 = 0.013\nFc2 = 0.137\n");
  set_line("parameters =", "parameters = \"odd.toml\"");
  const Json summary = summary_of({"simulate_s2.toml"}, 1);
  EXPECT_EQ(summary["outcome"], "not positive definite");
  EXPECT_NE(summary["reason"].get<std::string>().find("M(q) is not positive definite"), std::string::npos)
      << summary["reason"];
  const std::string log = folder().read(log_file);
  EXPECT_TRUE(log.starts_with("t,q1,q2,v1,v2,qref1,qref2\n")) << log;
  EXPECT_EQ(log.find("nan"), std::string::npos);
  EXPECT_EQ(summary["samples"], std::ranges::count(log, '\n') - 1);
}

TEST_F(Simulate, AnInertiaThatIsNotPositiveEndsItBeforeTheStart) {
  folder().write("odd.toml",
                 "ZZ1R = -3.44\nFv1 = 0.03\nFc1 = 0.82\nZZ2 = 0.062\nMX2 = 0.242\nMY2 = 0.014\n"
                 "Fv2 = 0.013\nFc2 = 0.137\n");
  set_line("parameters =", "parameters = \"odd.toml\"");
  const Json summary = summary_of({"simulate_s2.toml"}, 1);
  EXPECT_EQ(summary["outcome"], "not positive definite");
  EXPECT_NE(summary["reason"].get<std::string>().find("joint_1"), std::string::npos) << summary["reason"];
  EXPECT_EQ(folder().read(log_file), "t,q1,q2,v1,v2,qref1,qref2\n");
}

TEST_F(Simulate, AnUnstableLoopDivergesAndLeavesNoNan) {
  set_line("k_v =", "k_v = [7.488, 1000]");
  const Json summary = summary_of({"simulate_s2.toml"}, 1);
  EXPECT_EQ(summary["outcome"], "diverged") << summary["reason"];
  const std::string log = folder().read(log_file);
  EXPECT_EQ(log.find("nan"), std::string::npos);
  EXPECT_EQ(log.find("inf"), std::string::npos);
}

TEST_F(Simulate, AStepFarBeyondTheSaturationIsSimulated) {
  set_line("via =", "via = [[0, 0], [3, 4]]");
  set_line("durations =", "durations = 0.01");
  set_line("law =", "law = \"pd\"\nv_tau_max = [2, 0.5]");
  add_to_simulation("duration = 2");
  const Json summary = summary_of();
  EXPECT_EQ(summary["outcome"], "completed");
  EXPECT_GT(named(summary["joints"], "joint_1")["largest_tracking_error"], 2.0);
}

TEST_F(Simulate, BudgetsEndAHopelessRun) {
  add_to_simulation("max_steps = 100");
  const Json summary = summary_of({"simulate_s2.toml"}, 1);
  EXPECT_EQ(summary["outcome"], "too slow");
  EXPECT_NE(summary["reason"].get<std::string>().find("the budget of 100 steps is used up"),
            std::string::npos);
}

TEST_F(Simulate, WarnsOfAReferenceBeyondTheJointLimits) {
  set_line("via =", "via = [[0, 0], [4, 4]]");
  const Outcome run = simulate();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(
      run.err.find(
          "warning [reference_limits] the reference of joint \"joint_1\" reaches 4, beyond its limit 3.5"),
      std::string::npos)
      << run.err;
}

TEST_F(Simulate, ADryRunReadsAndChecksEverythingAndWritesNothing) {
  const auto before = folder().entries();
  const Outcome run = simulate({"simulate_s2.toml", "--dry-run", "--seed", "7", "--output", "made"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_NE(run.out.find("robot       scara.urdf: \"scara\", 2 joints, 8 base parameters\n"),
            std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("simulation  4001 samples at 200 Hz, 20 s, seed 7\n"), std::string::npos) << run.out;
  EXPECT_TRUE(run.out.ends_with("would write made/log.csv\nwould write made/simulation.json\n")) << run.out;
  EXPECT_EQ(folder().entries(), before);
  const Outcome quiet = simulate({"simulate_s2.toml", "--dry-run", "--quiet"});
  EXPECT_EQ(quiet.out + quiet.err, "");
  folder().write("wrong.csv", "name,value\nNOPE,1\n");
  expect_refused({"\"NOPE\" is none of the robot's 8 base parameters"},
                 {"simulate_s2.toml", "--dry-run", "--parameters", "wrong.csv"});
}

// Refusals

TEST_F(Simulate, RefusesAMistypedKeyWithItsPlace) {
  set_line("seed =", "sead = 2002");
  expect_refused({"simulate_s2.toml:", ":1: unknown key \"sead\" in [simulation]; did you mean \"seed\"?"});
}

TEST_F(Simulate, RefusesGainsOfZero) {
  set_line("k_v =", "k_v = [0, 1.24]");
  expect_refused({"[control] k_v of joint \"joint_1\" is 0"});
}

TEST_F(Simulate, RefusesAToleranceOfZero) {
  set_line("rtol =", "rtol = 0");
  expect_refused({"[simulation] rtol is 0, must be between 1e-15 and 1"});
}

TEST_F(Simulate, RefusesFilesAndColumnsThatAreNotThere) {
  set_line("parameters =", "parameters = \"none.json\"");
  expect_refused({"none.json: the parameter file can not be read"});
  set_line("parameters =", "added_control = { file = \"scara_s2.csv\", columns = [\"q1\", \"qq2\"] }");
  expect_refused({"scara_s2.csv: there is no column \"qq2\"", "did you mean \"q2\"?"});
}

TEST_F(Simulate, RefusesAnExperimentWithoutItsSections) {
  expect_refused({"scara.toml: section [control] is missing"}, {"scara.toml"});
  expect_refused({"experiment is required"}, {});
  expect_refused({"--seed"}, {"simulate_s2.toml", "--seed", "many"});
  expect_refused({"--seed"}, {"simulate_s2.toml", "--seed", "-1"});
  expect_refused({"scara.urdf/log.csv: can not be written"}, {"simulate_s2.toml", "--output", "scara.urdf"});
}

TEST_F(Simulate, RefusesMoreSamplesThanAMemoryHolds) {
  add_to_simulation("duration = 1e9");
  expect_refused({"[simulation] 1e+09 s at 200 Hz are 2e+11 samples"});
}

}  // namespace
