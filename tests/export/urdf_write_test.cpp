#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>
#include <sstream>

#include "rivid/export/urdf.hpp"
#include "rivid/model/mdh.hpp"
#include "support/complaint.hpp"
#include "support/process.hpp"
#include "support/temporary_folder.hpp"
#include "support/written_urdf.hpp"

namespace rivid {
namespace {

// Fixed joints before, between and behind the moving ones, a branch with a moving joint, oblique and negative
// axes, inertials with rpy, links without any.
constexpr const char* tree = R"(<?xml version="1.0"?>
<!-- a comment > with <inertial> in it -->
<robot name="tree" xmlns:x="http://example.org">
  <link name="world"/>
  <joint name="stand" type="fixed">
    <parent link="world"/><child link="base"/><origin xyz="0 0 0.1" rpy="0.1 0.2 0.3"/>
  </joint>
  <link name="base"><inertial><mass value="9"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="a" type="revolute">
    <parent link="base"/>
    <child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0.4 -0.2 1.1"/>
    <axis xyz="1 2 -0.5"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/>
    <dynamics friction='0.5' damping="0.25"/>
  </joint>
  <link name="upper">
    <visual><geometry><mesh filename="package://arm/upper.stl"/></geometry></visual>
    <inertial>
      <mass value="4.0"/>   <!-- weighed -->
      <origin rpy="0.3 -0.1 0.7" xyz="0.02   0.01 0.1"/>
      <inertia ixx="0.05" ixy="0.001" ixz="-0.002" iyy="0.06" iyz="0" izz="0.03"/>
    </inertial>
  </link>
  <joint name="bracket" type="fixed">
    <parent link="upper"/>
    <child link="plate"/>
    <origin xyz="0.1 0 0.2" rpy="0 0.5 0"/>
  </joint>
  <link name="plate">
    <inertial>
      <origin xyz="0.01 0 0" rpy="0 0 0"/>
      <mass value="0.05"/>
      <inertia ixx="0.0001" ixy="0" ixz="0" iyy="0.0001" iyz="0" izz="0.0001"/>
    </inertial>
  </link>
  <joint name="b" type="prismatic">
    <parent link="plate"/>
    <child link="carriage"/>
    <origin xyz="0 0.2 0.1"/>
    <axis xyz="0 -1 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="2"/>
  </joint>
  <link name="carriage"/>
  <joint name="finger_joint" type="prismatic">
    <parent link="carriage"/>
    <child link="finger"/>
    <origin xyz="0 0 0.05"/>
    <axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" effort="10" velocity="2"/>
  </joint>
  <link name="finger">
    <inertial>
      <mass value="0.02"/>
      <inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/>
    </inertial>
  </link>
  <joint name="c" type="continuous">
    <parent link="carriage"/>
    <child link="wrist"/>
    <origin xyz="0 0 0.2" rpy="1.5707963267948966 0 0"/>
    <axis xyz="0 0 1"/>
    <dynamics damping="0.1"/>
  </joint>
  <link name="wrist">
    <inertial>
      <origin xyz="0 0 0"/>
      <mass value="1"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>
  </link>
  <joint name="flange" type="fixed">
    <parent link="wrist"/>
    <child link="tool"/>
    <origin xyz="0 0 0.1"/>
  </joint>
  <link name="tool">
    <inertial>
      <origin xyz="0 0 0.05"/>
      <mass value="0.3"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/>
    </inertial>
  </link>
</robot>
)";

const UrdfOptions of_wrist = {.base = "", .tip = "wrist"};

Robot tree_robot() { return parse_urdf(tree, "tree.urdf", of_wrist); }

Index place(const Robot& robot, std::string_view name) {
  const auto parameters = robot.standard_parameters();
  const auto at = std::ranges::find(parameters, name, &StandardParameter::name);
  EXPECT_NE(at, parameters.end()) << name;
  return at - parameters.begin();
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(RewrittenUrdf, ReadBackGivesTheSameTorques) {
  const Robot robot = tree_robot();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const Vector chi_st = test::random_urdf_parameters(robot, random);
    const RewrittenUrdf written = rewritten_urdf(tree, "tree.urdf", robot, chi_st);
    EXPECT_TRUE(written.faults.empty()) << written.faults.front().text;
    test::expect_same_torques(written.text, robot, chi_st, random);
  }
}

// Bodies by a rule, no friction.
Vector bodies_by_a_rule(const Robot& robot) {
  Vector chi_st = Vector::Zero(robot.chi_st().size());
  for (int j = 0; j < 3; ++j) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.3 + 0.5 * j, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
    const Eigen::Vector3d moments(0.03 + 0.01 * j, 0.05, 0.04);
    chi_st.segment<10>(place(robot, "XX" + std::to_string(j + 1))) = inertial_from_com(
        3.0 - 0.75 * j, {0.1 - 0.05 * j, 0.02, 0.03 * j}, turn * moments.asDiagonal() * turn.transpose());
  }
  return chi_st;
}

