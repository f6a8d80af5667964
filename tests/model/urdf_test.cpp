#include "rivid/model/urdf.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <string>

#include "rivid/error.hpp"
#include "support/chain_dynamics.hpp"
#include "support/complaint.hpp"
#include "support/temporary_file.hpp"

namespace rivid {
namespace {

constexpr double same_quantity = 1e-12;
constexpr double infinity = std::numeric_limits<double>::infinity();

// An arm of two links, as text in which a test replaces what it is about. <robot> is line 1.
constexpr std::string_view arm = R"(<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.1 0.2 0.3" rpy="0 0 0"/>
      <mass value="2"/>
      <inertia ixx="0.4" ixy="0.01" ixz="0.02" iyy="0.5" iyz="0.03" izz="0.6"/>
    </inertial>
  </link>
  <link name="lower">
    <inertial>
      <mass value="1"/>
      <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/>
    </inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/>
    <child link="upper"/>
    <axis xyz="0 0 1"/>
    <limit lower="-1" upper="2" velocity="3" effort="4"/>
  </joint>
  <joint name="elbow" type="revolute">
    <origin xyz="0 0 1" rpy="0 0 0"/>
    <parent link="upper"/>
    <child link="lower"/>
    <axis xyz="0 -1 0"/>
    <limit lower="-1" upper="2" velocity="3" effort="4"/>
    <dynamics damping="0.5" friction="0.25"/>
  </joint>
</robot>
)";

// The arm with the first `from` replaced.
std::string arm_with(std::string_view from, std::string_view to, std::string_view text = arm) {
  std::string out(text);
  const std::size_t place = out.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  out.replace(place, from.size(), to);
  return out;
}

std::string arm_and(std::string_view more) { return arm_with("</robot>", std::string(more) + "</robot>"); }

// The message of the refusal; urdfdom must not have had its say as well.
std::string refusal(std::string_view xml, const UrdfOptions& options = {}) {
  testing::internal::CaptureStderr();
  std::string message = "accepted";
  try {
    (void)parse_urdf(xml, "arm.urdf", options);
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  return message;
}

// The arm with one text replaced, and what is said of it.
struct Spoiled {
  std::string_view from;
  std::string_view to;
  std::string_view refusal;
};

void expect_refused(std::initializer_list<Spoiled> cases) {
  for (const Spoiled& spoiled : cases) {
    EXPECT_EQ(refusal(arm_with(spoiled.from, spoiled.to)), spoiled.refusal);
  }
}

std::vector<std::string> texts(const Robot& robot) {
  std::vector<std::string> out;
  for (const Finding& doubt : robot.warnings) {
    EXPECT_EQ(doubt.code, "robot_doubt");
    out.push_back(doubt.text);
  }
  return out;
}

std::vector<std::string> warnings(std::string_view xml, const UrdfOptions& options = {}) {
  testing::internal::CaptureStderr();
  const Robot robot = parse_urdf(xml, "arm.urdf", options);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(robot.complaint(), std::nullopt);
  return texts(robot);
}

using Strings = std::vector<std::string>;

TEST(ReadUrdf, TellsGeometryLimitsFrictionAndInertials) {
  const Robot robot = parse_urdf(arm, "arm.urdf", {.base = {}, .tip = {}, .gravity = {0.0, -9.0, 0.0}});
  EXPECT_EQ(robot.name, "arm");
  EXPECT_EQ(robot.base, "base");
  EXPECT_EQ(texts(robot), Strings());
  EXPECT_EQ(robot.chain.gravity, Eigen::Vector3d(0.0, -9.0, 0.0));
  ASSERT_EQ(robot.size(), 2);
  const Joint& elbow = robot.joints[1];
  EXPECT_EQ(elbow.name, "elbow");
  EXPECT_EQ(elbow.link, "lower");
  EXPECT_EQ(elbow.lower, -1.0);
  EXPECT_EQ(elbow.upper, 2.0);
  EXPECT_EQ(elbow.max_velocity, 3.0);
  EXPECT_EQ(elbow.max_effort, 4.0);
  EXPECT_EQ(elbow.Fv, 0.5);
  EXPECT_EQ(elbow.Fc, 0.25);
  EXPECT_EQ(robot.chain.links[1].p, Eigen::Vector3d(0.0, 0.0, 1.0));
  EXPECT_EQ(link_axes(robot.chain.links[1]).col(2), -Eigen::Vector3d::UnitY());
  const Inertial upper = inertial_from_com(
      2.0, {0.1, 0.2, 0.3}, Eigen::Matrix3d{{0.4, 0.01, 0.02}, {0.01, 0.5, 0.03}, {0.02, 0.03, 0.6}});
  EXPECT_TRUE(robot.inertials[0].isApprox(upper, same_quantity));
}

TEST(ReadUrdf, TurnsAnInertialIntoTheAxesOfItsLink) {
  const std::string turned = arm_with(R"(rpy="0 0 0"/>
      <mass value="2"/>)",
                                      R"(rpy="0.3 -0.4 0.5"/>
      <mass value="2"/>)");
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.4, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  const Eigen::Matrix3d I{{0.4, 0.01, 0.02}, {0.01, 0.5, 0.03}, {0.02, 0.03, 0.6}};
  const Inertial wanted = inertial_from_com(2.0, {0.1, 0.2, 0.3}, R * I * R.transpose());
  EXPECT_TRUE(parse_urdf(turned, "arm.urdf").inertials[0].isApprox(wanted, same_quantity));
}

TEST(ReadUrdf, ReadsNumbersAsXmlDoesWhateverTheLocale) {
  const std::string odd = arm_with(R"(xyz="0 0 1")", "xyz=\" +0\t0.0\n 1e0 \"");
  const char* const german = std::setlocale(LC_NUMERIC, "de_DE.UTF-8");  // where it is installed
  EXPECT_EQ(parse_urdf(odd, "arm.urdf").chain.links[1].p, Eigen::Vector3d(0.0, 0.0, 1.0));
  if (german != nullptr) {
    std::setlocale(LC_NUMERIC, "C");
  }
}

TEST(ReadUrdf, TakesContinuousAndPrismaticJoints) {
  const Robot robot = parse_urdf(arm_with("\"elbow\" type=\"revolute\"", "\"elbow\" type=\"prismatic\"",
                                          arm_with("type=\"revolute\"", "type=\"continuous\"")),
                                 "arm.urdf");
  EXPECT_EQ(robot.joints[0].type, JointType::revolute);
  EXPECT_EQ(robot.joints[0].upper, infinity);
  EXPECT_EQ(robot.joints[0].max_effort, 4.0);
  EXPECT_EQ(robot.joints[1].type, JointType::prismatic);
  EXPECT_EQ(robot.joints[1].upper, 2.0);
}

TEST(ReadUrdf, LooksAtNothingThatIsNeitherLinkNorJoint) {
  const Strings none;
  EXPECT_EQ(warnings(arm_and("<material name='m'/><gazebo><nonsense/></gazebo><ros2_control/>")), none);
  EXPECT_EQ(warnings(arm_with("<link name=\"base\"/>",
                              "<link name=\"base\"><visual><geometry><mesh/></geometry></visual></link>")),
            none);
  EXPECT_EQ(warnings(arm_with("<robot ", "<robot version=\"7\" xmlns:xacro=\"http://ros.org/wiki/xacro\" ")),
            none);
}

TEST(ReadUrdf, GivesTheSameRobotSplitByFixedJointsAsMerged) {
  // The upper link in two pieces, and the lower one with a tool on it.
  const std::string split = arm_with("<parent link=\"upper\"/>", "<parent link=\"upper_end\"/>",
                                     arm_with("<origin xyz=\"0 0 1\" rpy=\"0 0 0\"/>",
                                              "<origin xyz=\"0 0 0.25\" rpy=\"0 0 -0.5\"/>", arm_and(R"(
        <link name="upper_end"><inertial><origin xyz="0.1 0 0"/><mass value="3"/>
          <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.2"/></inertial></link>
        <joint name="weld" type="fixed"><origin xyz="0 0 0.75" rpy="0 0 0.5"/>
          <parent link="upper"/><child link="upper_end"/></joint>
        <link name="tool"><inertial><mass value="5"/>
          <inertia ixx="0.3" ixy="0" ixz="0" iyy="0.3" iyz="0" izz="0.3"/></inertial></link>
        <joint name="flange" type="fixed"><origin xyz="0 0.5 0"/><parent link="lower"/><child link="tool"/></joint>)")));
  const Robot robot = parse_urdf(split, "arm.urdf");
  EXPECT_EQ(texts(robot), Strings());

  Robot merged = parse_urdf(arm, "arm.urdf");
  const double c = std::cos(0.5);
  const double s = std::sin(0.5);
  merged.inertials[0] += inertial_from_com(3.0, {0.1 * c, 0.1 * s, 0.75}, 0.2 * Eigen::Matrix3d::Identity());
  merged.inertials[1] += inertial_from_com(5.0, {0.0, 0.5, 0.0}, 0.3 * Eigen::Matrix3d::Identity());
  ASSERT_EQ(robot.size(), 2);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_TRUE(robot.inertials[j].isApprox(merged.inertials[j], same_quantity)) << j;
    EXPECT_TRUE(robot.chain.links[j].p.isApprox(merged.chain.links[j].p, same_quantity)) << j;
    EXPECT_TRUE(robot.chain.links[j].R.isApprox(merged.chain.links[j].R, same_quantity)) << j;
  }
}

constexpr std::string_view gripper = R"(
  <link name="finger"><inertial><mass value="0.5"/>
    <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
  <joint name="grip" type="prismatic"><origin xyz="0 0 0.2"/><parent link="lower"/><child link="finger"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.1" velocity="1" effort="1"/></joint>
  <link name="thumb"/>
  <joint name="grip_2" type="prismatic"><parent link="lower"/><child link="thumb"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.1" velocity="1" effort="1"/><mimic joint="grip"/></joint>)";

TEST(ReadUrdf, LumpsMovingBranchesAtZeroAndSaysSo) {
  const Robot robot = parse_urdf(arm_and(gripper), "arm.urdf", {.base = {}, .tip = "lower"});
  const Robot bare = parse_urdf(arm, "arm.urdf");
  const Inertial finger = inertial_from_com(0.5, {0.0, 0.0, 0.2}, Eigen::Matrix3d::Zero());
  EXPECT_TRUE(robot.inertials[1].isApprox(bare.inertials[1] + finger, same_quantity));
  EXPECT_EQ(texts(robot),
            (Strings{"arm.urdf:33: 2 joints are no part of the robot: \"grip\", \"grip_2\" (mimic); held at "
                     "q = 0, what they move is lumped into link \"lower\""}));
}

TEST(ReadUrdf, EndsAtTheLastMovingLinkThoughFixedFramesFollow) {
  const Robot robot = parse_urdf(arm_and(R"(
    <link name="flange"/><joint name="f" type="fixed"><parent link="lower"/><child link="flange"/></joint>
    <link name="tool0"/><joint name="t" type="fixed"><parent link="flange"/><child link="tool0"/></joint>
    <link name="camera"/><joint name="c" type="fixed"><parent link="upper"/><child link="camera"/></joint>)"),
                                 "arm.urdf");
  EXPECT_EQ(robot.size(), 2);
  EXPECT_EQ(texts(robot), Strings());
}

TEST(ReadUrdf, CutsTheChainOutOfTheTree) {
  const Robot robot = parse_urdf(arm, "arm.urdf", {.base = "upper", .tip = "lower"});
  ASSERT_EQ(robot.size(), 1);
  EXPECT_EQ(robot.base, "upper");
  EXPECT_EQ(robot.joints[0].name, "elbow");
  EXPECT_EQ(texts(robot),
            Strings{"arm.urdf:4: link \"upper\": its <inertial> has no effect, since the base stands still"});
}

TEST(ReadUrdf, RefusesAMissingFileADirectoryAndAnEmptyFile) {
  const auto read = [](const std::filesystem::path& path) -> std::string {
    return test::complaint_of([&] { return read_urdf(path); });
  };
  EXPECT_EQ(read("no_such.urdf"), "no_such.urdf: there is no such file");
  EXPECT_EQ(read("."), ".: is a directory, a file is required");
  EXPECT_EQ(refusal(""), "arm.urdf: is empty, must be a URDF");
  EXPECT_EQ(refusal(" \n "), "arm.urdf: is empty, must be a URDF");
}

TEST(ReadUrdf, ReadsAFileAsTheSameTextIsRead) {
  const test::TemporaryFile file(arm, "arm.urdf");
  EXPECT_EQ(read_urdf(file.path()).chi_st(), parse_urdf(arm, "arm.urdf").chi_st());
}

TEST(ReadUrdf, RefusesMalformedXmlWithItsLine) {
  EXPECT_EQ(refusal("no XML at all"), "arm.urdf: is not XML, must be a URDF");
  EXPECT_EQ(refusal(arm_with("</link>\n  <joint", "\n  <joint")),
            "arm.urdf:30: not well-formed XML: Start-end tags mismatch");
  EXPECT_EQ(refusal(arm.substr(0, 200)), "arm.urdf:7: not well-formed XML: Error parsing element attribute");
  EXPECT_EQ(refusal(arm_with("mass value=\"2\"", "mass value=\"2\" value=\"3\"")),
            "arm.urdf:6: not well-formed XML: <mass> has two attributes value");
  EXPECT_EQ(refusal(std::string(arm).append("<robot/>")),
            "arm.urdf:31: not well-formed XML: <robot> follows the end of <robot>");
}

TEST(ReadUrdf, RefusesWhatIsNoUrdf) {
  EXPECT_EQ(refusal("<?xml version=\"1.0\"?>\n<model/>"),
            "arm.urdf:2: is not a URDF: the outermost element is <model>, must be <robot>");
  EXPECT_EQ(
      refusal("<sdf/>"),
      "arm.urdf:1: is not a URDF: the outermost element is <sdf>, must be <robot>; convert the SDF to a URDF "
      "first");
  EXPECT_EQ(refusal("<robot name=\"r\"/>"), "arm.urdf:1: the robot has no <link>");
  EXPECT_EQ(refusal("<robot name=\"r\"><link name=\"a\"/></robot>"),
            "arm.urdf:1: no joint moves behind link \"a\"");
}

TEST(ReadUrdf, RefusesXacroAndTellsHowToExpandIt) {
  const std::string advice = "; this is a xacro file, expand it first: xacro in.xacro > out.urdf";
  EXPECT_EQ(refusal(arm_with("<link name=\"base\"/>", "<xacro:include filename=\"a\"/>")),
            "arm.urdf:2: <xacro:include> is not URDF" + advice);
  EXPECT_EQ(refusal(arm_with("mass value=\"2\"", "mass value=\"${m}\"")),
            "arm.urdf:6: <mass value=\"${m}\"> holds an expression" + advice);
  EXPECT_EQ(refusal(arm_with("name=\"arm\"", "name=\"$(arg name)\"")),
            "arm.urdf:1: <robot name=\"$(arg name)\"> holds an expression" + advice);
}

TEST(ReadUrdf, RefusesWhatIsNoNumber) {
  for (const std::string bad : {"1,5", "nan", "inf", "-inf", "", "2 kg", "0x10", "1e999", "+-1"}) {
    EXPECT_EQ(
        refusal(arm_with("mass value=\"2\"", "mass value=\"" + bad + "\"")),
        "arm.urdf:6: link \"upper\": <mass value=\"" + bad + "\"> must be a finite number, such as 1.5e-3");
  }
  EXPECT_EQ(refusal(arm_with("izz=\"0.6\"", "izz=\"abc\"")),
            "arm.urdf:7: link \"upper\": <inertia izz=\"abc\"> must be a finite number, such as 1.5e-3");
  for (const std::string bad : {"0 0", "0 0 1 2", "", "0, 0, 1", "0 0 nan"}) {
    EXPECT_EQ(refusal(arm_with("xyz=\"0 0 1\" rpy", "xyz=\"" + bad + "\" rpy")),
              "arm.urdf:23: joint \"elbow\": <origin xyz=\"" + bad +
                  "\"> must be three finite numbers with blanks between them, such as \"0 0 1.5e-3\"");
  }
  EXPECT_EQ(
      refusal(arm_with("damping=\"0.5\"", "damping=\"some\"")),
      "arm.urdf:28: joint \"elbow\": <dynamics damping=\"some\"> must be a finite number, such as 1.5e-3");
  EXPECT_EQ(refusal(arm_with("rpy=\"0 0 0\"", "quat_xyzw=\"0 0 0 1\"")),
            "arm.urdf:5: link \"upper\": <origin> has quat_xyzw, which is not supported; write the rotation "
            "as rpy");
}

TEST(ReadUrdf, RefusesInertialsThatAreIncomplete) {
  EXPECT_EQ(refusal(arm_with(" izz=\"0.6\"", "")), "arm.urdf:7: link \"upper\": <inertia> has no izz");
  EXPECT_EQ(refusal(arm_with("mass value", "mass")),
            "arm.urdf:6: not well-formed XML: Error parsing start element tag");
  EXPECT_EQ(refusal(arm_with("<mass value=\"2\"/>", "<mass/>")),
            "arm.urdf:6: link \"upper\": <mass> has no value");
  EXPECT_EQ(refusal(arm_with("<mass value=\"2\"/>", "")),
            "arm.urdf:4: link \"upper\": its <inertial> has no <mass>");
  EXPECT_EQ(refusal(arm_with("<mass value=\"2\"/>", "<mass value=\"2\"/><mass value=\"3\"/>")),
            "arm.urdf:6: link \"upper\": has a second <mass>, must have one at most");
}

TEST(ReadUrdf, RefusesInertialsThatNothingHas) {
  EXPECT_EQ(refusal(arm_with("mass value=\"2\"", "mass value=\"-1\"")),
            "arm.urdf:6: link \"upper\": mass is -1 kg, must not be negative");
  EXPECT_EQ(
      refusal(arm_with("mass value=\"2\"", "mass value=\"0\"")),
      "arm.urdf:7: link \"upper\": mass is 0 kg, but its inertia is not zero; a body without mass has none");
  EXPECT_EQ(
      refusal(arm_with("iyy=\"0.1\"", "iyy=\"-0.1\"")),
      "arm.urdf:13: link \"lower\": its inertia is not positive semidefinite: principal moments -0.1, 0.1, "
      "0.1 kg·m²");
}

TEST(ReadUrdf, WarnsOfAnImpossibleBodyThatDoesNotMoveWithTheChain) {
  constexpr std::string_view antenna = R"(
  <link name="antenna"><inertial><mass value="0.001"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="-0.5" iyz="0" izz="1"/></inertial></link>
  <joint name="mast" type="fixed"><parent link="base"/><child link="antenna"/></joint>)";
  const Robot robot = parse_urdf(arm_and(antenna), "arm.urdf", {.base = {}, .tip = "lower"});
  EXPECT_EQ(
      texts(robot),
      (Strings{"arm.urdf:32: link \"antenna\": its inertia is not positive semidefinite: principal moments "
               "-0.5, 1, 1 kg·m²; the link does not move with the robot, its <inertial> has no effect"}));
  const Robot bare = parse_urdf(arm, "arm.urdf");
  EXPECT_EQ(robot.inertials[0], bare.inertials[0]);
  EXPECT_EQ(robot.inertials[1], bare.inertials[1]);
}

TEST(ReadUrdf, WarnsOfAnInertiaThatBreaksTheTriangleInequality) {
  EXPECT_EQ(warnings(arm_with("iyy=\"0.1\"", "iyy=\"0.3\"")),
            Strings{"arm.urdf:13: link \"lower\": its inertia is physically inconsistent: of the principal "
                    "moments 0.1, 0.1, 0.3 "
                    "kg·m² the largest must not exceed the sum of the others"});
}

TEST(ReadUrdf, RefusesAnAxisThatIsNone) {
  EXPECT_EQ(refusal(arm_with("axis xyz=\"0 0 1\"", "axis xyz=\"0 0 0\"")),
            "arm.urdf:19: joint \"shoulder\": its axis is \"0 0 0\", must not be zero");
  EXPECT_EQ(
      refusal(arm_with("axis xyz=\"0 0 1\"", "axis xyz=\"0 1\"")),
      "arm.urdf:19: joint \"shoulder\": <axis xyz=\"0 1\"> must be three finite numbers with blanks between "
      "them, such as \"0 0 1.5e-3\"");
  EXPECT_EQ(refusal(arm_with("axis xyz=\"0 0 1\"", "axis")),
            "arm.urdf:19: joint \"shoulder\": <axis> has no xyz");
}

TEST(ReadUrdf, TakesAnAxisOfAnyLengthAsADirection) {
  const Robot robot = parse_urdf(arm_with("axis xyz=\"0 0 1\"", "axis xyz=\"0 0 -1e200\""), "arm.urdf");
  EXPECT_EQ(robot.chain.links[0].R.col(2), -Eigen::Vector3d::UnitZ());
  EXPECT_EQ(texts(robot),
            Strings{"arm.urdf:19: joint \"shoulder\": its axis \"0 0 -1e200\" has the length 1e+200; "
                    "taken as a direction"});
  EXPECT_EQ(warnings(arm_with("axis xyz=\"0 0 1\"", "axis xyz=\"0 0 0.9999\"")), Strings());
}

TEST(ReadUrdf, WarnsOfAnObliqueAxisAndTellsTheParametersAboutIt) {
  const Robot robot = parse_urdf(arm_with("axis xyz=\"0 0 1\"", "axis xyz=\"0.6 0 0.8\""), "arm.urdf");
  EXPECT_EQ(
      texts(robot),
      Strings{"arm.urdf: joint \"shoulder\": its axis (0.6, 0, 0.8) is oblique in the link frame; the "
              "parameters of its link are given in a frame with the same origin that is turned to have z "
              "along the axis"});
  const Eigen::Matrix3d R = robot.chain.links[0].R;
  const Inertial wanted =
      transformed(parse_urdf(arm, "arm.urdf").inertials[0], R.transpose(), {0.0, 0.0, 0.0});
  EXPECT_TRUE(robot.inertials[0].isApprox(wanted, same_quantity));
}

TEST(ReadUrdf, TakesXAsTheAxisThatIsNotTold) {
  const Robot robot = parse_urdf(arm_with("<axis xyz=\"0 0 1\"/>", ""), "arm.urdf");
  EXPECT_EQ(robot.chain.links[0].R.col(2), Eigen::Vector3d::UnitX());
}

TEST(ReadUrdf, RefusesJointsOfTheChainThatMoveInOtherWays) {
  for (const std::string type : {"floating", "planar"}) {
    EXPECT_EQ(refusal(arm_with("\"elbow\" type=\"revolute\"", "\"elbow\" type=\"" + type + "\"")),
              "arm.urdf:22: joint \"elbow\": is of type " + type +
                  "; only revolute, continuous, prismatic and fixed joints can be identified");
  }
}

TEST(ReadUrdf, RefusesJointsThatAreIncomplete) {
  expect_refused(
      {{"\"elbow\" type=\"revolute\"", "\"elbow\" type=\"rotary\"",
        "arm.urdf:22: joint \"elbow\": type is \"rotary\", must be one of revolute, continuous, prismatic, "
        "fixed, floating, planar"},
       {"\"elbow\" type=\"revolute\"", "\"elbow\"", "arm.urdf:22: joint \"elbow\": <joint> has no type"},
       {"<joint name=\"elbow\"", "<joint", "arm.urdf:22: a joint: <joint> has no name"},
       {"<parent link=\"upper\"/>", "", "arm.urdf:22: joint \"elbow\": has no <parent>"}});
}

TEST(ReadUrdf, RefusesLinksAndJointsThatMakeNoTree) {
  expect_refused(
      {{"<link name=\"lower\"", "<link name=\"upper\"",
        "arm.urdf:10: two links are called \"upper\"; names must differ"},
       {"<joint name=\"elbow\"", "<joint name=\"shoulder\"",
        "arm.urdf:22: two joints are called \"shoulder\"; names must differ"},
       {"<parent link=\"upper\"/>", "<parent link=\"Uper\"/>",
        "arm.urdf:24: joint \"elbow\": its parent link \"Uper\" does not exist; did you mean \"upper\"?"},
       {"<child link=\"lower\"/>", "<child link=\"xyz\"/>",
        "arm.urdf:25: joint \"elbow\": its child link \"xyz\" does not exist"},
       {"<child link=\"lower\"/>", "<child link=\"upper\"/>",
        "arm.urdf:22: joint \"elbow\": its child link \"upper\" is already the child of joint \"shoulder\"; "
        "a "
        "link must have one parent"}});
  EXPECT_EQ(
      refusal(arm_and("<link name=\"island\"/>")),
      "arm.urdf:1: the links make 2 separate trees, with the roots \"base\" and \"island\"; a URDF must have "
      "one root");
  expect_refused({{"<parent link=\"base\"/>", "<parent link=\"lower\"/>",
                   "arm.urdf:3: link \"upper\": its joints lead round in a cycle and to no root"}});
}

TEST(ReadUrdf, RefusesLimitsTheWrongWayRound) {
  expect_refused({{"upper=\"2\"", "upper=\"-2\"",
                   "arm.urdf:20: joint \"shoulder\": its lower limit -1 is above its upper limit -2"},
                  {"effort=\"4\"", "effort=\"-4\"",
                   "arm.urdf:20: joint \"shoulder\": its effort limit is -4, must not be negative"},
                  {"friction=\"0.25\"", "friction=\"-0.25\"",
                   "arm.urdf:28: joint \"elbow\": its friction is -0.25, must not be negative"}});
}

TEST(ReadUrdf, WarnsOfLimitsThatAreNotTold) {
  const std::string limit = "<limit lower=\"-1\" upper=\"2\" velocity=\"3\" effort=\"4\"/>";
  EXPECT_EQ(warnings(arm_with(limit, "")),
            Strings{"arm.urdf:16: joint \"shoulder\": has no <limit>; taken as unlimited"});
  EXPECT_EQ(warnings(arm_with(limit, "<limit lower=\"0\" upper=\"0\" velocity=\"0\"/>")),
            (Strings{"arm.urdf:20: joint \"shoulder\": its velocity limit is 0; taken as unlimited",
                     "arm.urdf:20: joint \"shoulder\": its effort limit is not given; taken as unlimited",
                     "arm.urdf:20: joint \"shoulder\": its position limits are both 0; taken as unlimited"}));
  const Robot robot = parse_urdf(arm_with(limit, ""), "arm.urdf");
  EXPECT_EQ(robot.joints[0].lower, -infinity);
  EXPECT_EQ(robot.joints[0].upper, infinity);
  EXPECT_EQ(robot.joints[0].max_velocity, infinity);
  EXPECT_EQ(robot.joints[0].max_effort, infinity);
}

TEST(ReadUrdf, WarnsOfAMovingLinkWithoutInertial) {
  const std::string bare = R"(<robot name="r"><link name="a"/>
    <link name="b"/>
    <joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>)";
  EXPECT_EQ(warnings(bare),
            Strings{"arm.urdf:2: link \"b\": has no <inertial>; its a-priori inertial parameters are zero"});
}

