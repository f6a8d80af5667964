// Payloads on top of an arm that was identified before, and several payloads of one arm.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/payload.hpp"
#include "support/complaint.hpp"
#include "support/payload_bench.hpp"

namespace rivid {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

using test::Box;
using test::PayloadBench;
using test::six_axis;

// The arm of a bench by its log without load. Not judged: of gains that are wrong it would say so.
IdentifiedArm arm_of(const PayloadBench& bench, double sigma, std::uint64_t seed,
                     const Matrix& gain_covariance = {}) {
  Estimation estimation{.method = Wls{}, .signal = PayloadBench::signal(), .judge = false};
  estimation.gain_covariance = gain_covariance;
  return identified_arm(bench.robot,
                        identify(bench.robot, bench.log(Inertial::Zero(), sigma, seed, 1), estimation));
}

PayloadReport on_top_of(const IdentifiedArm& arm, const Log& with, const PayloadOptions& options,
                        std::optional<double> mass = {}) {
  const LoadedLogs loaded{.logs = std::span(&with, 1), .mass = mass};
  return identify_payloads(arm, std::span(&loaded, 1), {.signal = PayloadBench::signal()}, options);
}

std::array<double, 10> numbers_of(const Inertial& body) {
  const double m = body[9];
  const Eigen::Vector3d c = body.segment<3>(6) / m;
  Eigen::Matrix3d I;
  I << body[0], body[1], body[2], body[1], body[3], body[4], body[2], body[4], body[5];
  I -= m * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
  return {m, c[0], c[1], c[2], I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
}

void expect_numbers(const Payload& found, const Inertial& body) {
  const auto truth = numbers_of(body);
  ASSERT_EQ(found.values.size(), truth.size()) << found.reason;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_NEAR(found.values[k].value, truth[k], 1e-6) << found.name << ' ' << found.values[k].name;
  }
}

int held_by(const Payload& found, const Inertial& body) {
  const auto truth = numbers_of(body);
  int out = 0;
  for (std::size_t k = 0; k < found.values.size(); ++k) {
    const auto [low, high] = found.values[k].interval_95;
    out += low <= truth[k] && truth[k] <= high ? 1 : 0;
  }
  return out;
}

TEST(PayloadOfAnArm, IsFoundWithoutNoise) {
  const PayloadBench bench(six_axis());
  const PayloadReport found = on_top_of(arm_of(bench, 1e-9, 1), bench.log(Box().inertial(), 0.0, 2, 2),
                                        {.model = PayloadModel::body});
  ASSERT_TRUE(found.identified) << found.reason;
  EXPECT_TRUE(test::says(found.reason, "the drive gains count as exact")) << found.reason;
  expect_numbers(found.payloads[0], Box().inertial());
}

// What is known of the arm stands for the rows that it was identified from.
TEST(PayloadOfAnArm, IsThatOfOneFitOfAllLogs) {
  const PayloadBench bench(six_axis());
  const double sigma = 0.5;
  for (const double gains : {0.0, 0.01}) {
    PayloadOptions options{.model = PayloadModel::body};
    options.gain_sigma = Vector::Constant(6, gains);
    const PayloadReport stacked = bench.identified(Box(), sigma, 5, options);
    const PayloadReport found =
        on_top_of(arm_of(bench, sigma, 10), bench.log(Box().inertial(), sigma, 11, 2), options);
    for (std::size_t k = 0; k < 10; ++k) {
      const PayloadValue& one = stacked.payloads[0].values[k];
      const PayloadValue& other = found.payloads[0].values[k];
      EXPECT_NEAR(other.value, one.value, 0.4 * one.sigma) << one.name;
      EXPECT_NEAR(other.sigma / one.sigma, 1.0, 0.25) << one.name;
    }
  }
}

// χ̂ = χ + G (1 − 1/r): without noise the gains and the payload come out exactly, however wrong the arm's
// were.
TEST(PayloadOfAnArm, FindsTheGainsThatTheArmWasIdentifiedWith) {
  PayloadBench bench(six_axis());
  bench.gains.resize(6);
  bench.gains << 0.9, 1.12, 0.95, 1.2, 1.0, 0.8;
  PayloadOptions options{.model = PayloadModel::body};
  options.gain_sigma = Vector::Constant(6, infinity);
  const PayloadReport found =
      on_top_of(arm_of(bench, 1e-9, 1), bench.log(Box().inertial(), 0.0, 2, 2), options, Box().mass);
  ASSERT_TRUE(found.identified) << found.reason;
  for (std::size_t j = 0; j < 6; ++j) {
    EXPECT_NEAR(found.gains[j].value * bench.gains[static_cast<Index>(j)], 1.0, 1e-4) << j;
  }
  EXPECT_NEAR(found.payloads[0].com[2], Box().com[2], 1e-4);
}

// An arm whose gains were estimated brings their covariance along.
TEST(PayloadOfAnArm, KnowsItsGainsAsTheResultDoes) {
  const PayloadBench bench(six_axis());
  const Log with = bench.log(Box().inertial(), 0.01, 3, 2);
  const PayloadOptions point{.model = PayloadModel::point};
  const PayloadReport exact =
      on_top_of(arm_of(bench, 0.01, 2), with, {.model = PayloadModel::point, .gain_sigma = Vector::Zero(6)});
  EXPECT_TRUE(exact.gains.empty());
  const IdentifiedArm arm = arm_of(bench, 0.01, 2, 1e-4 * Matrix::Identity(6, 6));
  const PayloadReport uncertain = on_top_of(arm, with, point);
  EXPECT_EQ(uncertain.gains.size(), 6U);
  PayloadOptions told = point;
  told.gain_sigma = Vector::Constant(6, 0.01);
  const PayloadReport wanted = on_top_of(arm_of(bench, 0.01, 2), with, told);
  // To the floor of 1e-12 below which directions of the arm's covariance count as known.
  constexpr double by_the_floor = 1e-5;
  for (std::size_t k = 0; k < wanted.payloads[0].values.size(); ++k) {
    EXPECT_NEAR(uncertain.payloads[0].values[k].sigma / wanted.payloads[0].values[k].sigma, 1.0, by_the_floor)
        << wanted.payloads[0].values[k].name;
  }
  EXPECT_GT(uncertain.payloads[0].values[0].sigma, 3.0 * exact.payloads[0].values[0].sigma);
}

TEST(PayloadOfAnArm, AccusesAGainThatIsFarFromWhatIsKnownOfIt) {
  PayloadBench bench(six_axis());
  bench.gains = Vector::Ones(6);
  bench.gains[1] = 1.1;
  const IdentifiedArm arm = arm_of(bench, 0.01, 2);
  const Log with = bench.log(Box().inertial(), 0.01, 3, 2);
  const LoadedLogs loaded{.logs = std::span(&with, 1)};
  const Estimation estimation{.signal = PayloadBench::signal()};
  const auto accused = [&](const PayloadOptions& options) {
    PayloadReport found = identify_payloads(arm, std::span(&loaded, 1), estimation, options);
    examine(arm.robot, {}, std::span(&loaded, 1), estimation, found);
    return std::ranges::any_of(found.warnings, [](const Finding& f) {
      return f.code == "torque_gain" && f.subject == "joint_2" && test::says(f.text, "known to");
    });
  };
  EXPECT_TRUE(accused({}));
  EXPECT_FALSE(accused({.gain_sigma = Vector::Constant(6, 0.1)}));
}

// Of arms whose gains are off by one percent each, unknown to both identifications.
TEST(PayloadOfAnArm, HasItsNumbersWithinTheirIntervals) {
  constexpr int runs = 60;
  int held = 0;
  const Vector off = 0.01 * test::standard_normal(6 * runs, 3);
  PayloadBench bench(six_axis(), 1500);
  PayloadOptions options{.model = PayloadModel::body};
  options.gain_sigma = Vector::Constant(6, 0.01);
  for (int run = 0; run < runs; ++run) {
    bench.gains = Vector::Ones(6) + off.segment(6 * run, 6);
    const auto seed = static_cast<std::uint64_t>(1000 + 2 * run);
    const PayloadReport found =
        on_top_of(arm_of(bench, 0.5, seed), bench.log(Box().inertial(), 0.5, seed + 1, 2), options);
    ASSERT_TRUE(found.identified) << found.reason;
    held += held_by(found.payloads[0], Box().inertial());
  }
  const double coverage = held / (10.0 * runs);
  RecordProperty("coverage", std::to_string(coverage));
  EXPECT_GE(coverage, 0.93) << held;
  EXPECT_LE(coverage, 0.985) << held;
}

TEST(PayloadOfAnArm, FollowsItsFrictionByLoad) {
  PayloadBench bench(six_axis());
  bench.Fl = Vector::LinSpaced(6, 0.03, 0.12);
  Robot robot = bench.robot;
  for (Joint& joint : robot.joints) {
    joint.friction = Friction::load;
  }
  const Log log = bench.log(Inertial::Zero(), 1e-6, 1, 1);
  const IdentifiedArm arm =
      identified_arm(robot, identify(robot, log, {.method = Wls{}, .signal = PayloadBench::signal()}));
  const PayloadReport found =
      on_top_of(arm, bench.log(Box().inertial(), 1e-6, 9, 2), {.model = PayloadModel::body});
  ASSERT_TRUE(found.identified) << found.reason;
  EXPECT_NEAR(found.payloads[0].mass, Box().mass, 1e-4);
  EXPECT_LT((found.Fl - bench.Fl).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(PayloadOfAnArm, RefusesAnArmThatIsNotDetermined) {
  const PayloadBench bench(six_axis());
  const Log with = bench.log(Box().inertial(), 0.1, 3, 2);
  const IdentifiedArm good = arm_of(bench, 0.1, 2);
  const auto complaint = [&](const IdentifiedArm& arm) {
    return test::complaint_of([&] { return on_top_of(arm, with, {}); });
  };
  IdentifiedArm arm = good;
  arm.C_chi(0, 0) = infinity;
  EXPECT_TRUE(test::says(complaint(arm), "not determined"));
  arm = good;
  arm.gain_slopes.resize(2, 6);
  EXPECT_TRUE(test::says(complaint(arm), "gain_slopes must have"));
  arm = good;
  arm.chi.conservativeResize(4);
  EXPECT_TRUE(test::says(complaint(arm), "chi and C_chi must have"));
}

// A gripper, and the same with a box in it.
class Gripper : public testing::Test {
 protected:
  Gripper() : bench(six_axis(), 1500) {}

  [[nodiscard]] PayloadReport identified(const Inertial& second, double sigma, std::uint64_t seed) const {
    const Log without = bench.log(Inertial::Zero(), sigma, seed, 1);
    const std::array logs = {bench.log(gripper, sigma, seed + 1, 2), bench.log(second, sigma, seed + 2, 3)};
    const std::array<LoadedLogs, 2> loaded = {{{.name = "gripper", .logs = std::span(&logs[0], 1)},
                                               {.name = "gripper and box", .logs = std::span(&logs[1], 1)}}};
    return identify_payloads(bench.robot, std::span(&without, 1), loaded, {.signal = PayloadBench::signal()},
                             {.model = PayloadModel::body});
  }

  PayloadBench bench;
  Inertial gripper = Box{.mass = 2.0, .com = {0.0, 0.01, 0.06}}.inertial();
  Inertial box = Box{.inertia = Eigen::Vector3d(0.06, 0.05, 0.04).asDiagonal()}.inertial();
};

TEST_F(Gripper, AndWhatItHoldsAreTold) {
  const PayloadReport found = identified(gripper + box, 0.0, 1);
  ASSERT_TRUE(found.identified) << found.reason;
  expect_numbers(found.payloads[0], gripper);
  expect_numbers(found.payloads[1], gripper + box);
  ASSERT_EQ(found.differences.size(), 1U);
  EXPECT_EQ(found.differences[0].name, "gripper and box - gripper");
  expect_numbers(found.differences[0], box);
}

TEST_F(Gripper, HasADifferenceWithinItsIntervals) {
  constexpr int runs = 40;
  int held = 0;
  for (int run = 0; run < runs; ++run) {
    const PayloadReport found = identified(gripper + box, 0.3, static_cast<std::uint64_t>(100 + 3 * run));
    ASSERT_EQ(found.differences[0].values.size(), 10U) << found.differences[0].reason;
    held += held_by(found.differences[0], box);
    // The arm is the same in both.
    const double apart = std::hypot(found.payloads[0].values[0].sigma, found.payloads[1].values[0].sigma);
    EXPECT_LT(found.differences[0].values[0].sigma, apart);
  }
  const double coverage = held / (10.0 * runs);
  RecordProperty("coverage", std::to_string(coverage));
  EXPECT_GE(coverage, 0.92) << held;
  EXPECT_LE(coverage, 0.99) << held;
}

TEST_F(Gripper, WithoutABoxHasNoOtherCentreOfMass) {
  const Payload difference = identified(gripper, 0.3, 7).differences[0];
  ASSERT_EQ(difference.values.size(), 1U);
  EXPECT_LT(difference.values[0].interval_95[0], 0.0);
  EXPECT_GT(difference.values[0].interval_95[1], 0.0);
  EXPECT_TRUE(test::says(difference.reason, "the mass differs from zero by less than"));
}

// A point of no mass has no centre: the automatic model tells the mass alone.
TEST_F(Gripper, MayBeNone) {
  const Log without = bench.log(Inertial::Zero(), 0.3, 1, 1);
  const std::array logs = {bench.log(gripper, 0.3, 2, 2), bench.log(Inertial::Zero(), 0.3, 3, 3)};
  const std::array<LoadedLogs, 2> loaded = {{{.name = "gripper", .logs = std::span(&logs[0], 1)},
                                             {.name = "none", .logs = std::span(&logs[1], 1)}}};
  const PayloadReport found =
      identify_payloads(bench.robot, std::span(&without, 1), loaded, {.signal = PayloadBench::signal()});
  ASSERT_TRUE(found.identified) << found.reason;
  EXPECT_GE(found.payloads[0].values.size(), 4U);
  EXPECT_EQ(found.payloads[1].values.size(), 1U);
  EXPECT_TRUE(test::says(found.payloads[1].reason, "no payload (less than "));
  EXPECT_NEAR(found.differences[0].mass, -gripper[9], 4.0 * found.differences[0].values[0].sigma);
}

TEST_F(Gripper, NeedsTwoNames) {
  const Log log = bench.log(gripper, 0.1, 1, 1);
  const std::array<LoadedLogs, 2> loaded = {{{.logs = std::span(&log, 1)}, {.logs = std::span(&log, 1)}}};
  EXPECT_TRUE(test::says(test::complaint_of([&] {
                           return identify_payloads(bench.robot, std::span(&log, 1), loaded,
                                                    {.signal = PayloadBench::signal()});
                         }),
                         "two payloads are named \"payload\""));
}

}  // namespace
}  // namespace rivid