// urdf_write_oracle.py reads that URDF with Pinocchio.
TEST(RewrittenUrdf, GivesTheTorquesThatPinocchioReadsFromIt) {
  const std::filesystem::path folder = std::filesystem::path(RIVID_TEST_DATA) / "export";
  const Robot robot = tree_robot();
  const Vector chi_st = bodies_by_a_rule(robot);
  const std::string urdf = test::content_of(folder / "urdf_write_oracle.urdf");
  const RewrittenUrdf written = rewritten_urdf(tree, "tree.urdf", robot, chi_st);
  EXPECT_TRUE(written.faults.empty());
  // Another compiler may round the last digits otherwise.
  EXPECT_LE(
      (parse_urdf(written.text, "written", of_wrist).chi_st() - parse_urdf(urdf, "oracle", of_wrist).chi_st())
          .cwiseAbs()
          .maxCoeff(),
      1e-13);
  std::ifstream file(folder / "urdf_write_oracle.csv");
  std::string line;
  std::getline(file, line);
  const DynamicModel model(robot, chi_st);
  int states = 0;
  for (; std::getline(file, line); ++states) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream in(line);
    Vector row(12);
    for (double& value : row) {
      in >> value;
    }
    ASSERT_TRUE(in) << line;
    const Vector tau = inverse_dynamics(model, row.head(3), row.segment(3, 3), row.segment(6, 3));
    const Vector expected = row.tail(3);
    EXPECT_LE((tau - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff()) << line;
  }
  EXPECT_EQ(states, 12);
}

TEST(RewrittenUrdf, OfTheSameParametersIsTheSameText) {
  const Robot robot = tree_robot();
  EXPECT_EQ(rewritten_urdf(tree, "tree.urdf", robot, robot.chi_st()).text, tree);
  // Rounding is no change either.
  EXPECT_EQ(rewritten_urdf(tree, "tree.urdf", robot, robot.chi_st() * (1.0 + 1e-15)).text, tree);
}

TEST(RewrittenUrdf, ChangesTheNumbersAlone) {
  const Robot robot = tree_robot();
  Vector chi_st = robot.chi_st();
  chi_st[place(robot, "Fv1")] = 0.75;
  chi_st[place(robot, "Fc3")] = 1.5;
  chi_st[place(robot, "Fc2")] = 0.125;
  std::string expected = replaced(tree, "damping=\"0.25\"", "damping=\"0.75\"");
  expected =
      replaced(expected, "<dynamics damping=\"0.1\"/>", "<dynamics friction=\"1.5\" damping=\"0.1\"/>");
  expected = replaced(expected, "<joint name=\"b\" type=\"prismatic\">",
                      "<joint name=\"b\" type=\"prismatic\">\n    <dynamics friction=\"0.125\"/>");
  EXPECT_EQ(rewritten_urdf(tree, "tree.urdf", robot, chi_st).text, expected);
}

