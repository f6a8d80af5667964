// Hints of findings, taken: what took no part in the fit is explained better, and the text that is written is
// the experiment that was tried.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>

#include "odd/run.hpp"
#include "odd/user_folder.hpp"
#include "rivid/data/csv.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/hint.hpp"
#include "rivid/report/text.hpp"
#include "support/temporary_folder.hpp"

namespace rivid::odd {
namespace {

constexpr std::uint64_t seed = 3737;

struct Fault {
  const char* code;
  std::function<void(Log&)> plant;
};

std::vector<Fault> faults() {
  static constexpr double degree = std::numbers::pi / 180.0;
  return {{"torque_sign", [](Log& log) { log.tau.col(1) *= -1.0; }},
          {"position_sign",
           [](Log& log) {
             log.q.col(1) *= -1.0;
             log.tau.col(1) *= -1.0;
           }},
          {"torque_order", [](Log& log) { log.tau.col(0).swap(log.tau.col(1)); }},
          {"position_unit", [](Log& log) { log.q /= degree; }},
          {"torque_unit", [](Log& log) { log.tau.col(1) *= 1000.0; }},
          {"zero_offset", [](Log& log) { log.q.col(1).array() += 90.0 * degree; }},
          {"zero_offset", [](Log& log) { log.q.col(1).array() += 0.1; }},
          {"torque_gain", [](Log& log) { log.tau.col(1) *= 1.4; }},
          {"clock_rate",
           [](Log& log) {
             log.t *= 1.08;
             log.f_m /= 1.08;
           }},
          {"torque_delay", [](Log& log) {
             const Matrix before = log.tau;
             for (Index k = 0; k < before.rows(); ++k) {
               log.tau.row(k) = before.row(std::max<Index>(k - 12, 0));
             }
           }}};
}

// An arm of three joints that turn and more, and its two logs.
class Faulted {
 public:
  explicit Faulted(std::uint64_t number) {
    for (bool good = false; !good; ++number) {
      static_cast<void>(write_experiment({seed, kinds_of("good").front(), number}, folder_.path()));
      plant({"", [](Log& log) { log.q_r.resize(0, 0); }});  // a fault would have to change it too
      const std::vector logs = {folder_.path() / "log_1.csv", folder_.path() / "log_2.csv"};
      folder_.write("experiment.toml",
                    draft_experiment(file(), folder_.path() / "robot.urdf", {}, logs).text);
      const Robot robot = read_experiment(file()).robot;
      good = robot.size() >= 3 &&
             std::ranges::all_of(robot.joints, [](const Joint& j) { return j.type == JointType::revolute; });
    }
  }

  void plant(const Fault& fault) const {
    for (const char* const name : {"log_1.csv", "log_2.csv"}) {
      Log log = read_csv(folder_.path() / name);
      fault.plant(log);
      folder_.write(name, to_csv(log));
    }
  }

  [[nodiscard]] std::filesystem::path file() const { return folder_.path() / "experiment.toml"; }
  void write(const std::string& text) const { folder_.write("experiment.toml", text); }

 private:
  test::TemporaryFolder folder_;
};

// As the tool does.
Identification identified(const Faulted& faulted) {
  Experiment experiment = read_experiment(faulted.file());
  Reading reading;
  take_friction(experiment, reading);
  return run(experiment, reading);
}

TEST(Hints, OfTenFaultsExplainWhatTookNoPart) {
  const std::vector<Fault> all = faults();
  std::size_t named = 0;
  std::size_t worse = 0;
  for (std::size_t f = 0; f < all.size(); ++f) {
    const Faulted faulted(10 * f);
    faulted.plant(all[f]);
    const Identification result = identified(faulted);
    for (const Finding& finding : result.warnings) {
      if (finding.changes.empty()) {
        continue;
      }
      const HintTrial trial = try_hint(faulted.file(), finding.code, finding.subject);
      std::cout << all[f].code << ": " << in_words(trial) << '\n';
      const bool its = finding.code == all[f].code;
      named += its && trial.helps() ? 1U : 0U;
      worse += severity(finding) == Severity::error && !trial.helps() ? 1U : 0U;
      if (its) {
        faulted.write(trial.text);
        const Identification then = identified(faulted);
        EXPECT_DOUBLE_EQ(then.answer_fit().relative_error, trial.after.fit) << trial.text;
        break;
      }
    }
  }
  // Torques of one joint in N·mm have no hint with a key. An offset of 0.1 rad, found as 0.101, hardly moves
  // the torques of another motion like that of the fit: 0.36 % of them before, 0.39 % after.
  EXPECT_GE(named, 8U);
  EXPECT_LE(worse, 1U);
}

TEST(Hints, OfASoundExperimentAreNone) {
  const Faulted sound(1);
  try {
    static_cast<void>(try_hint(sound.file(), "torque_gain"));
    ADD_FAILURE() << "no finding was asked for";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("has no finding \"torque_gain\""), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace rivid::odd
