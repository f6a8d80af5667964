// What an experiment file says is heard or refused, never passed over.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "rivid/error.hpp"
#include "rivid/experiment/experiment.hpp"

namespace rivid {
namespace {

// What read_experiment() says about a file for the SCARA of data/scara; empty if it is read.
std::string refusal(const std::string& text) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) /
      (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".toml");
  std::ofstream(file) << "robot.urdf = \"" RIVID_DATA "/scara/scara.urdf\"\n" << text;
  std::string out;
  try {
    (void)read_experiment(file);
  } catch (const InputError& e) {
    out = e.what();
  }
  std::filesystem::remove(file);
  return out;
}

TEST(ReadExperiment, TakesTheSmoothingOfSignsForAllJointsOrForOne) {
  const std::string rest = "[log]\nfiles = \"a.csv\"\n[signal]\ncutoff_hz = 20\n";
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "sign_speed.toml";
  std::ofstream(file) << "robot.urdf = \"" RIVID_DATA "/scara/scara.urdf\"\nrobot.sign_speed = 0.01\n"
                      << "robot.joints.joint_2.sign_speed = 0.5\n"
                      << rest;
  const Experiment read = read_experiment(file);
  std::filesystem::remove(file);
  EXPECT_EQ(read.robot.joints.at(0).sign_speed, 0.01);
  EXPECT_EQ(read.robot.joints.at(1).sign_speed, 0.5);
  EXPECT_NE(
      refusal("robot.sign_speed = -1\n" + rest).find("sign_speed is -1, must be finite and not negative"),
      std::string::npos);
}

TEST(ReadExperiment, TellsAMistypedSectionWithTheOneThatIsMeant) {
  EXPECT_NE(refusal("[log]\nfiles = \"a.csv\"\n[singal]\ncutoff_hz = 20\n")
                .find(R"(:4:2: unknown key "singal"; did you mean "signal"?)"),
            std::string::npos);
  EXPECT_NE(refusal("[log]\nfiles = \"a.csv\"\n").find("section [signal] is missing"), std::string::npos);
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
  const auto robust = [&](const std::string& keys) {
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "robust_options.toml";
    std::ofstream(file) << "robot.urdf = \"" RIVID_DATA "/scara/scara.urdf\"\n" << rest << keys;
    const Experiment out = read_experiment(file);
    std::filesystem::remove(file);
    return out.estimation.robust;
  };
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
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "other_method.toml";
  std::ofstream(file) << "robot.urdf = \"" RIVID_DATA
                         "/scara/scara.urdf\"\n[log]\nfiles = \"a.csv\"\n"
                         "[signal]\ncutoff_hz = 20\n[method]\nmax_iterations = 7\n";
  Experiment out = read_experiment(file);
  std::filesystem::remove(file);
  EXPECT_EQ(name(out.estimation.method), "ols");
  out.take_method("iv");
  EXPECT_EQ(std::get<Iv>(out.estimation.method).max_iterations, 7);
  out.take_method("wls");
  EXPECT_EQ(name(out.estimation.method), "wls");
  EXPECT_THROW(out.take_method("olss"), InputError);
}

TEST(ReadExperiment, TakesPrefilterAndEssentialAsSwitchesOrWithTheirOptions) {
  const std::string rest = "[log]\nfiles = \"a.csv\"\n[signal]\ncutoff_hz = 20\n[method]\n";
  const auto method = [&](const std::string& keys) {
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "method_options.toml";
    std::ofstream(file) << "robot.urdf = \"" RIVID_DATA "/scara/scara.urdf\"\n" << rest << keys;
    Experiment out = read_experiment(file);
    std::filesystem::remove(file);
    return out;
  };
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

}  // namespace
}  // namespace rivid
