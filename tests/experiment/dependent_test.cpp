// A palletiser, whose parallelogram is a tree with two dependent joints, and a hand with a mimic finger:
// simulated in closed loop and identified.

#include "rivid/model/dependent.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "rivid/experiment/result_file.hpp"
#include "rivid/export/model.hpp"
#include "rivid/export/urdf.hpp"
#include "rivid/report/json.hpp"
#include "rivid/simulate/dynamic_model.hpp"
#include "support/complaint.hpp"
#include "support/normal.hpp"
#include "support/temporary_folder.hpp"
#include "support/two_arms.hpp"
#include "support/written_urdf.hpp"

namespace rivid {
namespace {

// Shoulder and crank are driven, and the parallelogram of lower arm, forearm, rod and lever between them is
// cut where rod and forearm meet; the hand hangs on the forearm, with two fingers.
std::string palletiser() {
  std::string out = "<robot name=\"palletiser\"><link name=\"base\"/>";
  const auto add = [&](const std::string& joint, const std::string& type, const std::string& parent,
                       const std::string& child, const std::string& xyz, const std::string& axis,
                       const std::string& com, double mass, double size, const std::string& more = "") {
    const std::string I = std::to_string(mass * size * size);
    const std::string J = std::to_string(0.6 * mass * size * size);
    out += "<link name=\"" + child + "\"><inertial><origin xyz=\"" + com + "\"/><mass value=\"" +
           std::to_string(mass) + "\"/><inertia ixx=\"" + I + "\" iyy=\"" + I + "\" izz=\"" + J +
           "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><joint name=\"" + joint + "\" type=\"" +
           type + "\"><origin xyz=\"" + xyz + "\"/><parent link=\"" + parent + "\"/><child link=\"" + child +
           "\"/><axis xyz=\"" + axis + "\"/><limit lower=\"-3\" upper=\"3\" velocity=\"6\" effort=\"300\"/>" +
           more + "</joint>";
  };
  add("turn", "revolute", "base", "column", "0 0 0.3", "0 0 1", "0.05 0.02 0.1", 15.0, 0.2);
  add("shoulder", "revolute", "column", "lower_arm", "0.1 0 0.2", "0 1 0", "0.02 0.05 0.35", 8.0, 0.25);
  add("elbow", "revolute", "lower_arm", "forearm", "0 0 0.8", "0 1 0", "0.3 0.01 0.02", 5.0, 0.2);
  add("wrist", "revolute", "forearm", "hand", "0.7 0 0", "1 0 0", "0.1 0.04 0.03", 2.0, 0.1);
  add("crank", "revolute", "column", "lever", "0.1 0.1 0.2", "0 1 0", "-0.12 0.01 0.02", 2.5, 0.15);
  add("rod_joint", "revolute", "lever", "rod", "-0.3 0 0", "0 1 0", "0.01 0.02 0.4", 1.5, 0.3);
  add("grip", "prismatic", "hand", "finger", "0.2 0.05 0", "0 1 0", "0.03 0 0", 0.6, 0.05);
  add("grip_2", "prismatic", "hand", "thumb", "0.2 -0.05 0", "0 1 0", "0.03 0 0", 0.4, 0.05,
      "<mimic joint=\"grip\" multiplier=\"-1\"/>");
  return out + "</robot>";
}

const std::string robot_section = R"(
[robot]
urdf = "palletiser.urdf"
friction = "coulomb"
joints.turn = { Ia = 0.5, Fv = 3.0, Fc = 4.0 }
joints.shoulder = { Ia = 0.4, Fv = 3.0, Fc = 4.0 }
joints.crank = { Ia = 0.3, Fv = 2.0, Fc = 3.0 }
joints.wrist = { Ia = 0.05, Fv = 0.5, Fc = 0.8 }
joints.grip = { Ia = 1.0, Fv = 8.0, Fc = 3.0 }
)";

const std::string loop = R"(
[[robot.dependent]]
joint = "elbow"
of = { crank = 1, shoulder = -1 }

[[robot.dependent]]
joint = "rod_joint"
of = { shoulder = 1, crank = -1 }
)";

const std::string study = R"(
[control]
law = "pd"
omega_n = [20, 20, 30, 25, 20]
zeta = 1
reference_velocity = true
rate_hz = 500
velocity_filter = "backward"

[reference]
type = "fourier"
omega_f = 0.785398
file = "reference.csv"

