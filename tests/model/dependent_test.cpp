#include "rivid/model/dependent.hpp"

#include <gtest/gtest.h>

#include "rivid/model/urdf.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "support/complaint.hpp"
#include "support/two_arms.hpp"

namespace rivid {
namespace {

using Strings = std::vector<std::string>;

Strings names(const Robot& robot) {
  Strings out;
  for (const Joint& joint : robot.joints) {
    out.push_back(joint.name);
  }
  return out;
}

Robot two_arms(const UrdfOptions& options = {}) {
  return parse_urdf(test::two_arms(), "two_arms.urdf", options);
}

// All joints of the arms move by themselves where no mimic is said.
Robot independent_arms() {
  std::string xml = test::two_arms();
  for (std::size_t at = xml.find("<mimic"); at != std::string::npos; at = xml.find("<mimic")) {
    xml.erase(at, xml.find("/>", at) + 2 - at);
  }
  return parse_urdf(xml, "two_arms.urdf");
}

std::string refusal(const std::vector<DependentJoint>& dependents) {
  return test::complaint_of([&] { return with_dependents(independent_arms(), dependents); });
}

TEST(Dependent, MimicJointsOfAUrdfFollowTheirLeaders) {
  const Robot robot = two_arms();
  EXPECT_EQ(names(robot), (Strings{"waist", "left_shoulder", "left_elbow", "left_wrist", "left_grip",
                                   "right_shoulder", "right_elbow", "right_wrist", "right_grip"}));
  const std::vector<DependentJoint> dependents = dependent_joints(robot);
  ASSERT_EQ(dependents.size(), 2U);
  EXPECT_EQ(dependents[1].joint, "right_grip_2");
  EXPECT_EQ(dependents[1].of, (std::map<std::string, double>{{"right_grip", -1.0}}));
  EXPECT_EQ(robot.link_name(10), "right_thumb");
  EXPECT_EQ(robot.notes, (Strings{"joint \"left_grip_2\" follows others: q = 0 - 1 q of \"left_grip\"",
                                  "joint \"right_grip_2\" follows others: q = 0 - 1 q of \"right_grip\""}));
}

TEST(Dependent, MimicJointsWhoseLeaderIsNoneOfTheRobotAreHeldAndThatIsSaid) {
  const Robot robot = two_arms({.base = {}, .tip = {}, .moving = {"left_wrist", "right_grip"}});
  EXPECT_EQ(names(robot), (Strings{"left_wrist", "right_grip"}));
  ASSERT_EQ(dependent_joints(robot).size(), 1U);
  EXPECT_EQ(dependent_joints(robot)[0].joint, "right_grip_2");
  EXPECT_TRUE(std::ranges::any_of(robot.warnings, [](const Finding& warning) {
    return warning.text.find("\"left_grip\", \"left_grip_2\" (mimic); held at q = 0") != std::string::npos;
  }));
  EXPECT_TRUE(
      test::says(test::complaint_of(
                     [] { return two_arms({.base = {}, .tip = {}, .moving = {"waist", "left_grip_2"}}); }),
                 "joint \"left_grip_2\": follows joint \"left_grip\" (mimic), which is none of the robot's"));
}

TEST(Dependent, AChainEndsAtAMimicJointAsAtAnyOther) {
  std::string xml = test::two_arms();
  const std::string grip = "<mimic joint=\"left_grip\" multiplier=\"-1\"/>";
  xml.replace(xml.find(grip), grip.size(),
              "<mimic joint=\"left_wrist\" multiplier=\"0.5\" offset=\"0.01\"/>");
  const Robot robot = parse_urdf(xml, "two_arms.urdf", {.base = {}, .tip = "left_thumb"});
  EXPECT_EQ(names(robot), (Strings{"waist", "left_shoulder", "left_elbow", "left_wrist"}));
  ASSERT_EQ(robot.chain.dependents.size(), 1U);
  EXPECT_EQ(robot.chain.dependents[0].offset, 0.01);
  // One whose leader is on another branch stands still.
  const Robot right = parse_urdf(xml, "two_arms.urdf", {.base = {}, .tip = "right_thumb"});
  EXPECT_EQ(right.size(), 4);
  EXPECT_TRUE(right.chain.dependents.empty());
}

TEST(Dependent, WhatIsStatedTakesThePlaceOfWhatTheFileSays) {
  const DependentJoint stated{
      .joint = "left_grip_2", .of = {{"left_grip", -0.5}, {"waist", 2.0}}, .offset = 0.1};
  const Robot robot = two_arms({.base = {}, .tip = {}, .dependent = {stated}});
  const std::vector<DependentJoint> dependents = dependent_joints(robot);
  ASSERT_EQ(dependents.size(), 2U);
  EXPECT_EQ(dependents[0].of, stated.of);
  EXPECT_EQ(dependents[0].offset, 0.1);
  // The part of the file that it is reads as the same robot.
  const Robot again = two_arms(same_part(robot));
  EXPECT_EQ(names(again), names(robot));
  EXPECT_EQ(dependent_joints(again)[0].of, stated.of);
  EXPECT_EQ(again.chain.parents, robot.chain.parents);
}

TEST(Dependent, OneThatFollowsADependentJointFollowsWhatThatOneFollows) {
  const Robot robot = with_dependents(
      independent_arms(),
      std::vector<DependentJoint>{{.joint = "left_elbow", .of = {{"left_wrist", 2.0}}, .offset = 1.0},
                                  {.joint = "left_wrist", .of = {{"waist", 3.0}}, .offset = 0.5}});
  const std::vector<DependentJoint> dependents = dependent_joints(robot);
  EXPECT_EQ(dependents[0].of, (std::map<std::string, double>{{"waist", 6.0}}));
  EXPECT_EQ(dependents[0].offset, 2.0);
}

TEST(Dependent, FaultsNameTheJoint) {
  EXPECT_TRUE(test::says(refusal({{.joint = "left_wirst", .of = {{"waist", 1.0}}}}),
                         "dependent joint \"left_wirst\": it is no joint of the robot; did you mean "
                         "\"left_wrist\"?"));
  EXPECT_TRUE(
      test::says(refusal({{.joint = "left_wrist", .of = {{"hip", 1.0}}}}),
                 "dependent joint \"left_wrist\": it follows \"hip\", which is no joint of the robot"));
  EXPECT_TRUE(test::says(refusal({{.joint = "left_wrist", .of = {{"waist", 1.0}}},
                                  {.joint = "left_wrist", .of = {{"waist", 2.0}}}}),
                         "dependent joint \"left_wrist\": it is described twice"));
  EXPECT_TRUE(test::says(refusal({{.joint = "left_wrist", .of = {{"left_elbow", 1.0}}},
                                  {.joint = "left_elbow", .of = {{"left_wrist", 1.0}}}}),
                         "it follows itself, by way of \"left_elbow\" and \"left_wrist\""));
  EXPECT_TRUE(test::says(refusal({{.joint = "left_wrist", .of = {{"waist", 0.0}}}}),
                         "dependent joint \"left_wrist\": it follows no joint"));
}

}  // namespace
}  // namespace rivid
