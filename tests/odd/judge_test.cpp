// identify(): faults that are planted in the logs of random arms are named with their size, and nothing is
// where there is none.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "odd/run.hpp"
#include "odd/user_folder.hpp"
#include "rivid/data/log.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/draft.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/identify/check.hpp"
#include "rivid/model/parameters.hpp"
#include "rivid/regressor/batch.hpp"
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
    const Experiment experiment = read_experiment(folder.path() / "experiment.toml");
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

// Joints that move one after the other: of each the rows are few and all at one time.
TEST(Judge, NamesTheGainOfAJointThatMovesAlone) {
  std::size_t named = 0;
  for (Case one : cases("jog", 8, 4)) {
    one.log.tau.col(1) *= 1.5;
    const Identification result = identify(one.robot, one.log, {});
    const ModelTest* const found = told(result, "torque_gain", second(one.robot));
    const auto not_tested = [&](const std::string& note) { return note.starts_with("not tested: "); };
    named += (found != nullptr && std::abs(found->estimate[0] - 0.5) < 0.15) ||
                     result.status != Status::identified || std::ranges::any_of(result.notes, not_tested)
                 ? 1U
                 : 0U;
  }
  EXPECT_GE(named, 7U);
}

// A pause of two and a half times the motion takes no test away.
TEST(Judge, NamesAGainBesideAPause) {
  std::size_t named = 0;
  for (Case one : cases("good", 8, 4)) {
    one.log.tau.col(1) *= 1.3;
    const Index moving = one.log.samples();
    const Index all = moving + 5 * moving / 2;
    for (Matrix Log::* const part : {&Log::q, &Log::tau, &Log::q_r}) {
      Matrix& x = one.log.*part;
      if (x.size() > 0) {
        x.conservativeResize(all, Eigen::NoChange);
        x.bottomRows(all - moving).rowwise() = x.row(moving - 1).eval();
      }
    }
    one.log.t = Vector::LinSpaced(all, 0.0, static_cast<double>(all - 1) / one.log.f_m);
    named += told(identify(one.robot, one.log, {}), "torque_gain", second(one.robot)) != nullptr ? 1U : 0U;
  }
  EXPECT_GE(named, 6U);
}

TEST(Judge, SaysWhichJointIsNotTested) {
  Case one = cases("good", 1, 4).front();
  // The last joint moves for a moment: few of the instants are its own.
  const Index brief = one.log.samples() / 100;
  const double rests = one.log.q(brief, one.log.q.cols() - 1);
  one.log.q.col(one.log.q.cols() - 1).tail(one.log.samples() - brief).setConstant(rests);
  const Identification result = identify(one.robot, one.log, {});
  EXPECT_TRUE(std::ranges::any_of(result.notes, [&](const std::string& note) {
    return note.find("not tested: " + one.robot.joints.back().name) != std::string::npos &&
           note.find("because it moves at ") != std::string::npos;
  }));
}

// What stands in the place of the masses makes no right log doubtful.
TEST(Judge, BelievesNoDescriptionThatIsNone) {
  const std::vector<std::function<void(std::vector<Inertial>&)>> descriptions = {
      [](std::vector<Inertial>&) {},
      [](std::vector<Inertial>& links) {
        for (std::size_t j = 0; j < links.size(); ++j) {
          links[j] *= j % 2 == 0 ? 3.0 : 1.0 / 3.0;
        }
      },
      [](std::vector<Inertial>& links) {
        for (Inertial& i : links) {
          i = inertial_from_com(1.0, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity());
        }
      },
      [](std::vector<Inertial>& links) {
        for (Inertial& i : links) {
          i = inertial_from_com(0.001, Eigen::Vector3d::Zero(), 1e-6 * Eigen::Matrix3d::Identity());
        }
      },
      [](std::vector<Inertial>& links) { std::ranges::fill(links, Inertial::Zero()); },
      [](std::vector<Inertial>& links) {
        for (std::size_t j = 0; j < links.size(); ++j) {
          links[j] = inertial_from_com(0.001 * static_cast<double>(j + 1), Eigen::Vector3d(0.01, 0.0, 0.0),
                                       1e-6 * Eigen::Matrix3d::Identity());
        }
      },
      [](std::vector<Inertial>& links) { std::ranges::fill(links, Inertial(links.front())); },
      [](std::vector<Inertial>& links) {
        // Inertias in g·mm², say.
        for (Inertial& i : links) {
          i.head<6>() *= 1e9;
        }
      }};
  constexpr std::size_t tried = 40;
  std::vector<std::size_t> doubtful(descriptions.size(), 0);
  for (const Case& one : cases("good", tried, 2)) {
    for (std::size_t d = 0; d < descriptions.size(); ++d) {
      Robot robot = one.robot;
      descriptions[d](robot.inertials);
      const Identification result = identify(robot, one.log, {});
      doubtful[d] += result.status == Status::doubtful ? 1U : 0U;
    }
  }
  EXPECT_LE(doubtful[0], 1U);
  for (std::size_t d = 1; d < descriptions.size(); ++d) {
    EXPECT_LE(doubtful[d], doubtful[0]) << "description " << d;
  }
}

