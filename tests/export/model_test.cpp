#include "rivid/export/model.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "rivid/model/urdf.hpp"
#include "support/complaint.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

// A base that is turned, two joints with a tool on a fixed one behind them, a gripper's finger beside, shapes
// and meshes, and transmissions of an earlier hand. The name of the second joint is one that XML must escape.
constexpr const char* geared_urdf = R"(<?xml version="1.0"?>
<robot name="geared">
  <material name="blue"><color rgba="0 0 1 1"/></material>
  <link name="world"/>
  <joint name="mount" type="fixed">
    <parent link="world"/><child link="base"/>
    <origin xyz="0 0 1" rpy="0 1.5707963267948966 0"/>
  </joint>
  <link name="base">
    <collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>
  </link>
  <joint name="joint_1" type="revolute">
    <parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" effort="30" velocity="3"/>
    <dynamics damping="0.25" friction="1.5"/>
  </joint>
  <link name="upper">
    <inertial><origin xyz="0.1 0 0"/><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
    <visual><geometry><cylinder radius="0.05" length="0.4"/></geometry><material name="blue"/></visual>
    <visual><geometry><mesh filename="package://arms/upper.stl" scale="2 2 2"/></geometry></visual>
    <visual><geometry><mesh filename="package://arms/upper.dae"/></geometry></visual>
  </link>
  <joint name="a&lt;b" type="continuous">
    <parent link="upper"/><child link="fore"/>
    <origin xyz="0.4 0 0" rpy="0.1 0.2 0.3"/>
    <axis xyz="0 1 0"/>
  </joint>
  <link name="fore">
    <inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
  </link>
  <joint name="flange" type="fixed">
    <parent link="fore"/><child link="tool0"/>
    <origin xyz="0 0 0.1"/>
  </joint>
  <link name="tool0">
    <visual><geometry><sphere radius="0.01"/></geometry></visual>
  </link>
  <joint name="finger" type="prismatic">
    <parent link="upper"/><child link="tip"/>
    <limit lower="0" upper="0.1" effort="1" velocity="1"/>
  </joint>
  <link name="tip"/>
  <transmission name="old_1">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="joint_1"><hardwareInterface>E</hardwareInterface></joint>
    <actuator name="motor"><mechanicalReduction>7</mechanicalReduction></actuator>
  </transmission>
  <transmission name="of_finger"><joint name="finger"/><actuator name="finger_motor"/></transmission>
</robot>
)";

// The first joint with an offset, the second with a gear of −50 and asymmetric friction.
struct GearedRobot {
  test::TemporaryFolder folder;
  std::filesystem::path urdf = folder.path() / "arms" / "robot.urdf";
  Robot robot;
  Vector chi_st;

