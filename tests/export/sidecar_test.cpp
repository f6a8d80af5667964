#include <gtest/gtest.h>

#include <algorithm>

#include "rivid/export/urdf.hpp"
#include "support/complaint.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

// Two joints, the second with a gear of 50, asymmetric friction and a name that XML must escape.
struct Geared {
  Robot robot = test::scara();
  Vector chi_st;

  Geared() {
    robot.joints[0].friction = Friction::symmetric;
    robot.joints[1].friction = Friction::asymmetric;
    robot.joints[1].rotor_inertia = true;
    robot.joints[1].gear_ratio = -50.0;
    robot.joints[1].name = "a<b";
    chi_st = Vector::Zero(static_cast<Index>(robot.standard_parameters().size()));
    set("Ia1", 0.5);
    set("Fv1", 0.25);
    set("Fc1", 1.5);
    set("off1", -0.125);
    set("Ia2", 0.625);
    set("Fv+2", 1.0);
    set("Fv-2", 3.0);
    set("Fc+2", 5.0);
    set("Fc-2", 7.0);
  }

  void set(std::string_view name, double value) {
    const auto parameters = robot.standard_parameters();
    const auto at = std::ranges::find(parameters, name, &StandardParameter::name);
    ASSERT_NE(at, parameters.end()) << name;
    chi_st[at - parameters.begin()] = value;
  }
};

TEST(Sidecar, OfMujocoHasADefaultClassForEachJoint) {
  const Geared g;
  EXPECT_EQ(sidecar(Sidecar::mujoco, g.robot, g.chi_st), R"(<?xml version="1.0"?>
<!-- Include this file, and give each joint the class of its name. -->
<mujocoinclude>
  <default>
    <default class="joint_1">
      <joint armature="0.5" damping="0.25" frictionloss="1.5"/><!-- no place for off1 = -0.125 N·m -->
    </default>
    <default class="a&lt;b">
      <joint armature="0.625" damping="2" frictionloss="6"/><!-- no place for Fv+2 = 1 N·m·s/rad, Fc+2 = 5 N·m, Fv-2 = 3 N·m·s/rad, Fc-2 = 7 N·m -->
    </default>
  </default>
</mujocoinclude>
)");
}

TEST(Sidecar, OfDrakeTellsTheRotorsInertiaBehindItsGear) {
  const Geared g;
  const std::string text = sidecar(Sidecar::drake, g.robot, g.chi_st);
  EXPECT_NE(text.find(R"(<robot name="scara" xmlns:drake="http://drake.mit.edu">)"), std::string::npos)
      << text;
  EXPECT_NE(text.find(R"(    <actuator name="a&lt;b_motor">
      <drake:rotor_inertia value="0.00025"/>
      <drake:gear_ratio value="-50"/>)"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find(R"(<drake:rotor_inertia value="0.5"/>)"), std::string::npos) << text;
}

TEST(Sidecar, OfPinocchioIsAnSrdfOfRotorParameters) {
  const Geared g;
  const std::string text = sidecar(Sidecar::pinocchio, g.robot, g.chi_st);
  EXPECT_NE(text.find(R"(  <rotor_params>
    <joint name="joint_1" mass="0.5" gear_ratio="1"/>)"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find(R"(<joint name="a&lt;b" mass="0.00025" gear_ratio="-50"/>)"), std::string::npos)
      << text;
}

TEST(Sidecar, RefusesANegativeRotorInertia) {
  Geared g;
  g.set("Ia1", -0.5);
  for (const Sidecar format : {Sidecar::mujoco, Sidecar::drake, Sidecar::pinocchio}) {
    EXPECT_TRUE(test::says(test::complaint_of([&] { return sidecar(format, g.robot, g.chi_st); }),
                           "joint \"joint_1\": Ia is -0.5, must not be negative"));
  }
}

TEST(Sidecar, IsFoundByItsName) {
  for (const Sidecar format : {Sidecar::mujoco, Sidecar::drake, Sidecar::pinocchio}) {
    EXPECT_EQ(sidecar_named(name(format)), format);
  }
  EXPECT_EQ(sidecar_named("gazebo"), std::nullopt);
}

}  // namespace
}  // namespace rivid