[simulation]
parameters = "a_priori"
position_noise = 2e-6
disturbance = [0.4, 0.4, 0.1, 0.2, 0.3]

[montecarlo]
runs = 8
seed = 3

[[montecarlo.trial]]
label = "IV"
name = "iv"
signal = { cutoff_hz = "off", torque_held = true, decimation = 10 }

[[montecarlo.trial]]
label = "WLS"
name = "wls"
signal = { cutoff_hz = "off", torque_held = true, decimation = 10 }
)";

class Palletiser : public testing::Test {
 protected:
  Palletiser() {
    folder_.write("palletiser.urdf", palletiser());
    folder_.write("reference.csv", test::random_fourier(5, 12, 9, {1.0, 0.6, 1.0, 0.05, 0.6}));
    folder_.write("study.toml", robot_section + loop + study);
  }

  [[nodiscard]] std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] Robot robot() const { return read_monte_carlo(path("study.toml")).experiment.robot; }
  [[nodiscard]] std::string refusal(const std::string& more) {
    folder_.write("wrong.toml", robot_section + more + study);
    return test::complaint_of([&] { return read_monte_carlo(path("wrong.toml")); });
  }

  test::TemporaryFolder folder_;
};

TEST_F(Palletiser, ComesOutOfItsLogsWithinItsIntervals) {
  const MonteCarlo plan = read_monte_carlo(path("study.toml"));
  const Robot& robot = plan.experiment.robot;
  ASSERT_EQ(robot.size(), 5);
  ASSERT_EQ(robot.chain.dependents.size(), 3U);
  const BaseParameters base = base_parameters(robot);
  const Vector truth = base.from_standard(robot.chi_st());
  for (std::size_t trial = 0; trial < plan.trials.size(); ++trial) {
    double squares = 0.0;
    double largest = 0.0;
    Index count = 0;
    Index inside = 0;
    for (int run = 0; run < plan.runs; ++run) {
      const MonteCarloRow row = monte_carlo_run(plan, run)[trial];
      ASSERT_EQ(row.status, "identified") << plan.trials[trial].label << ", run " << run;
      const Vector error = (row.value - truth).array() / row.sigma.array();
      squares += error.squaredNorm();
      count += error.size();
      inside += (error.array().abs() < 1.96).count();
      largest = std::max(largest, error.cwiseAbs().maxCoeff());
    }
    // Some 300 errors, of which those of one log depend on each other.
    const auto n = static_cast<double>(count);
    EXPECT_NEAR(std::sqrt(squares / n), 1.0, 0.15) << plan.trials[trial].label;
    EXPECT_GE(static_cast<double>(inside) / n, 0.91) << plan.trials[trial].label;
    EXPECT_LE(largest, 4.5) << plan.trials[trial].label;
  }
}

TEST_F(Palletiser, GoesThroughItsResultWithBodiesForAllLinks) {
  const MonteCarlo plan = read_monte_carlo(path("study.toml"));
  const Robot& robot = plan.experiment.robot;
  const SimulationRecord record = run_simulation(plan.experiment);
  Estimation estimation = plan.trials[1].experiment.estimation;
  estimation.physical = Physical();
  const Identification result = identify(robot, record.log, estimation);
  ASSERT_TRUE(result.physical);
  ASSERT_EQ(result.physical->parameters.chi_st.size(), std::ssize(robot.standard_parameters()));
  folder_.write("result.json", to_json(robot, result, {}));
  const DynamicModel wanted(robot, result.physical->parameters.chi_st);
  const DynamicModel found = read_identified_model(path("result.json"), robot);
  const DynamicModel alone = read_identified_model(path("result.json"));
  const Motion& motion = record.simulation.motion;
  for (Index k = 0; k < motion.samples(); k += 500) {
    const auto torques = [&](const DynamicModel& model) {
      return inverse_dynamics(model, motion.q.row(k).transpose(), motion.qd.row(k).transpose(),
                              motion.qdd.row(k).transpose());
    };
    EXPECT_LT((torques(found) - torques(wanted)).norm(), 1e-9 * torques(wanted).norm());
    EXPECT_LT((torques(alone) - torques(wanted)).norm(), 1e-9 * torques(wanted).norm());
  }
  EXPECT_TRUE(test::says(
      test::complaint_of([&] {
        return read_identified_model(
            path("result.json"),
            read_urdf(path("palletiser.urdf"),
                      {.base = {}, .tip = {}, .moving = {"turn", "shoulder", "wrist", "grip", "crank"}}));
      }),
      "what joints follow others"));
}