  GearedRobot() {
    folder.write("arms/robot.urdf", geared_urdf);
    folder.write("arms/upper.stl", "solid");
    folder.write("arms/upper.dae", "<COLLADA/>");
    robot = read_urdf(urdf, {.base = "base", .tip = "fore"});
    robot.joints[0].friction = Friction::symmetric;
    robot.joints[0].rotor_inertia = true;
    robot.joints[1].friction = Friction::asymmetric;
    robot.joints[1].rotor_inertia = true;
    robot.joints[1].gear_ratio = -50.0;
    chi_st = robot.chi_st();
    set("Ia1", 0.5);
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

  [[nodiscard]] ExportedModel exported(ModelFormat format) const {
    return exported_model(format, urdf, robot, chi_st,
                          {.force = false, .file = urdf.parent_path() / "out.urdf", .origin = "a test"});
  }
};

void expect_holds(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "without\n" << part << "\nis\n" << text;
}

bool is_said(const ExportedModel& model, std::string_view words) {
  return std::ranges::any_of(
      model.warnings, [&](const Finding& warning) { return warning.text.find(words) != std::string::npos; });
}

TEST(ExportedModel, OfMujocoHasADefaultClassForEachJoint) {
  const GearedRobot geared;
  const ExportedModel model = geared.exported(ModelFormat::mjcf);
  const std::string& text = model.files.front().text;
  expect_holds(text, R"(<default class="joint_1">
      <joint armature="0.5" damping="0.25" frictionloss="1.5")");
  expect_holds(text, R"(<default class="a&lt;b">
      <joint armature="0.625" damping="2" frictionloss="6")");
  expect_holds(text, R"(<joint name="joint_1" class="joint_1" axis="0 0 1" range="-1 2" />)");
  expect_holds(text, R"(<motor name="joint_1" joint="joint_1" ctrlrange="-30 30" />)");
  EXPECT_TRUE(is_said(model,
                      "MJCF has no place for off1 = -0.125 N·m, Fv+2 = 1 N·m·s/rad, Fc+2 = 5 N·m, Fv-2 = 3 "
                      "N·m·s/rad, Fc-2 = 7 N·m"));
}

TEST(ExportedModel, OfMujocoKeepsShapesThatItCanRead) {
  const GearedRobot geared;
  const ExportedModel model = geared.exported(ModelFormat::mjcf);
  const std::string& text = model.files.front().text;
  expect_holds(text, R"(file="upper.stl" inertia="shell" scale="2 2 2")");
  expect_holds(text, R"(type="cylinder" size="0.05 0.2" rgba="0 0 1 1")");
  expect_holds(text, R"(type="box" size="0.1 0.1 0.1")");
  EXPECT_TRUE(is_said(model, "mesh \"package://arms/upper.dae\" of link \"upper\" is left out"));
  EXPECT_TRUE(is_said(model, "joint \"finger\" (prismatic) is fixed"));
  expect_holds(text, "is left out");  // in the comment on top
  expect_holds(text, R"(<exclude body1="base" body2="upper" />)");
}

TEST(ExportedModel, HasTheGravityOfTheRobotInTheFrameOfTheRoot) {
  const GearedRobot geared;
  // −z of the base, which the mount turns about y by 90°.
  const std::string text = geared.exported(ModelFormat::sdf).files.front().text;
  const std::size_t at = text.find("<gravity>");
  ASSERT_NE(at, std::string::npos);
  std::istringstream numbers(text.substr(at + 9));
  Eigen::Vector3d gravity;
  numbers >> gravity[0] >> gravity[1] >> gravity[2];
  EXPECT_LT((gravity - Eigen::Vector3d(-9.80665, 0, 0)).norm(), 1e-14);
}

TEST(ExportedModel, OfGazeboMakesFramesOfLinksWithoutABody) {
  const GearedRobot geared;
  const ExportedModel model = geared.exported(ModelFormat::sdf);
  const std::string& text = model.files.front().text;
  expect_holds(text, R"(<frame name="tool0" attached_to="fore">)");
  expect_holds(text, R"(<pose relative_to="tool0">0 0 0 0 0 0</pose>)");
  expect_holds(text, "<drake:rotor_inertia>0.00025</drake:rotor_inertia>");
  EXPECT_EQ(text.find("<joint name=\"flange\""), std::string::npos);
  EXPECT_TRUE(is_said(model, "SDF has no place for Ia1 = 0.5 kg·m², off1 = -0.125 N·m"));
}

TEST(ExportedModel, OfDrakeHasOneTransmissionForEachJoint) {
  const GearedRobot geared;
  const ExportedModel model = geared.exported(ModelFormat::drake);
  const std::string& text = model.files.front().text;
  expect_holds(text, R"(<robot xmlns:drake="http://drake.mit.edu" name="geared">)");
  expect_holds(text, R"(    <actuator name="a&lt;b_motor">
      <drake:rotor_inertia value="0.00025"/>
      <drake:gear_ratio value="-50"/>)");
  expect_holds(text, R"(<drake:rotor_inertia value="0.5"/>)");
  EXPECT_EQ(text.find("old_1"), std::string::npos) << text;
  expect_holds(text, "of_finger");
  ASSERT_EQ(model.files.size(), 2U);
  expect_holds(model.files[1].text, "GRAVITY = [-9.80665, 0, ");
  EXPECT_EQ(model.files[1].text.find("WeldFrames"), std::string::npos) << "the root is the world";
}

TEST(ExportedModel, OfPinocchioHasRotorParametersAndAllFriction) {
  const GearedRobot geared;
  const ExportedModel model = geared.exported(ModelFormat::pinocchio);
  ASSERT_EQ(model.files.size(), 3U);
  expect_holds(model.files[1].text, R"(  <rotor_params>
    <joint name="joint_1" mass="0.5" gear_ratio="1"/>)");
  expect_holds(model.files[1].text, R"(<joint name="a&lt;b" mass="0.00025" gear_ratio="-50"/>)");
  const std::string& module = model.files[2].text;
  expect_holds(module,
               "(0.25, lambda speed, sign: speed, 0), (1.5, lambda speed, sign: sign, 0), "
               "(-0.125, lambda speed, sign: 1.0, 0)");
  expect_holds(module, "(7, lambda speed, sign: sign, -1)");
}

TEST(ExportedModel, OfUrdfSaysInItsCommentWhatAUrdfDoesNotHave) {
  const GearedRobot geared;
  const ExportedModel model = geared.exported(ModelFormat::urdf);
  const std::string& text = model.files.front().text;
  expect_holds(text, "a test.");
  expect_holds(text, "URDF has no place for Ia1 = 0.5 kg·m², off1 = -0.125 N·m, ");
  expect_holds(text, "URDF has no place for gravity, which is [-9.80665");
  // Asymmetric friction is named with minus signs, which a comment may not have two of.
  expect_holds(text, "Fv-2 = 3");
  EXPECT_EQ(parse_urdf(text, "out.urdf", {.base = "base", .tip = "fore"}).size(), 2);
}

TEST(ExportedModel, SaysWhereMeshesAreNamedFrom) {
  GearedRobot geared;
  std::string text = geared_urdf;
  text.replace(text.find("package://arms/upper.stl"), 24, "upper.stl");
  geared.folder.write("arms/robot.urdf", text);
  EXPECT_FALSE(is_said(geared.exported(ModelFormat::urdf), "write the model there"));
  const ExportedModel elsewhere =
      exported_model(ModelFormat::urdf, geared.urdf, geared.robot, geared.chi_st,
                     {.force = false, .file = geared.folder.path() / "out.urdf", .origin = ""});
  EXPECT_TRUE(is_said(elsewhere, "write the model there, with --output"));
}

TEST(ExportedModel, RefusesWhatNoBodyCanBeUnlessForced) {
  GearedRobot geared;
  geared.set("M2", -1.0);
  const ExportedModel refused = geared.exported(ModelFormat::mjcf);
  EXPECT_TRUE(refused.files.empty());
  ASSERT_EQ(refused.faults.size(), 1U);
  EXPECT_NE(refused.faults.front().text.find("its mass is -1 kg, must be positive"), std::string::npos);
}

TEST(ExportedModel, RefusesANegativeRotorInertia) {
  GearedRobot geared;
  geared.set("Ia1", -0.5);
  EXPECT_EQ(geared.exported(ModelFormat::mjcf).faults.size(), 1U);
  EXPECT_TRUE(geared.exported(ModelFormat::mjcf).files.empty());
}

TEST(ExportedModel, HasANameBesideTheUrdfWhereNoneIsGiven) {
  const GearedRobot geared;
  const auto first = [&](ModelFormat format) {
    return exported_model(format, geared.urdf, geared.robot, geared.chi_st, {}).files.at(0).path;
  };
  const std::filesystem::path folder = geared.urdf.parent_path();
  EXPECT_EQ(first(ModelFormat::urdf), folder / "robot_identified.urdf");
  EXPECT_EQ(first(ModelFormat::mjcf), folder / "robot_identified.xml");
  EXPECT_EQ(first(ModelFormat::pinocchio), folder / "robot_identified_pinocchio.urdf");
}

}  // namespace
}  // namespace rivid
