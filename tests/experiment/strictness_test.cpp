// What an experiment file says is heard or refused, never passed over.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"
#include "support/complaint.hpp"
#include "support/temporary_file.hpp"

namespace rivid {
namespace {

const std::string robot = "robot.urdf = \"" RIVID_DATA "/scara/scara.urdf\"\n";

// An experiment on the SCARA of data/scara that says so.
Experiment read(const std::string& text) {
  const test::TemporaryFile file(robot + text, "experiment.toml");
  return read_experiment(file.path());
}

// What read_experiment() says about it; empty if it is read.
std::string refusal(const std::string& text) {
  return test::complaint_of([&] { return read(text); });
}

TEST(ReadExperiment, TakesTheSmoothingOfSignsForAllJointsOrForOne) {
  const std::string rest = "[log]\nfiles = \"a.csv\"\n[signal]\ncutoff_hz = 20\n";
  const Experiment experiment =
      read("robot.sign_speed = 0.01\nrobot.joints.joint_2.sign_speed = 0.5\n" + rest);
  EXPECT_EQ(experiment.robot.joints.at(0).sign_speed, 0.01);
  EXPECT_EQ(experiment.robot.joints.at(1).sign_speed, 0.5);
  EXPECT_NE(
      refusal("robot.sign_speed = -1\n" + rest).find("sign_speed is -1, must be finite and not negative"),
      std::string::npos);
}

TEST(ReadExperiment, RefusesWhatNestsDeeperThanTheStack) {
  const auto times = [](int count, const std::string& what) {
    std::string out;
    for (int k = 0; k < count; ++k) {
      out += what;
    }
    return out;
  };
  const std::string said =
      ":3: a key has more than 64 parts, or as many lists and tables stand within each other";
  const int many = 300'000;
  const std::string key = "a" + times(many, ".a");
  const std::string quoted = "\"a\"" + times(many, ".'a'");
  for (const std::string& line :
       {key + " = 1", "[" + key + "]", "[[" + key + "]]", quoted + " = 1", "b = { " + key + " = 1 }",
        "b = [" + times(3, "\"") + "x" + times(5, "\"") + ", { " + key + " = 1 }]",
        "b = [" + times(3, "'") + "y" + times(5, "'") + ", { " + key + " = 1 }]",
        "b = " + times(many, "[") + times(many, "]"), "b = " + times(many, "{a=") + "1" + times(many, "}")}) {
    EXPECT_NE(refusal("[signal]\n" + line + "\n").find(said), std::string::npos)
        << line.substr(0, 30) << ": " << refusal("[signal]\n" + line + "\n").substr(0, 200);
  }
  // Dots and brackets of strings and comments are none.
  const std::string dots = times(1000, ".[{");
  for (const std::string& text :
       {"# " + dots + "\n[log]\nfiles = \"a.csv\"\n", "[log]\nfiles = \"" + dots + "\"\n",
        "[log]\nfiles = '" + dots + "'\n", "[log]\nfiles = \"\\\"" + dots + "\"\n",
        "[log]\nfiles = " + times(4, "\"") + dots + "\n" + dots + times(3, "\"") + "\n"}) {
    EXPECT_EQ(refusal(text), "") << text.substr(0, 60);
  }
}

TEST(ReadExperiment, RefusesNumbersThatNobodyMeans) {
  const std::string rest = "[log]\nfiles = \"a.csv\"\n[method]\n";
  for (const auto& [keys, words] :
       {std::pair("robust = \"huber\"\nrobust_tolerance = 1e-300\n",
                  "robust_tolerance is 1e-300, must be at least 1e-09"),
        std::pair("max_iterations = 2147483647\n", "max_iterations is 2147483647, must be at most 1000"),
        std::pair("covariance_lag = 1e300\n", "covariance_lag is 1e+300 s, must be at most 1000000"),
        std::pair("robust = \"huber\"\nrobust_tuning = 1e300\n",
                  "robust_tuning is 1e+300, must be at most 1000000"),
        std::pair("[robot.joints.joint_1]\nFv = 1e300\n",
                  "Fv is 1e+300 N·m·s/rad or N·s/m, must lie between -1e+15 and 1e+15")}) {
    const std::string text = rest + keys;
    EXPECT_NE(refusal(text).find(words), std::string::npos) << refusal(text);
  }
}

TEST(ReadExperiment, RefusesAFileThatIsNoExperimentBySize) {
  const std::string said = refusal("# " + std::string(17U << 20U, 'x'));
  EXPECT_NE(said.find("experiment.toml: has 17 MiB, must have at most 16: it is no file of this kind"),
            std::string::npos)
      << said.substr(0, 200);
}

TEST(ReadExperiment, TellsAMistypedSectionWithTheOneThatIsMeant) {
  EXPECT_NE(refusal("[log]\nfiles = \"a.csv\"\n[singal]\ncutoff_hz = 20\n")
                .find(R"(:4:2: unknown key "singal"; did you mean "signal"?)"),
            std::string::npos);
  EXPECT_EQ(refusal("[log]\nfiles = \"a.csv\"\n"), "") << "rows are chosen by the log";
}

TEST(ReadExperiment, RefusesTheUnitOfAQuantityWhoseColumnsAreNotListed) {
  const std::string signal = "[signal]\ncutoff_hz = 20\n";
  const std::string log = "[log]\nfiles = \"a.csv\"\nunits = { position = \"deg\" }\n";
  EXPECT_NE(refusal(log + signal)
                .find(R"([log] units names "position", whose columns are not listed beside it; list them)"),
            std::string::npos);
  EXPECT_EQ(refusal(log + "position = [\"q1\", \"q2\"]\n" + signal), "");
  EXPECT_NE(
      refusal("[log]\nfiles = \"a.csv\"\n[log.reference_file]\nfile = \"r.csv\"\nunits.time = \"ms\"\n" +
              signal)
          .find(R"([log.reference_file] units names "time")"),
      std::string::npos);
}

TEST(ReadExperiment, TakesTheLossOfRobustEstimation) {
  const std::string rest = "[log]\nfiles = \"a.csv\"\n[signal]\ncutoff_hz = 20\n[method]\n";
  const auto robust = [&](const std::string& keys) { return read(rest + keys).estimation.robust; };
  EXPECT_FALSE(robust(""));
  EXPECT_FALSE(robust("robust = \"off\"\n"));
  EXPECT_EQ(robust("robust = \"huber\"\n").value().loss().tuning, 1.345);
  EXPECT_EQ(robust("robust = \"bisquare\"\n").value().loss().tuning, 4.685);
  EXPECT_EQ(robust("robust = \"bisquare\"\nrobust_tuning = 6\n").value().loss().tuning, 6.0);
  for (const auto& [keys, words] :
       {std::pair("robust = \"hubert\"\n", "robust is \"hubert\", must be one of"),
        std::pair("robust = \"huber\"\nrobust_tuning = 0\n", "robust_tuning must be positive"),
        std::pair("robust_tuning = 2\n", "robust_tuning needs robust = ")}) {
    EXPECT_NE(refusal(rest + keys).find(words), std::string::npos) << refusal(rest + keys);
  }
}

TEST(ReadExperiment, TakesAnotherMethodWithWhatTheFileSaysOfIt) {
  Experiment out = read("[log]\nfiles = \"a.csv\"\n[signal]\ncutoff_hz = 20\n[method]\nmax_iterations = 7\n");
  EXPECT_EQ(name(out.estimation.method), "auto");
  out.take_method("iv");
  EXPECT_EQ(std::get<Iv>(out.estimation.method).max_iterations, 7);
  out.take_method("wls");
  EXPECT_EQ(name(out.estimation.method), "wls");
  EXPECT_THROW(out.take_method("olss"), InputError);
}

TEST(ReadExperiment, TakesPrefilterAndEssentialAsSwitchesOrWithTheirOptions) {
  const std::string rest = "[log]\nfiles = \"a.csv\"\n[signal]\ncutoff_hz = 20\n[method]\n";
  const auto method = [&](const std::string& keys) { return read(rest + keys); };
  EXPECT_FALSE(method("").iv.prefilter);
  EXPECT_TRUE(method("prefilter = true\n").iv.prefilter);
  EXPECT_EQ(method("prefilter = true\n").iv.prefilter_order, 0);
  EXPECT_EQ(method("prefilter = 12\n").iv.prefilter_order, 12);
  EXPECT_FALSE(method("essential = false\n").estimation.essential);
  EXPECT_EQ(method("essential = true\n").estimation.essential.value().significance, 0.05);
  EXPECT_EQ(method("essential = { significance = 0.01 }\n").estimation.essential.value().significance, 0.01);
  EXPECT_NE(refusal(rest + "prefilter = 31\n")
                .find("prefilter is 31, must be true, false or an order from 1 to 30"),
            std::string::npos)
      << refusal(rest + "prefilter = 31\n");
  EXPECT_NE(refusal(rest + "essential = { significance = 2 }\n")
                .find("significance is 2, must lie between 0 and 1"),
            std::string::npos);
}

TEST(ReadExperiment, TakesAWordForEachSideOfASwitch) {
  const std::string rest = "[log]\nfiles = \"a.csv\"\n[signal]\ncutoff_hz = 20\n[method]\n";
  EXPECT_TRUE(read(rest + "initial_state = \"reference\"\n").iv.start_on_reference);
  EXPECT_FALSE(read(rest + "initial_state = \"measured\"\n").iv.start_on_reference);
  EXPECT_NE(refusal(rest + "initial_state = true\n").find("initial_state must be a string"),
            std::string::npos);
}

class Settings : public testing::Test {
 protected:
  [[nodiscard]] Experiment read(const std::vector<std::string>& settings) const {
    return read_experiment(file_.path(), Use::identification, settings);
  }
  [[nodiscard]] std::string refusal(const std::string& setting) const {
    return test::complaint_of([&] { return read({setting}); });
  }
  // What settings() says of a key.
  static Setting setting(const Experiment& experiment, const std::string& key) {
    const std::vector<Setting> all = settings(experiment);
    const auto at = std::ranges::find(all, key, &Setting::key);
    return at == all.end() ? Setting{} : *at;
  }