TEST(ReadUrdf, WarnsOfTransmissions) {
  EXPECT_EQ(
      warnings(arm_and("<transmission name=\"t\"/>\n<transmission name=\"u\"/>")),
      Strings{"arm.urdf:30: <transmission> is ignored; state the drives as drive_gain and gear_ratio of the "
              "joints"});
}

// A second arm on the first one's base and a hand on the first one's end, in one file.
constexpr std::string_view other_arm = R"(
  <link name="other"><inertial><origin xyz="0.1 0 0"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <joint name="swing" type="revolute"><origin xyz="0 0.3 0"/><parent link="base"/><child link="other"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>)";

Strings names(const Robot& robot) {
  Strings out;
  for (const Joint& joint : robot.joints) {
    out.push_back(joint.name);
  }
  return out;
}

TEST(ReadUrdf, TakesARobotThatBranchesAsATreeInTheOrderOfTheFile) {
  const Robot robot = parse_urdf(arm_and(std::string(gripper) + std::string(other_arm)), "arm.urdf");
  EXPECT_EQ(names(robot), (Strings{"shoulder", "elbow", "grip", "swing"}));
  // The last one is that of "grip_2", which follows "grip".
  EXPECT_EQ(robot.chain.parents, (std::vector<int>{-1, 0, 1, -1, 1}));
  EXPECT_TRUE(robot.chain.branches());
  EXPECT_EQ(
      texts(robot),
      (Strings{"arm.urdf:35: link \"thumb\": has no <inertial>; its a-priori inertial parameters are zero"}));
  // Each branch is the chain that its tip names.
  const Robot hand = parse_urdf(arm_and(gripper), "arm.urdf", {.base = {}, .tip = "finger"});
  const Robot other = parse_urdf(arm_and(other_arm), "arm.urdf", {.base = {}, .tip = "other"});
  for (std::size_t j = 0; j < 4; ++j) {
    const Robot& chain = j < 3 ? hand : other;
    const std::size_t k = j < 3 ? j : 0;
    EXPECT_EQ(robot.chain.links[j].R, chain.chain.links[k].R) << j;
    EXPECT_EQ(robot.chain.links[j].p, chain.chain.links[k].p) << j;
    EXPECT_EQ(robot.inertials[j], chain.inertials[k]) << j;
  }
}