// Passive joints that are taken as standing still leave what they move unexplained.
TEST_F(Palletiser, FitsWorseWhereTheDependenceIsIgnored) {
  const MonteCarlo plan = read_monte_carlo(path("study.toml"));
  const SimulationRecord record = run_simulation(plan.experiment);
  ASSERT_EQ(record.simulation.outcome, Outcome::completed) << record.simulation.reason;
  const Estimation& estimation = plan.trials[1].experiment.estimation;
  const Identification right = identify(plan.experiment.robot, record.log, estimation);
  Robot still = read_urdf(path("palletiser.urdf"),
                          {.base = {}, .tip = {}, .moving = {"turn", "shoulder", "wrist", "grip", "crank"}});
  ASSERT_EQ(still.size(), 5);
  still.joints = plan.experiment.robot.joints;
  const Identification wrong = identify(still, record.log, estimation);
  EXPECT_GT(wrong.fit.relative_error, 3.0 * right.fit.relative_error);
}

TEST_F(Palletiser, GoesBackIntoItsUrdfAndKeepsItsMimicJoint) {
  const Robot robot = read_urdf(path("palletiser.urdf"), same_part(this->robot()));
  ASSERT_EQ(robot.chain.dependents.size(), 3U);
  std::mt19937_64 random(11);
  const Vector chi_st = test::random_urdf_parameters(robot, random);
  const RewrittenUrdf written = rewritten_urdf(path("palletiser.urdf"), robot, chi_st);
  test::expect_same_torques(written.text, robot, chi_st, random);
  EXPECT_NE(written.text.find("<mimic joint=\"grip\" multiplier=\"-1\"/>"), std::string::npos);
  // What follows two joints no mimic can say.
  ASSERT_EQ(written.warnings.size(), 2U);
  EXPECT_TRUE(test::says(written.warnings[0].text, "joint \"elbow\" follows several joints"));

  const ExportedModel mjcf =
      exported_model(ModelFormat::mjcf, path("palletiser.urdf"), robot, chi_st, {.force = true});
  ASSERT_FALSE(mjcf.files.empty());
  EXPECT_TRUE(test::says(mjcf.files[0].text, "joint1=\"grip_2\" joint2=\"grip\" polycoef=\"0 -1 0 0 0\""));
}

TEST_F(Palletiser, FollowsOneJointAsTheExperimentSaysInItsUrdf) {
  folder_.write("one.toml", robot_section +
                                "[[robot.dependent]]\njoint = \"rod_joint\"\nof = { crank = -0.5 }\n" +
                                "offset = 0.25\n[log]\nfiles = [\"log.csv\"]\n");
  const Robot robot = read_experiment(path("one.toml")).robot;
  const RewrittenUrdf written = rewritten_urdf(path("palletiser.urdf"), robot, robot.chi_st());
  EXPECT_TRUE(test::says(written.text, "<mimic joint=\"crank\" multiplier=\"-0.5\" offset=\"0.25\"/>"));
  const Robot again = parse_urdf(written.text, "written.urdf");
  EXPECT_EQ(dependent_joints(again).size(), 2U);
}