// Twice the density of a link: mass and inertia alone change, in the axes that the file's rpy says.
TEST(RewrittenUrdf, TellsInertiaInTheAxesOfTheFile) {
  const std::string lone =
      replaced(tree,
               "<mass value=\"0.05\"/>\n      <inertia ixx=\"0.0001\" ixy=\"0\" ixz=\"0\" "
               "iyy=\"0.0001\" iyz=\"0\" izz=\"0.0001\"/>",
               "<mass value=\"0\"/>\n      <inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" "
               "iyz=\"0\" izz=\"0\"/>");
  const Robot robot = parse_urdf(lone, "tree.urdf", of_wrist);
  Vector chi_st = robot.chi_st();
  chi_st.head<10>() *= 2.0;
  const RewrittenUrdf written = rewritten_urdf(lone, "tree.urdf", robot, chi_st);
  // The text of the origin stays, since the centre of mass does; numbers of the tensor have roundings.
  EXPECT_NE(written.text.find("<mass value=\"8\"/>   <!-- weighed -->\n      <origin rpy=\"0.3 -0.1 0.7\" "
                              "xyz=\"0.02   0.01 0.1\"/>"),
            std::string::npos)
      << written.text;
  const Robot back = parse_urdf(written.text, "tree.urdf", of_wrist);
  EXPECT_LE((back.chi_st() - chi_st).cwiseAbs().maxCoeff(), 1e-14);
  const std::size_t at = written.text.find("<inertia ixx=\"", written.text.find("weighed"));
  EXPECT_NEAR(std::stod(written.text.substr(at + 14)), 0.1, 1e-15);
}

TEST(RewrittenUrdf, AddsAnInertialWhereALinkGetsMass) {
  const Robot robot = tree_robot();
  Vector chi_st = robot.chi_st();
  chi_st.segment<10>(place(robot, "XX2")) +=
      inertial_from_com(2.0, {0.25, 0.0, -0.5}, Eigen::Vector3d(0.5, 0.5, 0.75).asDiagonal());
  const std::string added = R"(<link name="carriage">
    <inertial>
      <origin xyz="0.25 0 -0.5" rpy="0 0 0"/>
      <mass value="2"/>
      <inertia ixx="0.5" ixy="0" ixz="0" iyy="0.5" iyz="0" izz="0.75"/>
    </inertial>
  </link>)";
  const RewrittenUrdf written = rewritten_urdf(tree, "tree.urdf", robot, chi_st);
  const Robot back = parse_urdf(written.text, "tree.urdf", of_wrist);
  EXPECT_LE((back.chi_st() - chi_st).cwiseAbs().maxCoeff(), 1e-14);
  // Every byte beside the element is that of the file.
  const std::size_t begin = written.text.find("<link name=\"carriage\">");
  const std::size_t end = written.text.find("</link>", begin) + 7;
  EXPECT_EQ(replaced(written.text, written.text.substr(begin, end - begin), "<link name=\"carriage\"/>"),
            tree);
  // And the element differs from the expected one by rounding alone.
  EXPECT_EQ(std::ranges::count(written.text.substr(begin, end - begin), '\n'),
            std::ranges::count(added, '\n'));
  EXPECT_TRUE(written.text.substr(begin, end - begin).starts_with(added.substr(0, 44)));
}

TEST(RewrittenUrdf, KeepsTheLineEndsOfTheFile) {
  std::string windows;
  for (const char c : std::string(tree)) {
    windows += c == '\n' ? "\r\n" : std::string(1, c);
  }
  const Robot robot = tree_robot();
  std::mt19937_64 random(1);
  const RewrittenUrdf written =
      rewritten_urdf(windows, "tree.urdf", robot, test::random_urdf_parameters(robot, random));
  EXPECT_EQ(std::ranges::count(written.text, '\n'), std::ranges::count(written.text, '\r'));
}

