// Two arms that mirror each other on a torso, with frames and axes that do not, simulated in closed loop and
// identified with ties and without.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "support/complaint.hpp"
#include "support/temporary_folder.hpp"
#include "support/two_arms.hpp"

namespace rivid {
namespace {

// forearm  mass of the right one; the left one's is 2
std::string torso(double forearm) {
  std::string out = "<robot name=\"torso\"><link name=\"base\"/>";
  const auto add = [&](const std::string& joint, const std::string& parent, const std::string& child,
                       const std::string& origin, const std::string& axis, double mass,
                       const std::string& com, const std::string& I) {
    out += "<link name=\"" + child + "\"><inertial><origin xyz=\"" + com + "\"/><mass value=\"" +
           std::to_string(mass) + "\"/><inertia " + I + "/></inertial></link><joint name=\"" + joint +
           "\" type=\"revolute\"><origin " + origin + "/><parent link=\"" + parent + "\"/><child link=\"" +
           child + "\"/><axis xyz=\"" + axis +
           "\"/><limit lower=\"-3\" upper=\"3\" velocity=\"9\" effort=\"300\"/></joint>";
  };
  const std::string upper = R"(ixx="0.040" iyy="0.042" izz="0.010" ixz="-0.002")";
  const std::string fore = R"(ixx="0.011" iyy="0.052" izz="0.047" iyz="-0.001")";
  const std::string hand = R"(ixx="0.006" iyy="0.009" izz="0.008" iyz="0.0005")";
  add("waist", "base", "torso", "xyz=\"0 0 0.5\"", "0 0 1", 12.0, "0.02 0.01 0.2",
      R"(ixx="0.30" iyy="0.28" izz="0.12" ixy="0.01" ixz="0.02" iyz="-0.01")");
  add("left_shoulder", "torso", "left_upper", "xyz=\"0 0.2 0.4\"", "0 1 0", 3.0, "0.01 0.05 -0.1",
      upper + R"( ixy="0.001" iyz="0.003")");
  add("left_elbow", "left_upper", "left_fore", "xyz=\"0 0.02 -0.3\"", "0 0 1", 2.0, "0.12 0.01 0.01",
      fore + R"( ixy="0.002" ixz="0.003")");
  add("left_wrist", "left_fore", "left_hand", "xyz=\"0.28 0 0\"", "1 0 0", 1.2, "0.05 -0.02 0.09",
      hand + R"( ixy="0.0008" ixz="-0.0006")");
  add("right_shoulder", "torso", "right_upper", "xyz=\"0 -0.2 0.4\"", "0 1 0", 3.0, "0.01 -0.05 -0.1",
      upper + R"( ixy="-0.001" iyz="-0.003")");
  // This forearm's frame is turned by half a turn about its axis, which points down.
  add("right_elbow", "right_upper", "right_fore", "xyz=\"0 -0.02 -0.3\" rpy=\"0 0 3.141592653589793\"",
      "0 0 -1", forearm, "-0.12 0.01 0.01", fore + R"( ixy="-0.002" ixz="-0.003")");
  add("right_wrist", "right_fore", "right_hand", "xyz=\"-0.28 0 0\"", "-1 0 0", 1.2, "-0.05 -0.02 0.09",
      hand + R"( ixy="-0.0008" ixz="0.0006")");
  return out + "</robot>";
}

std::string robot_section(const std::string& ties, double Fc_elbow = 1.5) {
  std::string out =
      "[robot]\nurdf = \"torso.urdf\"\nfriction = \"coulomb\"\n[robot.joints.waist]\n"
      "Ia = 0.5\nFv = 3.0\nFc = 4.0\n";
  for (const std::string side : {"left", "right"}) {
    for (const std::string part : {"shoulder", "elbow", "wrist"}) {
      const double size = part == "shoulder" ? 2.0 : part == "elbow" ? 1.0 : 0.3;
      const double Fc = side == "right" && part == "elbow" ? Fc_elbow : 1.5 * size;
      out += "[robot.joints." + side + "_" + part + "]\nIa = " + std::to_string(0.1 * size) +
             "\nFv = " + std::to_string(size) + "\nFc = " + std::to_string(Fc) + "\n";
      if (side == "right" && ties.find(part) != std::string::npos) {
        out += "same_as = \"left_" + part + "\"\n";
      }
    }
  }
  return out;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

const std::string every = "shoulder elbow wrist";

const std::string study = R"(
[control]
law = "pd"
omega_n = [20, 20, 25, 30, 20, 25, 30]
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
disturbance = [0.4, 0.3, 0.2, 0.1, 0.3, 0.2, 0.1]

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

[[montecarlo.trial]]
label = "OLS"
name = "ols"
signal = { cutoff_hz = "off", torque_held = true, decimation = 10 }
)";

class Twins : public testing::Test {
 protected:
  Twins() {
    write_urdf(2.0);
    folder_.write("reference.csv", test::random_fourier(7, 12, 9, {0.7, 0.6, 0.8, 1.0, 0.6, 0.8, 1.0}));
  }

