#include "rivid/identify/rollouts.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/complaint.hpp"
#include "support/scara_study.hpp"

namespace rivid {
namespace {

// The SCARA of [RIV], a log of it, and models of it by their base parameters.
class RolloutsOfTheScara : public testing::Test {
 protected:
  [[nodiscard]] ComparedModel model(const std::string& name, const Vector& chi) const {
    return {name, study_.robot, study_.base.to_standard(chi)};
  }
  [[nodiscard]] RolloutOptions controlled() const {
    return {.control = study_.control, .sampling = test::ScaraStudy::computer()};
  }
  [[nodiscard]] static const Rollout& found(const Rollouts& all, Drive drive, double horizon) {
    return *std::ranges::find_if(
        all.found, [&](const Rollout& one) { return one.drive == drive && one.horizon == horizon; });
  }

  test::ScaraStudy study_;
  Log log_ = study_.log(1.0, 77);
  Vector wrong_ = 1.3 * study_.truth;
};

TEST_F(RolloutsOfTheScara, TheTruthMovesAsTheLogToItsNoise) {
  const std::vector<ComparedModel> truth = {model("truth", study_.truth)};
  const Rollouts all = rollouts(truth, std::span(&log_, 1), controlled());
  ASSERT_EQ(all.notes.size(), 1U);
  EXPECT_EQ(all.notes.front(),
            "closed loop: the gains of the control law are matched to the inertias of truth, for all models");
  ASSERT_EQ(all.found.size(), 8U);
  // Eight moves of 2.5 s: six windows of 3 s, 40 of each shorter horizon at most.
  EXPECT_EQ(found(all, Drive::torques, 3.0).windows, 6);
  EXPECT_EQ(found(all, Drive::torques, 0.1).windows, 40);
  // In a tenth of a second the disturbance of 0.06 N·m, new each 5 ms, adds next to nothing to encoders.
  const Rollout::Error& soon = found(all, Drive::torques, 0.1).models.front();
  EXPECT_LT(soon.q.maxCoeff(), 1e-3);
  EXPECT_GT(soon.q.minCoeff(), 0.5 * study_.encoder_noise);
  // The loop holds the motion together, whatever the horizon.
  EXPECT_LT(found(all, Drive::controller, 3.0).models.front().q.maxCoeff(), 0.02);
  EXPECT_EQ(found(all, Drive::controller, 3.0).models.front().lost, 0);
}

TEST_F(RolloutsOfTheScara, ModelsThatAreWrongMoveLessLikeTheRobot) {
  const std::vector<ComparedModel> models = {model("truth", study_.truth), model("wrong", wrong_)};
  const Rollouts all = rollouts(models, std::span(&log_, 1), controlled());
  for (const double horizon : {0.1, 0.3, 1.0}) {
    const Rollout& open = found(all, Drive::torques, horizon);
    ASSERT_TRUE(open.tests.front().better.has_value()) << horizon << " s, p = " << open.tests.front().p;
    EXPECT_EQ(*open.tests.front().better, 0U) << horizon;
    EXPECT_LT(open.tests.front().ratio, 1.0);
    EXPECT_LT(open.models[0].q[0], open.models[1].q[0]);
  }
  const std::vector<ComparedModel> turned = {models[1], models[0]};
  const Rollouts other = rollouts(turned, std::span(&log_, 1));
  EXPECT_EQ(*found(other, Drive::torques, 0.3).tests.front().better, 1U);
  ASSERT_EQ(other.notes.size(), 1U);
  EXPECT_EQ(other.notes.front(), "no closed-loop rollouts: the experiment file has no [control]");
}

TEST_F(RolloutsOfTheScara, ModelsThatAreAsGoodAreNotDistinguished) {
  // Off by as much, to either side.
  const std::vector<ComparedModel> models = {model("a", 1.02 * study_.truth),
                                             model("b", study_.truth / 1.02)};
  const Rollouts both = rollouts(models, std::span(&log_, 1));
  for (const Rollout& one : both.found) {
    EXPECT_FALSE(one.tests.front().better.has_value()) << name(one.drive) << " " << one.horizon;
  }
  const std::vector<ComparedModel> twice = {models.front(), models.front()};
  const Rollouts same = rollouts(twice, std::span(&log_, 1));
  for (const Rollout& one : same.found) {
    EXPECT_EQ(one.tests.front().t, 0.0);
  }
}

TEST_F(RolloutsOfTheScara, WindowsThatAModelIsLostInCountAgainstIt) {
  Vector no_robot = study_.truth;
  no_robot[study_.index("ZZ2")] = -0.05;
  const std::vector<ComparedModel> models = {model("truth", study_.truth), model("no robot", no_robot)};
  const Rollouts all = rollouts(models, std::span(&log_, 1));
  const Rollout& open = found(all, Drive::torques, 0.3);
  EXPECT_EQ(open.models[1].lost, open.windows);
  EXPECT_EQ(open.models[0].lost, 0);
  EXPECT_EQ(*open.tests.front().better, 0U);
  // The other model has the errors that it has alone.
  EXPECT_EQ(open.models[1].q.size(), 0);
  const Rollouts alone = rollouts(std::span(models.data(), 1), std::span(&log_, 1));
  EXPECT_EQ(open.models[0].q, found(alone, Drive::torques, 0.3).models[0].q);
  EXPECT_EQ(open.models[0].q.size(), 2);
}

TEST_F(RolloutsOfTheScara, LieInTheWindowOfTheLog) {
  const std::vector<ComparedModel> truth = {model("truth", study_.truth)};
  Log spoiled = log_;
  const Index half = log_.samples() / 2;
  spoiled.q.bottomRows(half).array() += 1.0;
  spoiled.v_tau.bottomRows(half).array() += 100.0;
  const RolloutOptions first_half{.window = std::array{log_.t[0], log_.t[half - 100]}};
  const Rollouts clean = rollouts(truth, std::span(&log_, 1), first_half);
  const Rollouts same = rollouts(truth, std::span(&spoiled, 1), first_half);
  EXPECT_EQ(found(clean, Drive::torques, 0.3).windows, found(same, Drive::torques, 0.3).windows);
  EXPECT_EQ(found(clean, Drive::torques, 0.3).models[0].q, found(same, Drive::torques, 0.3).models[0].q);
  // Eight moves of 2.5 s.
  EXPECT_EQ(found(clean, Drive::torques, 3.0).windows, 3);
}

TEST_F(RolloutsOfTheScara, RefusesOptionsThatSayNothing) {
  const std::vector<ComparedModel> models = {model("truth", study_.truth)};
  EXPECT_EQ(test::complaint_of([&] { return rollouts(models, std::span(&log_, 1), {.horizons = {}}); }),
            "rollouts: horizons must be positive, at least one");
  EXPECT_EQ(test::complaint_of([&] { return rollouts(models, std::span(&log_, 1), {.windows = 0}); }),
            "rollouts: windows is 0, must be at least 1");
}

}  // namespace
}  // namespace rivid