TEST(RewrittenUrdf, WritesIntoAFileWithoutLineEnds) {
  std::string flat;
  for (const char c : std::string(tree)) {
    flat += c == '\n' ? ' ' : c;
  }
  const Robot robot = tree_robot();
  std::mt19937_64 random(2);
  const Vector chi_st = test::random_urdf_parameters(robot, random);
  test::expect_same_torques(rewritten_urdf(flat, "flat.urdf", robot, chi_st).text, robot, chi_st, random);
}

TEST(RewrittenUrdf, KeepsTheInertialsOfLumpedLinksWhileTheRestIsABody) {
  const Robot robot = tree_robot();
  Vector chi_st = robot.chi_st();
  chi_st.head<10>() *= 1.5;
  const RewrittenUrdf written = rewritten_urdf(tree, "tree.urdf", robot, chi_st);
  EXPECT_TRUE(written.warnings.empty());
  const std::string_view text = tree;
  const std::string plate(text.substr(text.find("<link name=\"plate\">"), 200));
  EXPECT_NE(written.text.find(plate), std::string::npos);
}

TEST(RewrittenUrdf, ScalesTheInertialsOfLumpedLinksThatLeaveNoBody) {
  const Robot robot = tree_robot();
  Vector chi_st = robot.chi_st();
  // Lighter than the tool alone.
  chi_st.segment<10>(place(robot, "XX3")) =
      inertial_from_com(0.2, {0, 0, 0.1}, 0.001 * Eigen::Matrix3d::Identity());
  const RewrittenUrdf written = rewritten_urdf(tree, "tree.urdf", robot, chi_st);
  EXPECT_TRUE(written.faults.empty());
  ASSERT_EQ(written.warnings.size(), 1U);
  EXPECT_NE(written.warnings[0].text.find(
                "link \"wrist\": what is identified leaves no body to it beside the links that "
                "are fixed to it (\"tool\"); their masses and inertias were scaled by 0."),
            std::string::npos)
      << written.warnings[0].text;
  const Robot back = parse_urdf(written.text, "tree.urdf", of_wrist);
  EXPECT_LE((back.chi_st() - chi_st).cwiseAbs().maxCoeff(), 1e-14);
  // No warning of a reader: all of them are bodies.
  EXPECT_EQ(back.warnings, robot.warnings);
}

TEST(RewrittenUrdf, LeavesNothingToALinkWhereLumpedLinksAreAllThatThereIs) {
  const Robot robot = tree_robot();
  Vector chi_st = robot.chi_st();
  // The tool alone: 0.3 kg, 0.15 m before the wrist.
  chi_st.segment<10>(place(robot, "XX3")) =
      inertial_from_com(0.3, {0, 0, 0.15}, 0.001 * Eigen::Matrix3d::Identity());
  const RewrittenUrdf written = rewritten_urdf(tree, "tree.urdf", robot, chi_st);
  EXPECT_TRUE(written.warnings.empty());
  EXPECT_EQ(
      written.text,
      replaced(tree,
               "<mass value=\"1\"/>\n      <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" "
               "izz=\"0.01\"/>",
               "<mass value=\"0\"/>\n      <inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" "
               "izz=\"0\"/>"));
}

TEST(RewrittenUrdf, RefusesWhatNoBodyCanHaveUnlessForced) {
  const Robot robot = tree_robot();
  Vector chi_st = robot.chi_st();
  chi_st[place(robot, "M1")] = -1.0;
  chi_st.segment<10>(place(robot, "XX3")) =
      inertial_from_com(1.0, {0, 0, 0}, Eigen::Vector3d(0.1, 0.2, 0.5).asDiagonal());
  chi_st[place(robot, "Fc1")] = -0.5;
  const RewrittenUrdf refused = rewritten_urdf(tree, "tree.urdf", robot, chi_st);
  EXPECT_EQ(refused.text, "");
  const std::vector<Finding> expected = {
      {"no_body", "", "link \"upper\": its mass is -1 kg, must be positive"},
      {"driving_friction", "", "joint \"a\": its friction is -0.5, must not be negative"},
      {"no_body", "",
       "link \"wrist\": no body has its inertia: its second moments about the centre of mass have the "
       "eigenvalue -0.1 kg·m², must not be negative"}};
  EXPECT_EQ(refused.faults, expected);
  const RewrittenUrdf forced = rewritten_urdf(tree, "tree.urdf", robot, chi_st, {.force = true});
  EXPECT_EQ(forced.faults, expected);
  EXPECT_NE(forced.text.find("<dynamics friction='0' damping=\"0.25\"/>"), std::string::npos) << forced.text;
}

