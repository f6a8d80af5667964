// An experiment file from a robot and the names of the columns of its log: what is recognised, in which order
// and unit.

#include "rivid/experiment/draft.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/error.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/experiment/experiment.hpp"
#include "support/temporary_folder.hpp"
#include "support/two_arms.hpp"

namespace rivid {
namespace {

using Names = std::vector<std::string>;

// A URDF with one revolute joint after the other.
std::string chain_of(const Names& joints) {
  std::string urdf = "<robot name=\"chain\"><link name=\"base\"/>";
  std::string parent = "base";
  for (const std::string& joint : joints) {
    const std::string link = joint + "_body";
    urdf += "<joint name=\"" + joint + "\" type=\"continuous\"><parent link=\"" + parent +
            "\"/><child link=\"" + link + "\"/><axis xyz=\"0 0 1\"/></joint><link name=\"" + link +
            "\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" "
            "iyz=\"0\"/></inertial></link>";
    parent = link;
  }
  return urdf + "</robot>";
}

const Names numbered = {"joint_1", "joint_2", "joint_3"};
const Names ur = {"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"};

class Draft : public testing::Test {
 protected:
  // Ten rows at 1 kHz below a line of names, whatever they are; the first column counts in `step`.
  void write_log(const std::string& header, const std::string& step = "0.001",
                 const std::string& file = "log.csv") const {
    std::string text = header + "\n";
    const auto columns = static_cast<std::size_t>(std::count(header.begin(), header.end(), ',')) + 1;
    for (int row = 0; row < 10; ++row) {
      text += std::to_string(std::stod(step) * row);
      for (std::size_t c = 1; c < columns; ++c) {
        text += "," + std::to_string(c);
      }
      text += '\n';
    }
    folder_.write(file, text);
  }

  void write_text(const std::string& text) const { folder_.write("log.csv", text); }

  [[nodiscard]] ExperimentDraft draft(const Names& joints, const Names& logs = {"log.csv"},
                                      const UrdfOptions& options = {}) const {
    folder_.write("robot.urdf", chain_of(joints));
    std::vector<std::filesystem::path> paths;
    for (const std::string& log : logs) {
      paths.push_back(folder_.path() / log);
    }
    return draft_experiment(folder_.path() / "robot.toml", folder_.path() / "robot.urdf", options, paths);
  }

  // A complete draft, as its reader understands it.
  [[nodiscard]] Experiment read(const Names& joints, const Names& logs = {"log.csv"}) const {
    const ExperimentDraft made = draft(joints, logs);
    EXPECT_TRUE(made.complete) << made.text;
    folder_.write("robot.toml", made.text);
    return read_experiment(folder_.path() / "robot.toml");
  }

  [[nodiscard]] const test::TemporaryFolder& folder() const { return folder_; }

