// What is open of the geometry, in the intervals.

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
  const GeometryTolerance tolerance{.length = 4e-3, .angle = 8e-3};
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
  EXPECT_LT(without, 0.85 * all);
  EXPECT_GE(with, 0.9 * all) << with << " of " << all << ", without tolerance " << without;
}

}  // namespace
}  // namespace rivid
