// Hints of findings: applied, they explain what took no part better, and the lines that are printed do what was
// tried.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>

#include "odd/run.hpp"
#include "odd/user_folder.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/hint.hpp"
#include "support/temporary_folder.hpp"

namespace rivid::odd {
namespace {

constexpr std::uint64_t seed = 3737;

struct Fault {
  const char* code;
  std::function<void(Log&)> plant;
};

std::vector<Fault> faults() {
  return {{"torque_sign", [](Log& log) { log.tau.col(1) *= -1.0; }},
          {"position_sign",
           [](Log& log) {
             log.q.col(1) *= -1.0;
             log.tau.col(1) *= -1.0;
           }},
          {"torque_order", [](Log& log) { log.tau.col(0).swap(log.tau.col(1)); }},
          {"position_unit", [](Log& log) { log.q *= 180.0 / M_PI; }},
          {"torque_unit", [](Log& log) { log.tau.col(1) *= 1000.0; }},
          {"zero_offset", [](Log& log) { log.q.col(1).array() += 0.5 * M_PI; }},
          {"zero_offset", [](Log& log) { log.q.col(1).array() += 0.1; }},
          {"torque_gain", [](Log& log) { log.tau.col(1) *= 1.4; }},
          {"clock_rate", [](Log& log) { log.t *= 1.08; }},
          {"torque_delay", [](Log& log) {
             const Matrix before = log.tau;
             for (Index k = 0; k < before.rows(); ++k) {
               log.tau.row(k) = before.row(std::max<Index>(k - 12, 0));
             }
           }}};
}

// "section.key=value" of each line under its section.
std::vector<std::string> settings_of(const std::vector<std::string>& lines) {
  std::vector<std::string> out;
  std::string section;
  for (const std::string& line : lines) {
    if (line.front() == '[') {
      section = line.substr(1, line.size() - 2);
    } else {
      const std::size_t equals = line.find(" = ");
      out.push_back(section + "." + line.substr(0, equals) + "=" + line.substr(equals + 3));
    }
  }
  return out;
}

TEST(Hints, OfTenFaultsHelpAndTheirLinesDoWhatWasTried) {
  std::size_t taken = 0;
  const std::vector<Fault> all = faults();
  for (std::size_t f = 0; f < all.size(); ++f) {
    const test::TemporaryFolder folder;
    std::uint64_t number = 10 * f;
    std::optional<Experiment> experiment;
    std::vector<std::filesystem::path> files;
    // An arm of three joints that turn and more.
    while (!experiment) {
      static_cast<void>(write_experiment({seed, kinds_of("good").front(), number++}, folder.path()));
      files = {folder.path() / "log_1.csv", folder.path() / "log_2.csv"};
      folder.write(
          "experiment.toml",
          draft_experiment(folder.path() / "experiment.toml", folder.path() / "robot.urdf", {}, files).text);
      Experiment drafted = read_experiment(folder.path() / "experiment.toml");
      const bool turns = std::ranges::all_of(
          drafted.robot.joints, [](const Joint& joint) { return joint.type == JointType::revolute; });
      if (drafted.robot.size() >= 3 && turns) {
        experiment = std::move(drafted);
      }
    }
    for (const std::filesystem::path& file : files) {
      Log log = read_csv(file);
      all[f].plant(log);
      folder.write(file.filename().string(), to_csv(log));
    }
    Reading reading;
    try {
      const HintTrial trial = try_hint(*experiment, all[f].code, "", reading);
      std::cout << in_words(trial) << '\n';
      if (!trial.helps()) {
        continue;
      }
      ++taken;
      EXPECT_LT(*trial.after.held_out, *trial.before.held_out) << all[f].code;
      const Experiment pasted =
          read_experiment(folder.path() / "experiment.toml", Use::identification, settings_of(trial.lines));
      EXPECT_NEAR(run(pasted).fit.relative_error, trial.after.fit, 0.02 * trial.after.fit) << all[f].code;
    } catch (const InputError& error) {
      std::cout << all[f].code << ": " << error.what() << '\n';
    }
  }
  EXPECT_GE(taken, 8U);
}

TEST(Hints, AreNoneOfAGoodLog) {
  const test::TemporaryFolder folder;
  static_cast<void>(write_experiment({seed, kinds_of("good").front(), 1}, folder.path()));
  const std::vector<std::filesystem::path> logs = {folder.path() / "log_1.csv"};
  folder.write(
      "experiment.toml",
      draft_experiment(folder.path() / "experiment.toml", folder.path() / "robot.urdf", {}, logs).text);
  Reading reading;
  const Experiment experiment = read_experiment(folder.path() / "experiment.toml");
  try {
    static_cast<void>(try_hint(experiment, "torque_gain", "", reading));
    ADD_FAILURE() << "no finding was asked for";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("has no finding"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace rivid::odd
