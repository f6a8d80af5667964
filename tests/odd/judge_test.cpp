// identify(): faults that are planted in the logs of random arms are named with their size, and nothing is
// where there is none.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "odd/run.hpp"
#include "odd/user_folder.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/check.hpp"
#include "support/temporary_folder.hpp"

namespace rivid::odd {
namespace {

// Another seed than that of the pages.
constexpr std::uint64_t seed = 1616;

// A robot as a user would describe it, and a log of it.
struct Case {
  Robot robot;
  Log log;
};

// The first experiments of the kind whose arms have at least so many joints.
std::vector<Case> cases(const char* kind, std::size_t wanted, Index joints) {
  std::vector<Case> out;
  for (std::uint64_t number = 0; out.size() < wanted; ++number) {
    const test::TemporaryFolder folder;
    static_cast<void>(write_experiment({seed, kinds_of(kind).front(), number}, folder.path()));
    const std::vector<std::filesystem::path> logs = {folder.path() / "log_1.csv"};
    folder.write(
        "experiment.toml",
        draft_experiment(folder.path() / "experiment.toml", folder.path() / "robot.urdf", {}, logs).text);
    Experiment experiment = read_experiment(folder.path() / "experiment.toml");
    Reading reading;
    take_friction(experiment, reading);
    if (experiment.robot.size() >= joints) {
      out.push_back({experiment.robot, read_logs(experiment.log, experiment.robot).front()});
    }
  }
  return out;
}

// The alternative of that code and subject, if it is the likeliest or its rival.
const ModelTest* told(const Identification& result, std::string_view code, std::string_view subject) {
  const auto at = std::ranges::find_if(
      result.alternatives, [&](const ModelTest& t) { return t.code == code && t.subject == subject; });
  return at == result.alternatives.end() ? nullptr : &*at;
}

// Names of planted faults are told with estimates within 4 standard deviations, or a tenth, of their sizes.
void expect_named(const std::function<void(Case&)>& plant, std::string_view code,
                  const std::function<std::string(const Robot&)>& subject, double size, std::size_t least) {
  constexpr std::size_t tried = 8;
  std::size_t named = 0;
  for (Case one : cases("good", tried, 4)) {
    plant(one);
    const Identification result = identify(one.robot, one.log, {});
    const ModelTest* const found = told(result, code, subject(one.robot));
    if (found != nullptr) {
      ++named;
      EXPECT_NEAR(found->estimate.norm(), std::abs(size),
                  std::max(4.0 * found->sigma[0], 0.1 * std::abs(size)))
          << one.robot.name;
      if (found->estimate.size() == 1) {
        EXPECT_GT(found->estimate[0] * size, 0.0);
      }
      EXPECT_FALSE(result.warnings.empty());
    }
  }
  EXPECT_GE(named, least) << code;
}

std::string second(const Robot& robot) { return robot.joints.at(1).name; }
std::string everywhere(const Robot& /*robot*/) { return "all joints"; }
std::string base_of_arm(const Robot& robot) { return robot.base; }

TEST(Judge, SaysNothingOfGoodLogs) {
  constexpr std::size_t tried = 30;
  std::size_t warned = 0;
  for (const Case& one : cases("good", tried, 2)) {
    const Identification result = identify(one.robot, one.log, {});
    EXPECT_EQ(result.status, Status::identified);
    warned += result.alternatives.empty() ? 0U : 1U;
  }
  EXPECT_LE(warned, 1U);
}

TEST(Judge, RefusesTheLogsOfAnotherRobot) {
  const std::vector<Case> two = {cases("good", 1, 2).front(), cases("good", 1, 7).front()};
  ASSERT_NE(two[0].robot.size(), two[1].robot.size());
  const std::span log(&two[0].log, 1);
  const std::span other(&two[1].log, 1);
  EXPECT_THROW(static_cast<void>(identify(two[0].robot, other, {})), InputError);
  EXPECT_THROW(static_cast<void>(identify(two[0].robot, log, {}, other)), InputError);
}

TEST(Judge, NamesTheGainOfATorque) {
  expect_named([](Case& one) { one.log.tau.col(1) *= 1.1; }, "torque_gain", second, 0.1, 6);
}

// The last joint of an arm without a priori inertias has no more inertia than those that carry it.
TEST(Judge, NamesTheUnitOfASingleTorque) {
  std::size_t named = 0;
  for (Case one : cases("good", 8, 4)) {
    one.log.tau.rightCols(1) *= 1000.0;
    const std::string last = one.robot.joints.back().name;
    const Identification result = identify(one.robot, one.log, {});
    named += std::ranges::any_of(result.warnings, [&](const Finding& f) {
      return f.code == "torque_unit" && (f.subject == last || f.subject == "all joints");
    });
  }
  EXPECT_GE(named, 6U);
}

TEST(Judge, NamesTheZeroOfAJoint) {
  // Positions are told 0.06 too large: so much has to be taken off.
  expect_named([](Case& one) { one.log.q.col(1).array() += 0.06; }, "zero_offset", second, -0.06, 4);
}

TEST(Judge, NamesTheTiltOfTheBase) {
  constexpr double tilt = 0.06;
  expect_named(
      [](Case& one) {
        one.robot.chain.gravity = Eigen::Vector3d(std::sin(tilt) * 9.80665, 0.0, -std::cos(tilt) * 9.80665);
      },
      "gravity_tilt", base_of_arm, tilt, 4);
}

TEST(Judge, NamesTheRateOfTheClock) {
  // Time stamps that run by 3 % too fast: velocities are 3 % larger.
  expect_named(
      [](Case& one) {
        one.log.t *= 1.03;
        one.log.f_m /= 1.03;
      },
      "clock_rate", everywhere, 0.03, 3);
}

TEST(Judge, NamesASpring) {
  // Of 12 N·m/rad, whose rest is not the joint's zero.
  static constexpr double stiffness = 12.0;
  expect_named([](Case& one) { one.log.tau.col(1) += stiffness * (one.log.q.col(1).array() - 0.4).matrix(); },
               "joint_spring", second, stiffness, 5);
}

// Links swing at 12 to 60 Hz on the springs that are drawn.
TEST(Judge, TellsTheFrequencyOfElasticJoints) {
  constexpr std::size_t tried = 16;
  std::size_t named = 0;
  for (const Case& one : cases("elastic", tried, 3)) {
    const Identification result = identify(one.robot, one.log, {});
    for (const Finding& finding : result.warnings) {
      const std::string words = "would swing at ";
      const auto at = finding.text.find(words);
      if (finding.code == "joint_elasticity" && at != std::string::npos) {
        ++named;
        const double hz = std::stod(finding.text.substr(at + words.size()));
        EXPECT_GT(hz, 8.0) << finding.text;
        EXPECT_LT(hz, 80.0) << finding.text;
      }
    }
  }
  EXPECT_GE(named, 4U);
}

// What is wrong but not refused widens the intervals by what it does.
TEST(Judge, WidensIntervalsByTheShiftOfTheLikeliestAlternative) {
  std::size_t widened = 0;
  for (Case one : cases("good", 6, 4)) {
    const Estimation unjudged{.judge = false};
    const Identification clean = identify(one.robot, one.log, unjudged);
    one.log.tau.col(1) *= 1.05;
    const Identification before = identify(one.robot, one.log, unjudged);
    const Identification result = identify(one.robot, one.log, {});
    if (result.alternatives.empty()) {
      continue;
    }
    ++widened;
    double from_clean = 0.0;
    double shifted_from_clean = 0.0;
    for (std::size_t i = 0; i < result.parameters.size(); ++i) {
      const ParameterEstimate& p = result.parameters[i];
      EXPECT_NEAR(p.sigma, std::hypot(before.parameters[i].sigma, p.model_shift), 1e-12 * p.sigma);
      const double off = (p.value - clean.parameters[i].value) / before.parameters[i].sigma;
      from_clean += off * off;
      shifted_from_clean += std::pow(off + p.model_shift / before.parameters[i].sigma, 2);
    }
    // The shift leads back to what the log says without the fault.
    EXPECT_LT(shifted_from_clean, 0.25 * from_clean) << one.robot.name;
    EXPECT_TRUE(result.chi == before.chi);
  }
  EXPECT_GE(widened, 4U);
}

}  // namespace
}  // namespace rivid::odd