TEST(Judge, NamesTheLogOfAnotherTool) {
  std::size_t named = 0;
  std::size_t accused = 0;
  constexpr std::size_t tried = 8;
  for (std::uint64_t number = 0; number < tried; ++number) {
    // The second log of this kind is without the load that the first one has from some time on.
    const test::TemporaryFolder folder;
    static_cast<void>(write_experiment({seed, kinds_of("payload_mid").front(), number}, folder.path()));
    const std::vector<std::filesystem::path> logs = {folder.path() / "log_1.csv",
                                                     folder.path() / "log_2.csv"};
    folder.write(
        "experiment.toml",
        draft_experiment(folder.path() / "experiment.toml", folder.path() / "robot.urdf", {}, logs).text);
    Experiment experiment = read_experiment(folder.path() / "experiment.toml");
    experiment.log.files = logs;
    std::vector<Log> both = read_logs(experiment.log, experiment.robot);
    const auto says = [](const Identification& result) {
      return std::ranges::any_of(result.warnings, [](const Finding& f) {
        return f.code == "logs_differ" || f.code == "load_changed";
      });
    };
    const Index half = both[0].samples() / 2;
    // Its end alone, with the load, beside the other one.
    both[0] = excerpt(both[0], both[0].samples() - half / 2, half / 2);
    named += says(identify(experiment.robot, both, {})) ? 1U : 0U;
    // Two stretches of one log belong together.
    const std::vector<Log> one = {excerpt(both[1], 0, both[1].samples() / 2),
                                  excerpt(both[1], both[1].samples() / 2, both[1].samples() / 2)};
    accused += says(identify(experiment.robot, one, {})) ? 1U : 0U;
  }
  EXPECT_GE(named, 6U);
  EXPECT_EQ(accused, 0U);
}

TEST(Judge, NamesTorquesWithoutGravity) {
  std::size_t named = 0;
  for (Case one : cases("good", 8, 4)) {
    const Identification whole = identify(one.robot, one.log, {.judge = false});
    const Matrix none = Matrix::Zero(one.log.samples(), one.robot.size());
    const Observation W = observation(one.robot, whole.base, {one.log.q, none, none});
    for (std::size_t j = 0; j < W.joints.size(); ++j) {
      Vector held = Vector::Zero(one.log.samples());
      for (std::size_t c = 0; c < W.joints[j].columns.size(); ++c) {
        const auto i = static_cast<std::size_t>(W.joints[j].columns[c]);
        if (role(whole.base.parameters[i].leading.kind) == Role::inertial) {
          held += W.joints[j].W.col(static_cast<Index>(c)) * whole.chi[W.joints[j].columns[c]];
        }
      }
      one.log.tau.col(static_cast<Index>(j)) -= held;
    }
    const Identification result = identify(one.robot, one.log, {});
    named += std::ranges::any_of(result.warnings,
                                 [](const Finding& f) { return f.code == "torque_without_gravity"; });
    one.robot.chain.gravity.setZero();
    EXPECT_EQ(identify(one.robot, one.log, {}).status, Status::identified);
  }
  EXPECT_GE(named, 6U);
}

TEST(Judge, NamesARegisterThatGoesOverItsEnd) {
  for (Case one : cases("good", 3, 2)) {
    const auto named = [&] {
      const Identification result = identify(one.robot, one.log, {});
      return std::ranges::any_of(result.warnings,
                                 [](const Finding& f) { return f.code == "register_wraps"; });
    };
    EXPECT_FALSE(named());
    // Hundredths of a per mille of the largest torque in a signed number that is read as unsigned.
    const double step = one.log.tau.col(0).cwiseAbs().maxCoeff() / 30000.0;
    for (double& tau : one.log.tau.col(0)) {
      const double counts = std::round(tau / step);
      tau = step * (counts < 0.0 ? counts + 65536.0 : counts);
    }
    EXPECT_TRUE(named());
  }
}

}  // namespace
}  // namespace rivid::odd