  test::TemporaryFile file_{robot + "[log]\nfiles = \"a.csv\"\n[signal]\ncutoff_hz = 20\ndecimation = 4\n",
                            "experiment.toml"};
};

TEST_F(Settings, AreLaidOverTheFile) {
  const Experiment read = this->read({"signal.decimation=[10, 2]", "signal.cutoff_hz=off",
                                      "method.covariance=classical", "method.physical.weight=3"});
  EXPECT_EQ(read.estimation.signal.decimation, (std::vector<int>{10, 2}));
  EXPECT_EQ(read.estimation.signal.cutoff_hz, 0.0);
  EXPECT_EQ(read.estimation.covariance.kind, CovarianceKind::classical);
  EXPECT_EQ(read.estimation.physical.value().weight, 3.0);
}

TEST_F(Settings, AreCheckedLikeTheFileAndNamedInMessages) {
  for (const auto& [setting, words] :
       {std::pair("signal.order=0", "--set signal.order=0: [signal] order is 0, must lie between 1 and 20"),
        std::pair("signal.ordr=4",
                  "--set signal.ordr=4: unknown key \"ordr\" in [signal]; did you mean \"order\"?"),
        std::pair("method.name=lms", "--set method.name=lms: [method] name is \"lms\", must be one of"),
        std::pair("methd.name=ols", "--set methd.name=ols: unknown key \"methd\"; did you mean \"method\"?"),
        std::pair("signal.order", "--set signal.order: is no setting; a key and its value are required"),
        std::pair("signal.order=[1", "--set signal.order=[1: ")}) {
    EXPECT_EQ(refusal(setting).find(words), 0U) << refusal(setting);
  }
}

TEST_F(Settings, TellWhereTheyComeFrom) {
  const Experiment experiment = read({"signal.order=6"});
  EXPECT_EQ(setting(experiment, "signal.order").origin, "--set");
  EXPECT_EQ(setting(experiment, "signal.order").value, "6");
  EXPECT_EQ(setting(experiment, "signal.torque_order").value, "6")
      << "that of order, where nothing else is said";
  EXPECT_EQ(setting(experiment, "signal.decimation").origin, "file");
  EXPECT_EQ(setting(experiment, "signal.convention").origin, "default");
  EXPECT_EQ(setting(experiment, "signal.cutoff_hz").unit, "Hz");
  EXPECT_EQ(setting(experiment, "signal.window").words, "whole log");
  EXPECT_EQ(setting(experiment, "method.physical").value, "false");
  EXPECT_EQ(setting(experiment, "method.start").key, "") << "is no setting of ordinary least squares";
}

}  // namespace
}  // namespace rivid
