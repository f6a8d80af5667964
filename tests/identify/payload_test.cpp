#include "rivid/identify/payload.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "support/complaint.hpp"
#include "support/payload_bench.hpp"
#include "support/robots.hpp"
#include "support/two_arms.hpp"

namespace rivid {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

using test::Box;
using test::six_axis;
using Bench = test::PayloadBench;

std::array<double, 10> truth_of(const Box& box) {
  const Eigen::Matrix3d& I = box.inertia;
  return {box.mass, box.com[0], box.com[1], box.com[2], I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
}

TEST(Payload, IsFoundWithoutNoise) {
  const Box box;
  const PayloadReport found = Bench(six_axis()).identified(box, 0.0, 1, {.model = PayloadModel::body});
  ASSERT_TRUE(found.identified) << found.reason;
  ASSERT_EQ(found.payloads[0].values.size(), 10U);
  const auto truth = truth_of(box);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_NEAR(found.payloads[0].values[k].value, truth[k], 1e-6) << found.payloads[0].values[k].name;
  }
  EXPECT_LT(found.relative_error, 1e-8);
}

TEST(Payload, IsToldInTheFlangeFrame) {
  std::mt19937_64 random(5);
  PayloadOptions options{.model = PayloadModel::body};
  options.R = test::random_rotation(random);
  options.p = {0.01, 0.02, 0.1};
  const Box box;
  const PayloadReport found = Bench(six_axis()).identified(box, 0.0, 1, options);
  EXPECT_LT((options.R * found.payloads[0].com + options.p - box.com).norm(), 1e-6);
  EXPECT_LT((options.R * found.payloads[0].inertia * options.R.transpose() - box.inertia).norm(), 1e-6);
}

TEST(Payload, HangsOnAnyNamedLinkOfAnArmOrATree) {
  const Robot tree = parse_urdf(test::two_arms(), "two_arms.urdf",
                                {.base = {},
                                 .tip = {},
                                 .moving = {"waist", "left_shoulder", "left_elbow", "left_wrist",
                                            "right_shoulder", "right_elbow", "right_wrist"}});
  const Box box;
  for (const auto& [robot, at] : {std::pair(six_axis(), 3), std::pair(tree, 3), std::pair(tree, 6)}) {
    Bench bench(robot);
    bench.loaded_link = at;
    const PayloadOptions options{.model = PayloadModel::body,
                                 .link = robot.joints[static_cast<std::size_t>(at)].link};
    const PayloadReport found = bench.identified(box, 0.0, 1, options);
    ASSERT_TRUE(found.identified) << found.reason;
    const auto truth = truth_of(box);
    for (std::size_t k = 0; k < truth.size(); ++k) {
      EXPECT_NEAR(found.payloads[0].values[k].value, truth[k], 1e-6) << found.payloads[0].values[k].name;
    }
    EXPECT_GT(bench.identified(box, 0.0, 1, {.link = robot.joints[1].link}).relative_error, 0.01)
        << "the wrong link explains it as well";
  }
  const auto complaint = [&](const PayloadOptions& options) {
    return test::complaint_of([&] { return Bench(tree).identified(box, 0.1, 1, options); });
  };
  EXPECT_TRUE(test::says(complaint({}), "the robot branches, so the link of the payload must be named"));
  EXPECT_TRUE(test::says(complaint({.link = "hand"}), "no moving link is called \"hand\" (links: \"torso\""));
}

// Mass, centre of mass and inertia of payloads from half a kilogram to ten, on three arms.
TEST(Payload, HasItsNumbersWithinTheirIntervals) {
  int held = 0;
  int all = 0;
  std::vector<Robot> arms = {six_axis()};
  for (const std::uint64_t seed : {3U, 8U}) {
    std::mt19937_64 random(seed);
    arms.push_back(test::random_robot(5, random));
  }
  for (const Robot& arm : arms) {
    const Bench bench(arm, 1500);
    std::uint64_t seed = 100;
    for (const double mass : {0.5, 3.0, 10.0}) {
      const Box box{.mass = mass, .inertia = mass / 3.0 * Box().inertia};
      for (int run = 0; run < 24; ++run) {
        const PayloadReport found = bench.identified(box, 0.5, ++seed, {.model = PayloadModel::body});
        ASSERT_TRUE(found.identified) << found.reason;
        const auto truth = truth_of(box);
        for (std::size_t k = 0; k < truth.size(); ++k) {
          const auto [low, high] = found.payloads[0].values[k].interval_95;
          held += low <= truth[k] && truth[k] <= high ? 1 : 0;
          ++all;
        }
      }
    }
  }
  const double coverage = static_cast<double>(held) / all;
  RecordProperty("coverage", std::to_string(coverage));
  EXPECT_GE(coverage, 0.93) << held << " of " << all;
  EXPECT_LE(coverage, 0.98) << held << " of " << all;
}

TEST(Payload, IsAPointWhereItsInertiaIsNotSeen) {
  const Box light{.mass = 1.0, .inertia = 1e-4 * Eigen::Matrix3d::Identity()};
  const PayloadReport found = Bench(six_axis()).identified(light, 1.0, 4);
  ASSERT_TRUE(found.identified);
  EXPECT_EQ(found.payloads[0].model, PayloadModel::point);
  EXPECT_EQ(found.payloads[0].values.size(), 4U);
  EXPECT_TRUE(test::says(found.payloads[0].reason, "only mass and centre of mass are reported"));
  EXPECT_LE(found.payloads[0].values[0].interval_95[0], 1.0);
  EXPECT_GE(found.payloads[0].values[0].interval_95[1], 1.0);
}

// δm / m = δK / K.
TEST(Payload, CarriesTheUncertaintyOfTheGains) {
  const Bench bench(six_axis());
  const Box box;
  PayloadOptions options{.model = PayloadModel::point, .gain_sigma = Vector::Zero(6)};
  const PayloadReport exact = bench.identified(box, 0.01, 6, options);
  options.gain_sigma = Vector::Constant(6, 0.01);
  const PayloadReport uncertain = bench.identified(box, 0.01, 6, options);
  const PayloadReport untold = bench.identified(box, 0.01, 6, {.model = PayloadModel::point});
  EXPECT_EQ(untold.payloads[0].values[0].sigma, uncertain.payloads[0].values[0].sigma);
  EXPECT_LT(exact.payloads[0].values[0].sigma, 0.001 * box.mass);
  // Six independent gains, of which those that feel most of the weight count.
  EXPECT_GT(uncertain.payloads[0].values[0].sigma, 0.003 * box.mass);
  EXPECT_LT(uncertain.payloads[0].values[0].sigma, 0.011 * box.mass);
}

TEST(Payload, FindsTheGainsFromAKnownMass) {
  Bench bench(six_axis());
  bench.gains.resize(6);
  bench.gains << 0.9, 1.12, 0.95, 1.2, 1.0, 2.0;
  const Box box;
  PayloadOptions options{.model = PayloadModel::body};
  options.gain_sigma = Vector::Constant(6, infinity);
  const PayloadReport found = bench.identified(box, 0.0, 7, options, box.mass);
  ASSERT_TRUE(found.identified) << found.reason;
  for (std::size_t j = 0; j < 6; ++j) {
    EXPECT_NEAR(found.gains[j].value, found.gains[j].nominal / bench.gains[static_cast<Index>(j)], 1e-5) << j;
    EXPECT_TRUE(found.gains[j].identifiable);
  }
}

TEST(Payload, HasGainsWithoutBiasWithinTheirIntervals) {
  Bench bench(six_axis(), 1500);
  bench.gains.resize(6);
  bench.gains << 0.9, 1.12, 0.95, 1.2, 1.0, 0.8;
  const Box box{.mass = 8.0};
  PayloadOptions options{.model = PayloadModel::body};
  options.gain_sigma = Vector::Constant(6, infinity);
  constexpr int runs = 40;
  int held = 0;
  int all = 0;
  Vector bias = Vector::Zero(6);
  for (int run = 0; run < runs; ++run) {
    const PayloadReport found =
        bench.identified(box, 0.5, 300 + static_cast<std::uint64_t>(run), options, box.mass);
    ASSERT_TRUE(found.identified) << found.reason;
    for (Index j = 0; j < 6; ++j) {
      const GainEstimate& gain = found.gains[static_cast<std::size_t>(j)];
      const double truth = gain.nominal / bench.gains[j];
      if (gain.identifiable) {
        held += gain.interval_95[0] <= truth && truth <= gain.interval_95[1] ? 1 : 0;
        bias[j] += (gain.value / truth - 1.0) / runs;
        ++all;
      }
    }
  }
  const double coverage = static_cast<double>(held) / all;
  RecordProperty("coverage", std::to_string(coverage));
  EXPECT_GE(coverage, 0.92) << held << " of " << all;
  EXPECT_LE(coverage, 0.985) << held << " of " << all;
  EXPECT_LT(bias.cwiseAbs().maxCoeff(), 0.01) << bias.transpose();
}

TEST(Payload, IsFoundUnderFrictionByLoad) {
  Bench bench(six_axis());
  bench.Fl = Vector::LinSpaced(6, 0.03, 0.12);
  PayloadOptions options{.model = PayloadModel::body, .load_friction = true};
  const PayloadReport found = bench.identified(Box(), 0.0, 9, options);
  ASSERT_TRUE(found.identified) << found.reason;
  EXPECT_NEAR(found.payloads[0].mass, Box().mass, 1e-6);
  EXPECT_LT((found.Fl - bench.Fl).cwiseAbs().maxCoeff(), 1e-6);
  options.load_friction = false;
  EXPECT_GT(std::abs(bench.identified(Box(), 0.0, 9, options).payloads[0].mass - Box().mass), 0.01);
}

PayloadReport found_at_rest(const std::vector<Index>& without, const std::vector<Index>& with) {
  const Robot robot = Bench(six_axis()).robot;
  const Log alone = test::log_with_joints_at_rest(robot, Inertial::Zero(), 1, without);
  const Log heavy = test::log_with_joints_at_rest(robot, Box().inertial(), 2, with);
  const LoadedLogs loaded{.logs = std::span(&heavy, 1)};
  const Estimation estimation{.signal = {.torque_held = false, .decimation = {10}}};
  return identify_payloads(robot, std::span(&alone, 1), std::span(&loaded, 1), estimation,
                           {.gain_sigma = Vector::Zero(6)});
}

TEST(Payload, IsFoundWhereJointsStandInTheLoadedLog) {
  for (const std::vector<Index>& joints : {std::vector<Index>{0}, {1}, {2}, {3}, {4}, {5}, {0, 1}}) {
    SCOPED_TRACE("from joint " + std::to_string(joints.front()) + " on, " + std::to_string(joints.size()));
    const PayloadReport found = found_at_rest({}, joints);
    ASSERT_TRUE(found.identified) << found.reason;
    for (Index k = 0; k < 4; ++k) {
      const PayloadValue& value = found.payloads[0].values[static_cast<std::size_t>(k)];
      const double truth = k == 0 ? Box().mass : Box().com[k - 1];
      EXPECT_NEAR(value.value, truth, std::max(0.005 * truth, 4.0 * value.sigma)) << value.name;
      EXPECT_LT(value.sigma, 0.3) << value.name;
    }
  }
}

// Three joints whose axes meet see first moments; the mass only as far as the inertia is known.
TEST(Payload, IsNotWeighedByTheWristAlone) {
  const PayloadReport found = found_at_rest({}, {0, 1, 2});
  EXPECT_FALSE(found.identified);
  EXPECT_TRUE(test::says(found.reason, "payload: the motion does not show its mass"));
  const Payload& payload = found.payloads[0];
  EXPECT_TRUE(payload.unweighed);
  EXPECT_FALSE(payload.none());
  ASSERT_EQ(payload.values.size(), 1U);
  EXPECT_LE(payload.values[0].interval_95[0], Box().mass);
  EXPECT_GE(payload.values[0].interval_95[1], Box().mass);
  EXPECT_GT(payload.values[0].sigma, 0.25 * Box().mass);
}

// The inertia that the motion does not show is no reason for a wrong centre of mass.
TEST(Payload, CarriesTheInertiaThatIsNotSeen) {
  int held = 0;
  int all = 0;
  const Bench bench(six_axis(), 1500);
  for (std::uint64_t run = 0; run < 40; ++run) {
    const Box box{.mass = 5.0, .inertia = 5.0 * 0.02 * Eigen::Matrix3d::Identity()};
    const PayloadReport found =
        bench.identified(box, 0.5, 500 + run, {.model = PayloadModel::point, .gain_sigma = Vector::Zero(6)});
    ASSERT_TRUE(found.identified) << found.reason;
    EXPECT_GT(found.payloads[0].inertia.trace(), 0.0);
    for (Index k = 0; k < 4; ++k) {
      const PayloadValue& value = found.payloads[0].values[static_cast<std::size_t>(k)];
      const double truth = k == 0 ? box.mass : box.com[k - 1];
      held += std::abs(value.value - truth) <= 0.5 * (value.interval_95[1] - value.interval_95[0]) ? 1 : 0;
      ++all;
    }
  }
  EXPECT_GE(held, 0.9 * all) << held << " of " << all;
}

// The last joint's own parameters are not seen then, and the payload's are.
TEST(Payload, IsFoundWhereAJointStandsInAllLogs) {
  const PayloadReport found = found_at_rest({5}, {5});
  ASSERT_TRUE(found.identified) << found.reason;
  EXPECT_TRUE(test::says(found.reason, "does not determine all parameters of the arm"));
  EXPECT_NEAR(found.payloads[0].mass, Box().mass, 0.01);
}

TEST(Payload, IsNoneWhereNothingMoves) {
  const std::vector<Index> all = {0, 1, 2, 3, 4, 5};
  const PayloadReport found = found_at_rest({}, all);
  EXPECT_FALSE(found.identified);
  EXPECT_TRUE(test::says(found.reason, "does not determine all parameters of arm and payload"));
  EXPECT_TRUE(test::says(found_at_rest(all, all).reason, "0 rows for"));
}

TEST(Payload, RefusesWhatCanNotBeTold) {
  const Bench bench(six_axis());
  PayloadOptions options;
  options.gain_sigma = Vector::Constant(6, infinity);
  EXPECT_TRUE(test::says(
      test::complaint_of([&] { static_cast<void>(bench.identified(Box(), 0.1, 1, options)); }), "ratios"));
  options.gain_sigma = Vector::Zero(2);
  EXPECT_TRUE(
      test::says(test::complaint_of([&] { static_cast<void>(bench.identified(Box(), 0.1, 1, options)); }),
                 "gain_sigma has 2 values"));
  const Log log = bench.log(Inertial::Zero(), 0.1, 1, 1);
  EXPECT_TRUE(test::says(test::complaint_of([&] {
                           const LoadedLogs loaded{.logs = std::span(&log, 1)};
                           static_cast<void>(identify_payloads(bench.robot, {}, std::span(&loaded, 1), {}));
                         }),
                         "no log without the payload"));
}

TEST(Payload, IsWrittenAsControllersTakeIt) {
  Payload payload;
  payload.mass = 2.805;
  payload.com = {0.0295, 0.1592, -0.1662};
  payload.inertia << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  EXPECT_EQ(urscript_line(payload),
            "set_target_payload(2.805, [0.0295, 0.1592, -0.1662], [1, 4, 6, 2, 3, 5])");
  EXPECT_EQ(libfranka_line(payload),
            "robot.setLoad(2.805, {0.0295, 0.1592, -0.1662}, {1, 2, 3, 2, 4, 5, 3, 5, 6});");
}

}  // namespace
}  // namespace rivid