 private:
  test::TemporaryFolder folder_;
};

Names names_of(const std::vector<Column>& columns) {
  Names out;
  for (const Column& column : columns) {
    out.push_back(column.name);
  }
  return out;
}

TEST_F(Draft, KnowsTheDefaultNames) {
  write_log("t,q1,q2,q3,qd1,qd2,qd3,tau1,tau2,tau3,v1,v2,v3,qref1,qref2,qref3");
  const Experiment read = this->read(numbered);
  const LogOptions& columns = read.log.columns;
  EXPECT_EQ(names_of(columns.position), (Names{"q1", "q2", "q3"}));
  EXPECT_EQ(names_of(columns.velocity), (Names{"qd1", "qd2", "qd3"}));
  EXPECT_EQ(names_of(columns.torque), (Names{"tau1", "tau2", "tau3"}));
  EXPECT_EQ(names_of(columns.reference), (Names{"qref1", "qref2", "qref3"}));
  EXPECT_TRUE(columns.control.empty()) << "torques are at hand";
  EXPECT_EQ(columns.time->name, "t");
  EXPECT_TRUE(read.estimation.signal.automatic());
  EXPECT_EQ(name(read.estimation.method), "auto");
}

std::string columns(const Names& joints) {
  std::string out = "t";
  for (const char* const quantity : {"_position", "_effort"}) {
    for (const std::string& joint : joints) {
      out += "," + joint + quantity;
    }
  }
  return out;
}

const Names arms = {"waist",          "left_shoulder", "left_elbow", "left_wrist",
                    "right_shoulder", "right_elbow",   "right_wrist"};

// Crank, coupler, rocker and wrist, of which crank and wrist have an effort.
TEST_F(Draft, TakesTheDrivenJointsOfALinkage) {
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& effort) {
    return "<joint name=\"" + name + "\" type=\"" + (effort.empty() ? "continuous" : "revolute") +
           "\"><parent link=\"" + parent + "\"/><child link=\"" + name +
           "_link\"/><axis xyz=\"0 1 0\"/><origin xyz=\"0.1 0 0.2\"/>" +
           (effort.empty() ? ""
                           : "<limit lower=\"-1\" upper=\"1\" velocity=\"3\" effort=\"" + effort + "\"/>") +
           "</joint><link name=\"" + name +
           "_link\"><inertial><mass value=\"1\"/><inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" "
           "ixz=\"0\" iyz=\"0\"/></inertial></link>";
  };
  folder().write("robot.urdf", "<robot name=\"linkage\"><link name=\"base\"/>" + joint("crank", "base", "9") +
                                   joint("coupler", "crank_link", "") + joint("rocker", "base", "") +
                                   joint("wrist", "coupler_link", "5") + "</robot>");
  write_log("t,q1,q2,tau1,tau2");
  const ExperimentDraft made =
      draft_experiment(folder().path() / "robot.toml", folder().path() / "robot.urdf", {},
                       std::vector{folder().path() / "log.csv"});
  EXPECT_NE(made.text.find("moving = [\"crank\", \"wrist\"]"), std::string::npos) << made.text;
  ASSERT_EQ(made.doubts.size(), 1U);
  EXPECT_NE(made.doubts[0].find("[[robot.four_bar]]"), std::string::npos) << made.doubts[0];
}

TEST_F(Draft, TakesTheJointsOfATreeThatTheLogHasColumnsOf) {
  folder().write("robot.urdf", test::two_arms());
  const auto draft_of = [&](const Names& joints) {
    write_log(columns(joints));
    const ExperimentDraft made =
        draft_experiment(folder().path() / "robot.toml", folder().path() / "robot.urdf", {},
                         std::vector{folder().path() / "log.csv"});
    EXPECT_TRUE(made.complete) << made.text;
    folder().write("robot.toml", made.text);
    return std::pair(made, read_experiment(folder().path() / "robot.toml"));
  };
  // Fingers are seldom logged.
  const auto [made, both] = draft_of(arms);
  EXPECT_EQ(both.robot.size(), 7);
  EXPECT_TRUE(both.robot.chain.branches());
  EXPECT_NE(made.text.find("moving = [\"waist\", \"left_shoulder\""), std::string::npos) << made.text;
  ASSERT_EQ(made.doubts.size(), 1U);
  EXPECT_NE(made.doubts[0].find("no positions of 2 joints"), std::string::npos) << made.doubts[0];

  const Experiment left = draft_of({"left_shoulder", "left_elbow", "left_wrist"}).second;
  EXPECT_EQ(left.robot.size(), 3);
  EXPECT_FALSE(left.robot.chain.branches());
  EXPECT_EQ(names_of(left.log.columns.position),
            (Names{"left_shoulder_position", "left_elbow_position", "left_wrist_position"}));
  // Columns that count fit the ways to several links.
  write_log("t,q1,q2,q3,tau1,tau2,tau3");
  EXPECT_FALSE(draft_experiment(folder().path() / "robot.toml", folder().path() / "robot.urdf", {},
                                std::vector{folder().path() / "log.csv"})
                   .complete)
      << "there are two elbows";
  // All of them.
  Names all = arms;
  all.insert(all.begin() + 4, "left_grip");
  all.emplace_back("right_grip");
  EXPECT_EQ(draft_of(all).second.robot.size(), 9);
}

// Names that Universal Robots' real-time interface writes.
TEST_F(Draft, KnowsTheNamesOfUniversalRobots) {
  std::string header = "timestamp";
  for (const char* const stem : {"target_q", "target_qd", "target_qdd", "target_current", "target_moment",
                                 "actual_q", "actual_qd", "actual_current", "actual_joint_voltage",
                                 "joint_temperatures", "actual_TCP_pose", "actual_TCP_force"}) {
    for (const char* const number : {"_0", "_1", "_2"}) {
      header += std::string(",") + stem + number;
    }
  }
  write_log(header, "0.002");
  const Experiment read = this->read(ur);
  const LogOptions& columns = read.log.columns;
  EXPECT_EQ(names_of(columns.position), (Names{"actual_q_0", "actual_q_1", "actual_q_2"}));
  EXPECT_EQ(names_of(columns.velocity), (Names{"actual_qd_0", "actual_qd_1", "actual_qd_2"}));
  EXPECT_EQ(names_of(columns.reference), (Names{"target_q_0", "target_q_1", "target_q_2"}));
  EXPECT_EQ(names_of(columns.reference_velocity), (Names{"target_qd_0", "target_qd_1", "target_qd_2"}));
  EXPECT_EQ(names_of(columns.control), (Names{"actual_current_0", "actual_current_1", "actual_current_2"}));
  EXPECT_TRUE(columns.torque.empty());
  EXPECT_TRUE(read.estimation.signal.automatic());
}

// libfranka's: q_d is asked for, tau_ext_hat_filtered and tau_J_d are not what was measured.
TEST_F(Draft, KnowsTheNamesOfFranka) {
  std::string header = "time";
  for (const char* const stem :
       {"q_d", "dq_d", "ddq_d", "tau_J_d", "tau_ext_hat_filtered", "tau_J", "dq", "q"}) {
    for (const char* const number : {"[0]", "[1]", "[2]"}) {
      header += std::string(",") + stem + number;
    }
  }
  write_log(header);
  const LogOptions& columns = read(numbered).log.columns;
  EXPECT_EQ(names_of(columns.position), (Names{"q[0]", "q[1]", "q[2]"}));
  EXPECT_EQ(names_of(columns.velocity), (Names{"dq[0]", "dq[1]", "dq[2]"}));
  EXPECT_EQ(names_of(columns.torque), (Names{"tau_J[0]", "tau_J[1]", "tau_J[2]"}));
  EXPECT_EQ(names_of(columns.reference), (Names{"q_d[0]", "q_d[1]", "q_d[2]"}));
  EXPECT_EQ(names_of(columns.reference_velocity), (Names{"dq_d[0]", "dq_d[1]", "dq_d[2]"}));
}

// Programs whose names say what they hold without a word for it; KUKA and ABB log degrees.
TEST_F(Draft, KnowsTheNamesOfMoreProgramsByTheTableThatPythonReads) {
  struct Case {
    Names positions;
    Names torques;
    double scale;
  };
  const double degree = unit_scale("deg");
  for (const Case& program :
       {Case{{"AxisAct.A1", "AxisAct.A2", "AxisAct.A3"},
             {"TorqueAct.A1", "TorqueAct.A2", "TorqueAct.A3"},
             degree},
        Case{{"AxisActReal.A1", "AxisActReal.A2", "AxisActReal.A3"}, {"tau1", "tau2", "tau3"}, degree},
        Case{{"rax_1", "rax_2", "rax_3"}, {"torque_1", "torque_2", "torque_3"}, degree},
        Case{{"qpos0", "qpos1", "qpos2"}, {"qfrc_actuator0", "qfrc_actuator1", "qfrc_actuator2"}, 1.0},
        Case{{"/arm/qpos_0", "/arm/qpos_1", "/arm/qpos_2"},
             {"/arm/qfrc_actuator_0", "/arm/qfrc_actuator_1", "/arm/qfrc_actuator_2"},
             1.0},
        Case{{"observation.state.0", "observation.state.1", "observation.state.2"},
             {"observation.effort.0", "observation.effort.1", "observation.effort.2"},
             1.0},
        Case{{"$MCH_ANG[1]", "$MCH_ANG[2]", "$MCH_ANG[3]"}, {"tau1", "tau2", "tau3"}, degree},
        Case{{"Winkel Achse 1 [Grad]", "Winkel Achse 2 [Grad]", "Winkel Achse 3 [Grad]"},
             {"Drehmoment Achse 1 [Nm]", "Drehmoment Achse 2 [Nm]", "Drehmoment Achse 3 [Nm]"},
             degree},
        Case{{"position_axe_1", "position_axe_2", "position_axe_3"},
             {"couple_axe_1", "couple_axe_2", "couple_axe_3"},
             1.0},
        Case{{"θ1(deg)", "θ2(deg)", "θ3(deg)"}, {"τ1", "τ2", "τ3"}, degree},
        Case{{"q0", "q1", "q2"}, {"tau0", "tau1", "tau2"}, 1.0}}) {
    std::string header = "timestamp";
    for (const Names& names :
         {program.positions, program.torques, Names{"action.0", "action.1", "action.2"}}) {
      for (const std::string& name : names) {
        header += "," + name;
      }
    }
    write_log(header);
    const LogOptions columns = read(numbered).log.columns;
    EXPECT_EQ(names_of(columns.position), program.positions);
    EXPECT_EQ(names_of(columns.torque), program.torques);
    EXPECT_EQ(names_of(columns.reference), (Names{"action.0", "action.1", "action.2"}));
    EXPECT_EQ(columns.position.front().scale, program.scale) << header;
  }
}

// Joint states that are told by name stand in the order of the chain, whatever the order of the columns.
TEST_F(Draft, SortsColumnsThatAreNamedAfterJoints) {
  write_log(
      "__time,/joint_states/elbow_joint/effort,/joint_states/elbow_joint/position,"
      "/joint_states/shoulder_lift_joint/effort,/joint_states/shoulder_lift_joint/position,"
      "/joint_states/shoulder_pan_joint/effort,/joint_states/shoulder_pan_joint/position");
  const LogOptions& columns = read(ur).log.columns;
  EXPECT_EQ(names_of(columns.position),
            (Names{"/joint_states/shoulder_pan_joint/position", "/joint_states/shoulder_lift_joint/position",
                   "/joint_states/elbow_joint/position"}));
  EXPECT_EQ(names_of(columns.torque),
            (Names{"/joint_states/shoulder_pan_joint/effort", "/joint_states/shoulder_lift_joint/effort",
                   "/joint_states/elbow_joint/effort"}));
  EXPECT_EQ(columns.time->name, "__time");
}

TEST_F(Draft, KnowsJointsWithoutWhatTheirNamesShare) {
  write_log(
      "t,elbow_pos,shoulder_lift_pos,shoulder_pan_pos,elbow_torque,shoulder_lift_torque,shoulder_pan_torque");
  const LogOptions& columns = read(ur).log.columns;
  EXPECT_EQ(names_of(columns.position), (Names{"shoulder_pan_pos", "shoulder_lift_pos", "elbow_pos"}));
  EXPECT_EQ(names_of(columns.torque), (Names{"shoulder_pan_torque", "shoulder_lift_torque", "elbow_torque"}));
}

TEST_F(Draft, TakesUnitsFromNames) {
  write_log(
      "Time (ms),Axis1 Position [deg],Axis2 Position [deg],Axis3 Position [deg],Axis1 Torque [mNm],"
      "Axis2 Torque [mNm],Axis3 Torque [mNm],Axis1 Speed [deg/s],Axis2 Speed [deg/s],Axis3 Speed [deg/s]",
      "1");
  const Experiment read = this->read(numbered);
  const LogOptions& columns = read.log.columns;
  EXPECT_EQ(columns.time->scale, 1e-3);
  ASSERT_EQ(columns.position.size(), 3U);
  EXPECT_EQ(columns.position[0].name, "Axis1 Position [deg]");
  EXPECT_EQ(columns.position[2].scale, unit_scale("deg"));
  EXPECT_EQ(columns.torque[1].scale, 1e-3);
  EXPECT_EQ(columns.velocity[1].scale, unit_scale("deg/s"));
}

TEST_F(Draft, TakesUnitsFromTheEndsOfNames) {
  write_log("t_us,q1_deg,q2_deg,q3_deg,tau1_Nm,tau2_Nm,tau3_Nm,qd1_rad_s,qd2_rad_s,qd3_rad_s", "1000");
  const LogOptions& columns = read(numbered).log.columns;
  EXPECT_EQ(columns.time->scale, 1e-6);
  EXPECT_EQ(columns.position[0].scale, unit_scale("deg"));
  EXPECT_EQ(columns.torque[0].scale, 1.0);
  EXPECT_EQ(columns.velocity[0].scale, 1.0);
}

// Steps of 1 and 1000000 are no seconds.
TEST_F(Draft, GuessesTheUnitOfTimeFromItsSteps) {
  for (const auto& [step, scale] : {std::pair{"1", 1e-3}, {"1000", 1e-6}, {"1000000", 1e-9}, {"0.1", 1.0}}) {
    write_log("t,q1,q2,q3,tau1,tau2,tau3", step);
    EXPECT_EQ(read(numbered).log.columns.time->scale, scale) << step;
  }
  write_log("t,q1,q2,q3,tau1,tau2,tau3", "1");
  ASSERT_EQ(draft(numbered).doubts.size(), 1U);
  EXPECT_EQ(draft(numbered).doubts[0],
            "time is taken for ms: its stamps are then 10 samples at 1000 Hz; jitter 0 % rms, 0 % at most");
}

TEST_F(Draft, NeedsNoNumbersForOneJoint) {
  write_log("time,position,velocity,acceleration,motor_current");
  const LogOptions& columns = read({"slide"}).log.columns;
  EXPECT_EQ(names_of(columns.position), Names{"position"});
  EXPECT_EQ(names_of(columns.velocity), Names{"velocity"});
  EXPECT_EQ(names_of(columns.control), Names{"motor_current"});
}

TEST_F(Draft, PrefersTheJointSideAndTellsOfChoices) {
  write_log(
      "t,motor_q1,motor_q2,motor_q3,q1,q2,q3,left_tau1,left_tau2,left_tau3,right_tau1,right_tau2,right_tau3");
  EXPECT_EQ(names_of(read(numbered).log.columns.position), (Names{"q1", "q2", "q3"}));
  const ExperimentDraft made = draft(numbered);
  ASSERT_EQ(made.doubts.size(), 1U);
  EXPECT_EQ(made.doubts[0], "torque may be \"left_tau1\" … or \"right_tau1\" …; the first is taken");
}

TEST_F(Draft, KeepsTheLastOfSeveralLogsForValidation) {
  for (const char* const file : {"a.csv", "b.csv", "c.csv"}) {
    write_log("t,q1,q2,q3,tau1,tau2,tau3", "0.001", file);
  }
  const Experiment read = this->read(numbered, {"a.csv", "b.csv", "c.csv"});
  EXPECT_EQ(read.log.files.size(), 2U);
  ASSERT_EQ(read.validation.files.size(), 1U);
  EXPECT_EQ(read.validation.files[0].filename(), "c.csv");
  write_log("t,q1,q2,q3,tau_1,tau_2,tau_3", "0.001", "c.csv");
  EXPECT_THROW((void)draft(numbered, {"a.csv", "c.csv"}), InputError);
}

TEST_F(Draft, ReadsNamesFromACommentAboveTheRows) {
  write_log("# t,q1,q2,q3,tau1,tau2,tau3");
  EXPECT_EQ(names_of(read(numbered).log.columns.torque), (Names{"tau1", "tau2", "tau3"}));
}

TEST_F(Draft, ResamplesIrregularClocks) {
  folder().write("log.csv", "t,q,tau\n0,1,2\n0.01,1,2\n0.024,1,2\n0.03,1,2\n0.04,1,2\n0.05,1,2\n");
  EXPECT_EQ(read({"slide"}).log.irregular, Irregular::resample);
}

TEST_F(Draft, SaysWhatIsLeftToFillIn) {
  write_log("t,a1,a2,a3,tau1,tau2,tau3");
  const ExperimentDraft no_position = draft(numbered);
  EXPECT_FALSE(no_position.complete);
  ASSERT_EQ(no_position.doubts.size(), 1U);
  EXPECT_NE(no_position.doubts[0].find("no columns of positions were recognised"), std::string::npos);
  EXPECT_NE(no_position.text.find("\n# position = [\"…\"]"), std::string::npos) << no_position.text;

  write_log("0,1,2,3,4,5,6");
  EXPECT_FALSE(draft(numbered).complete);
  EXPECT_EQ(draft(numbered).doubts.size(), 3U) << "positions, torques, time";
}

// Four columns are no three joints: the chain may end at the wrong link.
TEST_F(Draft, TellsOfColumnsThatAlmostFit) {
  write_log("t,q1,q2,q3,q4,tau1,tau2,tau3,tau4");
  const ExperimentDraft made = draft(numbered);
  EXPECT_FALSE(made.complete);
  EXPECT_NE(made.doubts.at(0).find("\"q1\" to \"q4\" are 4 columns, the robot has 3 joints"),
            std::string::npos)
      << made.doubts.at(0);

  write_log("t,joint_1_pos,joint_2_pos,joint_3_pos,hand_pos,tau1,tau2,tau3,pos1,pos2");
  EXPECT_EQ(draft(numbered).doubts.size(), 0U) << "what was found needs no other columns";
}

// A controller that logs the current and the torque that it wants tells its gains, friction aside.
TEST_F(Draft, ReadsTheGainsOfAControllersOwnModel) {
  std::string text =
      "t,q1,q2,q3,qd1,qd2,qd3,i1,i2,i3,itarget1,itarget2,itarget3,tautarget1,tautarget2,tautarget3\n";
  const std::vector<double> gains = {11.5, 9.25, 4.0};
  for (int k = 0; k < 400; ++k) {
    const double t = 0.01 * k;
    std::string positions, speeds, currents, wanted, torques;
    for (std::size_t j = 0; j < 3; ++j) {
      const double w = 1.0 + 0.4 * static_cast<double>(j);
      const double qd = std::cos(w * t);
      const double tau = 5.0 * std::sin(2.3 * w * t) + 3.0;
      const double friction = 0.8 * qd + 1.5 * (qd > 0.0 ? 1.0 : -1.0);
      positions += "," + std::to_string(std::sin(w * t) / w);
      speeds += "," + std::to_string(qd);
      currents += ",0.5";
      wanted += "," + std::to_string((tau + friction) / gains[j]);
      torques += "," + std::to_string(tau);
    }
    text += std::to_string(t) + positions + speeds + currents + wanted + torques + "\n";
  }
  write_text(text);
  const ExperimentDraft found = draft(ur);
  EXPECT_NE(found.text.find("drive_gain = [11.5, 9.25, 4]"), std::string::npos) << found.text;
  EXPECT_NE(found.text.find("control = [\"i1\", \"i2\", \"i3\"]"), std::string::npos) << found.text;
}

// Before there is a log: what rivid excite reads, guesses of limits and the room of a tool asked for.
TEST_F(Draft, IsOfADesignWithoutALog) {
  const ExperimentDraft made = draft(numbered, {});
  EXPECT_TRUE(made.complete);
  ASSERT_EQ(made.doubts.size(), 5U);
  EXPECT_NE(made.doubts[0].find("noise = 1"), std::string::npos) << made.doubts[0];
  EXPECT_EQ(made.doubts[1],
            "the description has no lower limit of joint_1, joint_2, joint_3; -3.1 in "
            "[excitation.limits] is a guess");
  EXPECT_NE(made.doubts[4].find("tool or gripper on joint_3_body"), std::string::npos) << made.doubts[4];
  folder().write("robot.toml", made.text);
  const ExcitationPlan plan = read_excitation(folder().path() / "robot.toml");
  EXPECT_EQ(plan.options.limits.lower, Vector::Constant(3, -3.1));
  EXPECT_EQ(plan.options.limits.upper, Vector::Constant(3, 3.1));
  EXPECT_EQ(plan.options.limits.velocity, Vector::Constant(3, 1.0));
  EXPECT_EQ(plan.options.limits.acceleration, Vector::Constant(3, 5.0));
  EXPECT_EQ(plan.options.noise.sigma, Vector::Constant(3, 1.0));
  EXPECT_EQ(plan.options.space.half_spaces.size(), 1U);
}

}  // namespace
}  // namespace rivid
