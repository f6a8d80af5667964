// What is open of the geometry, and between logs, in the intervals.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "support/payload_bench.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

using test::PayloadBench;

int held(const Identification& found, const Vector& truth) {
  int out = 0;
  for (std::size_t i = 0; i < found.parameters.size(); ++i) {
    const auto [low, high] = found.parameters[i].interval_95;
    const double value = truth[static_cast<Index>(i)];
    out += low <= value && value <= high ? 1 : 0;
  }
  return out;
}

// Arms whose lengths and axes are off by what the tolerance says.
TEST(GeometryTolerance, IsInTheIntervals) {
  constexpr int runs = 30;
  const GeometryTolerance tolerance{.length = 2e-3, .angle = 4e-3};
  std::mt19937_64 random(61);
  std::normal_distribution<double> normal;
  int with = 0;
  int without = 0;
  int all = 0;
  for (int run = 0; run < runs; ++run) {
    const PayloadBench nominal(test::six_axis(), 1500);
    PayloadBench actual = nominal;
    for (Chain::Link& link : actual.robot.chain.links) {
      for (Index k = 0; k < 3; ++k) {
        link.p[k] += tolerance.length * normal(random);
        link.R =
            link.R *
            Eigen::AngleAxisd(tolerance.angle * normal(random), Eigen::Vector3d::Unit(k)).toRotationMatrix();
      }
    }
    const auto seed = static_cast<std::uint64_t>(run);
    const Log log = actual.log(Inertial::Zero(), 0.02, 900 + seed, 1 + seed % 4);
    // Its parameters as the description regroups them.
    const BaseParameters base = base_parameters(nominal.robot);
    const Vector truth = base.from_standard(actual.robot.chi_st());
    Robot robot = nominal.robot;
    const Estimation estimation{.method = Wls{}, .signal = PayloadBench::signal(), .judge = false};
    without += held(identify(robot, log, estimation), truth);
    robot.tolerance = tolerance;
    with += held(identify(robot, log, estimation), truth);
    all += static_cast<int>(truth.size());
  }
  EXPECT_LT(without, 0.8 * all);
  EXPECT_GE(with, 0.9 * all) << with << " of " << all << ", without tolerance " << without;
}

// Friction that differs from day to day: three logs and more tell it.
TEST(LogsOfSeveralDays, ScatterIsInTheIntervals) {
  constexpr int runs = 12;
  std::mt19937_64 random(62);
  std::normal_distribution<double> normal;
  int several = 0;
  int all = 0;
  for (int run = 0; run < runs; ++run) {
    std::vector<Log> logs;
    const PayloadBench mean(test::six_axis(), 1200);
    for (std::uint64_t day = 1; day <= 5; ++day) {
      PayloadBench bench = mean;
      for (Joint& joint : bench.robot.joints) {
        joint.Fv += 0.2 * normal(random);
        joint.Fc += 0.3 * normal(random);
      }
      logs.push_back(bench.log(Inertial::Zero(), 0.1, 100 * static_cast<std::uint64_t>(run) + day, day));
    }
    const Identification found =
        identify(mean.robot, logs, {.method = Wls{}, .signal = PayloadBench::signal(), .judge = false});
    const Vector truth = base_parameters(mean.robot).from_standard(mean.robot.chi_st());
    for (std::size_t i = 0; i < found.parameters.size(); ++i) {
      const ParameterKind kind = found.base.parameters[i].leading.kind;
      if (kind == ParameterKind::Fv || kind == ParameterKind::Fc) {
        const auto [low, high] = found.parameters[i].interval_95;
        const double value = truth[static_cast<Index>(i)];
        several += low <= value && value <= high ? 1 : 0;
        ++all;
      }
    }
  }
  EXPECT_GE(several, 0.88 * all) << several << " of " << all;
}

}  // namespace
}  // namespace rivid
