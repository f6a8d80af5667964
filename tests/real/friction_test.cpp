// Friction laws by cross-validation, on logs of real robots that took no part in the choice.

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include "rivid/identify/friction_choice.hpp"
#include "support/real_experiment.hpp"

namespace rivid {
namespace {

template <const char* Name>
class Robots : public test::RealExperiment {
 protected:
  Robots() : RealExperiment(Name) {}

  // Error on logs other than that of the fit, as the mean square over all pairs, with one law for all joints.
  [[nodiscard]] double unseen(Friction law) const {
    const Experiment e = experiment();
    std::vector<Log> logs = read_logs(e.log, e.robot);
    for (const Log& log : read_logs(e.validation, e.robot)) {
      if (std::ranges::none_of(logs, [&](const Log& other) { return other.source == log.source; })) {
        logs.push_back(log);
      }
    }
    double sum = 0.0;
    int pairs = 0;
    for (const Log& of_fit : logs) {
      Robot robot = e.robot;
      for (Joint& joint : robot.joints) {
        joint.friction = law;
      }
      Estimation estimation = e.estimation;
      estimation.method = Wls{};
      robot = with_friction(robot, choose_friction(robot, std::span(&of_fit, 1), estimation).kinds);
      const Identification found = identify(robot, of_fit, estimation);
      EXPECT_EQ(found.status, Status::identified) << name(law) << ' ' << of_fit.source;
      for (const Log& other : logs) {
        if (other.source != of_fit.source) {
          sum += std::pow(validate(robot, found, other).fit.relative_error, 2);
          ++pairs;
        }
      }
    }
    const double out = std::sqrt(sum / pairs);
    std::cout << "[ UNSEEN   ] " << Name << ", " << name(law) << ": " << 100.0 * out << " % of " << pairs
              << " pairs\n";
    return out;
  }
};

inline constexpr char ur10e[] = "ur10e";
inline constexpr char kuka[] = "kuka_kr300";

using Ur10e = Robots<ur10e>;
using Kuka = Robots<kuka>;

TEST_F(Ur10e, IsPredictedBetterByFrictionThatFollowsTheLoad) {
  const double symmetric = unseen(Friction::symmetric);
  EXPECT_LT(unseen(Friction::load), 0.8 * symmetric);
  EXPECT_LT(unseen(Friction::load_root), 0.7 * symmetric);
  EXPECT_LT(unseen(Friction::automatic), 0.72 * symmetric);
}

TEST_F(Kuka, IsPredictedNoWorseByTheLawsThatAreChosen) {
  EXPECT_LE(unseen(Friction::automatic), unseen(Friction::symmetric));
}

}  // namespace
}  // namespace rivid