TEST(ReadUrdf, HoldsTheJointsThatAreNotNamedAsMoving) {
  const std::string both = arm_and(std::string(gripper) + std::string(other_arm));
  const Robot robot = parse_urdf(both, "arm.urdf", {.base = {}, .tip = {}, .moving = {"swing", "elbow"}});
  EXPECT_EQ(names(robot), (Strings{"elbow", "swing"}));
  EXPECT_EQ(robot.chain.parents, (std::vector<int>{-1, -1}));
  ASSERT_EQ(robot.warnings.size(), 2U);
  EXPECT_TRUE(test::says(texts(robot)[0],
                         "joint \"shoulder\": lies on the way to joints of the robot but is none "
                         "of them; held at q = 0"));
  // The same by a chain whose base is the held link.
  const Robot elbow = parse_urdf(arm_and(gripper), "arm.urdf", {.base = "upper", .tip = "lower"});
  EXPECT_TRUE(robot.inertials[0].isApprox(elbow.inertials[0], same_quantity));

  EXPECT_EQ(refusal(both, {.base = {}, .tip = "lower", .moving = {"elbow"}}),
            "arm.urdf: both tip and moving are given, must be one of them");
  EXPECT_EQ(refusal(both, {.base = {}, .tip = {}, .moving = {"elbo"}}),
            "arm.urdf: moving names \"elbo\", but no joint is called so; did you mean \"elbow\"?");
  EXPECT_EQ(refusal(both, {.base = "upper", .tip = {}, .moving = {"swing"}}),
            "arm.urdf: base \"upper\" does not carry joint \"swing\"");
}

