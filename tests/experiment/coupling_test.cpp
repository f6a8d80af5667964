// [[robot.coupling]], gear_matrix and side of experiment files.

#include <gtest/gtest.h>

#include "rivid/experiment/experiment.hpp"
#include "support/complaint.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

class CoupledExperiment : public testing::Test {
 protected:
  // Keys of [robot] and tables within it; keys of [log].
  [[nodiscard]] Experiment read(const std::string& robot, const std::string& log = "") const {
    folder_.write("arm.csv",
                  "joint,type,alpha,a,d,theta\n1,R,0,0,0.3,0\n2,R,-1.57,0,0,0\n3,R,0,0.2,0.03,0\n");
    folder_.write("log.csv",
                  "t,q1,q2,q3,tau1,tau2,tau3\n0,0,0,0,0,0,0\n0.01,10,20,50,1,2,3\n0.02,0,0,0,1,0,0\n");
    folder_.write("experiment.toml", "[robot]\nmdh = \"arm.csv\"\n" + robot +
                                         "\n[log]\nfiles = [\"log.csv\"]\n" + log +
                                         "\n[signal]\ncutoff_hz = \"off\"\n");
    return read_experiment(folder_.path() / "experiment.toml");
  }

  void expect_refused(const std::string& robot, const std::string& words) const {
    EXPECT_TRUE(test::says(test::complaint_of([&] { return read(robot); }), words));
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(CoupledExperiment, MayHaveEveryFrictionLaw) {
  for (const FrictionRow& law : friction_rows) {
    const Experiment experiment = read("friction = \"" + std::string(law.name) + "\"\n");
    EXPECT_EQ(experiment.robot.joints[1].friction, law.law) << law.name;
  }
  expect_refused("friction = \"coulom\"\n", "did you mean");
}

TEST_F(CoupledExperiment, SaysBothReadings) {
  const Experiment experiment = read(
      "[[robot.coupling]]\nmotor = \"joint_3\"\njoints = [\"joint_2\"]\n"
      "[[robot.coupling]]\nmotor = \"joint_2\"\njoints = \"joint_1\"\nratios = -0.5\ninertia = \"tied\"\n"
      "viscous = false\ncoulomb = \"single\"\nterms = \"all\"\nFcm = 0.25\n");
  ASSERT_EQ(experiment.robot.couplings.size(), 2U);
  const Coupling& free = experiment.robot.couplings[0];
  EXPECT_EQ(free.motor, 2);
  EXPECT_EQ(free.joints, std::vector<int>{1});
  EXPECT_EQ(free.ratios, std::vector<double>{1.0});
  EXPECT_EQ(free.inertia, Coupling::Inertia::free);
  EXPECT_TRUE(free.viscous);
  EXPECT_EQ(free.coulomb, Coupling::Coulomb::sum);
  EXPECT_EQ(free.terms, Coupling::Terms::cross);
  const Coupling& tied = experiment.robot.couplings[1];
  EXPECT_EQ(tied.ratios, std::vector<double>{-0.5});
  EXPECT_EQ(tied.inertia, Coupling::Inertia::tied);
  EXPECT_FALSE(tied.viscous);
  EXPECT_EQ(tied.coulomb, Coupling::Coulomb::single);
  EXPECT_EQ(tied.terms, Coupling::Terms::all);
  EXPECT_EQ(tied.Fcm, 0.25);
}

TEST_F(CoupledExperiment, TurnsALogOfTheMotorsIntoOneOfTheJoints) {
  const Experiment experiment =
      read("gear_matrix = [[10, 0, 0], [0, 10, 0], [0, 10, 20]]", "side = \"motor\"");
  const std::vector<Log> logs = read_logs(experiment.log, experiment.robot);
  ASSERT_EQ(logs.size(), 1U);
  EXPECT_TRUE(logs[0].q.row(1).isApprox(Eigen::RowVector3d(1.0, 2.0, 1.5), 1e-14)) << logs[0].q;
  EXPECT_TRUE(logs[0].tau.row(1).isApprox(Eigen::RowVector3d(10.0, 50.0, 60.0), 1e-14)) << logs[0].tau;
}

TEST_F(CoupledExperiment, TellsWhatCanNotBe) {
  const std::string coupling = "[[robot.coupling]]\n";
  expect_refused(coupling + "motor = \"joint_3\"\n", "[robot.coupling] must name motor and joints");
  expect_refused(coupling + "motor = \"joint_4\"\njoints = [\"joint_2\"]\n",
                 "[robot.coupling] motor is no joint of robot \"arm\"");
  expect_refused(coupling + "motor = \"joint_3\"\njoints = [\"joint2\"]\n", "did you mean \"joint_2\"?");
  expect_refused(coupling + "motor = \"joint_3\"\njoints = [\"joint_2\"]\nratio = [1]\n",
                 "unknown key \"ratio\" in [robot.coupling]; did you mean \"ratios\"?");
  expect_refused(coupling + "motor = \"joint_3\"\njoints = [\"joint_2\"]\nratios = [1, 2]\n",
                 "coupling of motor \"joint_3\": it has 2 ratios for 1 joints");
  expect_refused(coupling + "motor = \"joint_3\"\njoints = [\"joint_2\"]\ninertia = \"fixed\"\n",
                 "[robot.coupling] inertia is \"fixed\", must be one of");
  expect_refused("coupling = 3\n", "[robot] coupling must be a list of tables");
  expect_refused("gear_matrix = [[1, 0], [0, 1]]\n",
                 "[robot] gear_matrix must be 3 lists of 3 numbers: one list a motor, one number a joint");
  expect_refused("gear_matrix = [[1, 0, 0], [0, 1], [0, 0, 1]]\n",
                 "gear_matrix must be 3 lists of 3 numbers");
  expect_refused("gear_matrix = [[1, 0, 0], [0, 1, 1], [0, 1, 1]]\n", "gear_matrix is singular, rank 2 of 3");
}

}  // namespace
}  // namespace rivid