TEST(RewrittenUrdf, OfAnAsymmetricLawHasTheMeanOfBothDirections) {
  Robot robot = tree_robot();
  robot.joints[2].friction = Friction::asymmetric;
  Vector chi_st = robot.chi_st();
  chi_st[place(robot, "Fc+3")] = 2.0;
  chi_st[place(robot, "Fc-3")] = 1.0;
  chi_st[place(robot, "Fv+3")] = 0.0;
  chi_st[place(robot, "Fv-3")] = 0.0;
  const RewrittenUrdf written = rewritten_urdf(tree, "tree.urdf", robot, chi_st);
  EXPECT_NE(written.text.find("<dynamics friction=\"1.5\" damping=\"0\"/>"), std::string::npos);
}

TEST(RewrittenUrdf, RefusesARobotOfAnotherOrigin) {
  const std::array<MdhRow, 1> table = {MdhRow{}};
  const Robot from_table = robot_from(table);
  const auto rewrite = [&](const Robot& robot, const Vector& chi_st) {
    return test::complaint_of([&] { static_cast<void>(rewritten_urdf(tree, "tree.urdf", robot, chi_st)); });
  };
  EXPECT_NE(rewrite(from_table, from_table.chi_st())
                .find("was not read from a URDF, so there is none to write back"),
            std::string::npos);
  Robot moved = tree_robot();
  moved.chain.links[1].p.x() += 0.1;
  EXPECT_NE(rewrite(moved, moved.chi_st())
                .find("\"tree\" was not read from tree.urdf: its joints, links or frames"),
            std::string::npos);
  const Robot robot = tree_robot();
  EXPECT_NE(rewrite(robot, Vector::Zero(3)).find("chi_st has 3 values"), std::string::npos);
  Vector holed = robot.chi_st();
  holed[place(robot, "MX2")] = std::nan("");
  EXPECT_NE(rewrite(robot, holed).find("MX2 is nan, must be finite"), std::string::npos);
  const std::filesystem::path scara = std::filesystem::path(RIVID_DATA) / "scara/scara.urdf";
  const Robot two_links = read_urdf(scara);
  Vector massless = two_links.chi_st();
  massless[place(two_links, "M2")] = 0.0;
  EXPECT_NE(test::complaint_of([&] {
              static_cast<void>(rewritten_urdf(scara, two_links, massless, {.force = true}));
            }).find("link \"forearm\" has a first moment but no mass; a URDF can not say that"),
            std::string::npos);
}

TEST(RewrittenUrdf, PassesCheckUrdf) {
  const std::string program = RIVID_CHECK_URDF;
  if (program.empty()) {
    GTEST_SKIP() << "check_urdf (liburdfdom-tools) was not found";
  }
  const Robot robot = tree_robot();
  std::mt19937_64 random(3);
  const test::TemporaryFolder folder;
  folder.write("out.urdf",
               rewritten_urdf(tree, "tree.urdf", robot, test::random_urdf_parameters(robot, random)).text);
  const test::Outcome run = test::outcome_of({program, "out.urdf"}, folder.path());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("Successfully Parsed XML"), std::string::npos) << run.out;
  EXPECT_EQ(run.err, "");
}

}  // namespace
}  // namespace rivid