TEST(ReadUrdf, RefusesABaseOrTipThatDoesNotFit) {
  EXPECT_EQ(refusal(arm, {.base = "bas", .tip = {}}),
            "arm.urdf: base is \"bas\", but no link is called so; did you mean \"base\"? (links: \"base\", "
            "\"upper\" "
            "and \"lower\")");
  EXPECT_EQ(refusal(arm, {.base = {}, .tip = "hand"}),
            "arm.urdf: tip is \"hand\", but no link is called so (links: \"base\", \"upper\" and \"lower\")");
  EXPECT_EQ(
      refusal(arm, {.base = "lower", .tip = "upper"}),
      "arm.urdf: base \"lower\" does not carry tip \"upper\"; the way to the tip is \"base\" and \"upper\"");
  EXPECT_EQ(refusal(arm, {.base = "base", .tip = "base"}),
            "arm.urdf: no joint moves between base \"base\" and tip \"base\"");
  EXPECT_EQ(refusal(arm, {.base = "lower", .tip = {}}), "arm.urdf:1: no joint moves behind link \"lower\"");
}

TEST(ReadUrdf, SurvivesNestingDeeperThanTheStack) {
  std::string deep;
  for (int i = 0; i < 200000; ++i) {
    deep += "<a>";
  }
  for (int i = 0; i < 200000; ++i) {
    deep += "</a>";
  }
  EXPECT_EQ(warnings(arm_and("<gazebo>" + deep + "</gazebo>")), Strings());
}

}  // namespace
}  // namespace rivid