// Points of the parallelogram as an encoder at the elbow logs them, in columns of other names.
TEST_F(Palletiser, TakesDependentJointsFromTables) {
  std::mt19937_64 random(5);
  test::Normal normal;
  std::uniform_real_distribution<double> draw(-2.0, 2.0);
  std::ostringstream log;
  std::ostringstream grid;
  log << "time,a,b,c\n";
  grid << "rod_joint,crank,shoulder\n";
  for (int k = 0; k < 4000; ++k) {
    const double crank = draw(random);
    const double shoulder = draw(random);
    log << 0.001 * k << ',' << shoulder << ',' << crank << ',' << crank - shoulder + 1e-4 * normal(random)
        << '\n';
  }
  for (int k = 0; k < 400; ++k) {
    const double crank = 0.2 * (k % 20 - 10);
    const double shoulder = 0.2 * (k / 20 - 10);
    grid << shoulder - crank << ',' << crank << ',' << shoulder << '\n';
  }
  folder_.write("encoder.csv", log.str());
  folder_.write("rod.csv", grid.str());
  const std::string tables =
      "[[robot.dependent]]\njoint = \"elbow\"\nof = { crank = 1, shoulder = 1 }\ntable = \"encoder.csv\"\n"
      "columns = [\"c\", \"b\", \"a\"]\n[[robot.dependent]]\njoint = \"rod_joint\"\ntable = \"rod.csv\"\n";
  folder_.write("tables.toml", robot_section + tables + study);
  const Experiment asked = read_monte_carlo(path("tables.toml")).experiment;
  const Robot& by_table = asked.robot;
  for (const char* const table : {"encoder.csv", "rod.csv"}) {
    EXPECT_EQ(std::ranges::count(asked.inputs(), path(table)), 1) << table;
  }
  const Robot by_sum = robot();
  const auto model = [](const Robot& robot) { return DynamicModel(robot, robot.chi_st()); };
  for (int k = 0; k < 50; ++k) {
    const auto state = [&] { return Vector(Vector::NullaryExpr(5, [&] { return 0.9 * draw(random); })); };
    const Vector q = state();
    const Vector qd = state();
    const Vector qdd = state();
    const Vector wanted = inverse_dynamics(model(by_sum), q, qd, qdd);
    // Slopes of noise of 1e-4 rad over pieces of 0.25 rad with 16 points each; curvatures more.
    EXPECT_LT((inverse_dynamics(model(by_table), q, qd, qdd) - wanted).norm(), 0.02 * wanted.norm());
  }
  // The way through a result.
  const SimulationRecord record = run_simulation(read_monte_carlo(path("study.toml")).experiment);
  const Identification result =
      identify(by_table, record.log, read_monte_carlo(path("study.toml")).trials[1].experiment.estimation);
  folder_.write("result.json", to_json(by_table, result, {}));
  const Vector q = record.log.q.row(700);
  const Vector zero = Vector::Zero(5);
  const auto torques = [&](const DynamicModel& of) { return inverse_dynamics(of, q, zero, zero); };
  EXPECT_LT((torques(read_identified_model(path("result.json"))) -
             torques(read_identified_model(path("result.json"), by_table)))
                .norm(),
            1e-12);

  EXPECT_TRUE(test::says(refusal("[[robot.dependent]]\njoint = \"elbow\"\nof = { crank = 1 }\ntable = "
                                 "\"encoder.csv\"\ncolumns = [\"c\", \"b\"]\n"),
                         "encoder.csv: dependent joint \"elbow\": the points lie"));
  EXPECT_TRUE(test::says(refusal("[[robot.dependent]]\njoint = \"elbow\"\ntable = \"rod.csv\"\n"), "elbow"));
  EXPECT_TRUE(test::says(refusal("[[robot.dependent]]\njoint = \"elbow\"\nof = { crank = 2 }\ntable = "
                                 "\"rod.csv\"\n"),
                         "with table must be 0 and 1"));
  EXPECT_TRUE(test::says(refusal("[[robot.dependent]]\njoint = \"elbow\"\nof = { crank = 1 }\ncolumns = "
                                 "[\"c\"]\n"),
                         "goes with table"));
}

TEST_F(Palletiser, FaultsNameTheJoint) {
  EXPECT_TRUE(test::says(refusal("[[robot.dependent]]\njoint = \"elbou\"\nof = { crank = 1 }\n"),
                         "dependent joint \"elbou\": it is no joint of the robot; did you mean \"elbow\"?"));
  EXPECT_TRUE(
      test::says(refusal("[[robot.dependent]]\njoint = \"elbow\"\nof = { cranc = 1 }\n"),
                 "dependent joint \"elbow\": it follows \"cranc\", which is no joint of the robot; did you "
                 "mean \"crank\"?"));
  EXPECT_TRUE(test::says(refusal("[[robot.dependent]]\njoint = \"elbow\"\n"), "must name of or table"));
  EXPECT_TRUE(test::says(refusal("[[robot.dependent]]\njoint = \"elbow\"\nof = { rod_joint = 1 }\n"
                                 "[[robot.dependent]]\njoint = \"rod_joint\"\nof = { elbow = 1 }\n"),
                         "it follows itself, by way of"));
  EXPECT_TRUE(test::says(refusal("joints.elbow = { Fv = 1 }\n" + loop), "elbow"));
}

}  // namespace
}  // namespace rivid