  void write_urdf(double forearm) { folder_.write("torso.urdf", torso(forearm)); }
  [[nodiscard]] std::filesystem::path path(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] MonteCarlo plan(const std::string& robot) {
    folder_.write("study.toml", robot + study);
    return read_monte_carlo(path("study.toml"));
  }
  // By weighted least squares.
  [[nodiscard]] Identification identified(const std::string& robot) {
    const MonteCarlo read = plan(robot);
    return identify(read.experiment.robot, run_simulation(read.experiment).log,
                    read.trials[1].experiment.estimation);
  }

  test::TemporaryFolder folder_;
};

TEST_F(Twins, ShareWhatBothArmsSayAndCoverTheTruth) {
  const MonteCarlo tied = plan(robot_section(every));
  const MonteCarlo plain = plan(robot_section(""));
  const BaseParameters base = base_parameters(tied.experiment.robot);
  const Vector truth = base.from_standard(tied.experiment.robot.chi_st());
  for (std::size_t trial = 0; trial < tied.trials.size(); ++trial) {
    double squares = 0.0;
    double squares_plain = 0.0;
    Index count = 0;
    Index inside = 0;
    Vector narrower = Vector::Zero(base.size());
    for (int run = 0; run < tied.runs; ++run) {
      const MonteCarloRow row = monte_carlo_run(tied, run)[trial];
      const MonteCarloRow other = monte_carlo_run(plain, run)[trial];
      ASSERT_EQ(row.status, "identified") << tied.trials[trial].label << ", run " << run;
      const Vector error = (row.value - truth).array() / row.sigma.array();
      squares += error.squaredNorm();
      squares_plain += ((row.value - truth).array() / other.sigma.array()).matrix().squaredNorm();
      count += error.size();
      inside += (error.array().abs() < 1.96).count();
      narrower += row.sigma.cwiseQuotient(other.sigma) / tied.runs;
    }
    const auto n = static_cast<double>(count);
    const std::string& label = tied.trials[trial].label;
    // Some 490 errors, of which those of one log depend on each other.
    EXPECT_NEAR(std::sqrt(squares / n), 1.0, 0.2) << label;
    EXPECT_GE(static_cast<double>(inside) / n, 0.93) << label;
    // Twice the data for all that is of an arm; the errors are smaller, and not only what is said of them.
    const double mean = std::exp(narrower.array().log().mean());
    EXPECT_LT(mean, 1.0 / std::numbers::sqrt2) << label;
    EXPECT_LT(std::sqrt(squares_plain / n), 1.0 / std::numbers::sqrt2) << label;
  }
}

TEST_F(Twins, AreReflectedByTheGeometryOrByStatedSigns) {
  const Identification found = identified(robot_section(every));
  const auto value = [&](const std::string& name) {
    const auto at = std::ranges::find(found.parameters, name, &ParameterEstimate::name);
    return at == found.parameters.end() ? std::nan("") : at->value;
  };
  for (const auto& [left, right, sign] : {std::tuple("Fv2", "Fv5", 1.0),
                                          {"Fc3", "Fc6", 1.0},
                                          {"Ia4", "Ia7", 1.0},
                                          {"XY4", "XY7", -1.0},
                                          {"XZ4", "XZ7", -1.0},
                                          {"YZ4", "YZ7", 1.0},
                                          {"MY4", "MY7", 1.0},
                                          {"XY2", "XY5", -1.0}}) {
    EXPECT_NEAR(value(left), sign * value(right), 1e-9) << left;
  }
  const std::string stated =
      replaced(robot_section(every), "\"left_elbow\"", "\"left_elbow\"\nmirror = [-1, 1, 1]");
  EXPECT_LT((identified(stated).chi - found.chi).norm(), 1e-9 * found.chi.norm());
}

TEST_F(Twins, AreAlikeInThePhysicalParameters) {
  const MonteCarlo read = plan(robot_section(every));
  const Robot& robot = read.experiment.robot;
  Estimation estimation = read.trials[1].experiment.estimation;
  estimation.physical = Physical();
  const Identification found = identify(robot, run_simulation(read.experiment).log, estimation);
  ASSERT_TRUE(found.physical);
  const std::vector<StandardParameter> standard = robot.standard_parameters();
  const auto value = [&](const std::string& name) {
    const auto at = std::ranges::find(standard, name, &StandardParameter::name);
    return found.physical->parameters.chi_st[at - standard.begin()];
  };
  for (const int left : {2, 3, 4}) {
    for (const std::string kind : {"M", "XX", "YY", "ZZ", "MZ", "Ia", "Fv", "Fc"}) {
      const double of_left = value(kind + std::to_string(left));
      EXPECT_NEAR(value(kind + std::to_string(left + 3)), of_left, 1e-4 * std::abs(of_left)) << kind << left;
    }
    EXPECT_NEAR(value("MY" + std::to_string(left)),
                value("MY" + std::to_string(left + 3)) * (left == 2 ? -1.0 : 1.0), 1e-5);
  }
}

TEST_F(Twins, ThatDifferAreFound) {
  const auto differing = [](const Identification& found) {
    std::vector<std::string> out;
    for (const Finding& finding : found.warnings) {
      if (finding.code == "twins_differ") {
        out.push_back(finding.subject);
      }
    }
    return out;
  };
  const Identification alike = identified(robot_section(every));
  EXPECT_TRUE(differing(alike).empty());
  EXPECT_TRUE(std::ranges::any_of(
      alike.notes, [](const std::string& note) { return test::says(note, "and the data agree"); }));
  EXPECT_EQ(differing(identified(robot_section(every, 1.8))), std::vector<std::string>{"right_elbow"});
  write_urdf(2.2);
  EXPECT_EQ(differing(identified(robot_section(every))), std::vector<std::string>{"right_elbow"});
  EXPECT_TRUE(differing(identified(robot_section("shoulder"))).empty());
  // As the hint writes it.
  const std::string untied = replaced(robot_section(every), "\"left_elbow\"", "\"\"");
  EXPECT_TRUE(plan(untied).experiment.robot.joints[5].same_as.empty());
}

TEST_F(Twins, FaultsNameTheJoint) {
  const auto refusal = [&](const std::string& from, const std::string& to) {
    return test::complaint_of([&] { return identified(replaced(robot_section(every), from, to)); });
  };
  EXPECT_TRUE(test::says(refusal("\"left_elbow\"", "\"left_elbou\""),
                         "joint \"right_elbow\": same_as is \"left_elbou\", which is no joint of the robot"));
  EXPECT_TRUE(
      test::says(refusal("\"left_elbow\"", "\"right_shoulder\""), "name that one, \"left_shoulder\""));
  EXPECT_TRUE(test::says(refusal("\"left_elbow\"", "\"left_wrist\""), "places that mirror each other"));
  EXPECT_TRUE(test::says(refusal("\"left_elbow\"", "\"left_elbow\"\nmirror = [1, 0, 1]"), "three signs"));
}

}  // namespace
}  // namespace rivid
