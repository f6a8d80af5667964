// [control], [reference] and [simulation] of an experiment file.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rivid/experiment/experiment.hpp"
#include "support/complaint.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

const std::string control = "[control]\nlaw = \"pd\"\nomega_n = 10\nrate_hz = 100\n";
const std::string reference =
    "[reference]\ntype = \"point_to_point\"\nvia = [[0, 0], [1, 1]]\ndurations = 1\n";
const std::string simulation = "[simulation]\n";

class SimulationSections : public testing::Test {
 protected:
  [[nodiscard]] Experiment read(const std::string& text, Use use = Use::simulation) const {
    folder_.write("run.toml", "robot.urdf = \"" RIVID_DATA "/scara/scara.urdf\"\n" + text);
    return read_experiment(folder_.path() / "run.toml", use);
  }

  [[nodiscard]] std::string refusal(const std::string& text, Use use = Use::simulation) const {
    return test::complaint_of([&] { return read(text, use); });
  }

  void expect_refused(const std::string& text, const std::vector<std::string_view>& words,
                      Use use = Use::simulation) const {
    const std::string told = refusal(text, use);
    for (const std::string_view word : words) {
      EXPECT_NE(told.find(word), std::string::npos) << told << "\nis without\n" << word << "\nfor\n" << text;
    }
  }

  [[nodiscard]] ControlDescription law_of(const std::string& section) const {
    const Experiment experiment = read(section + reference + simulation + "rate_hz = 100\n");
    const DynamicModel model(experiment.robot, experiment.robot.chi_st());
    return experiment.control->control({experiment.robot, model, Vector{{4.0, 0.1}}})->description();
  }

  test::TemporaryFolder folder_;
};

TEST_F(SimulationSections, AreAllThatASimulationNeeds) {
  const Experiment experiment = read(control + reference + simulation);
  EXPECT_EQ(experiment.simulation->options.f_m, 100.0) << "the controller's, where nothing else is said";
  EXPECT_TRUE(experiment.simulation->noise.feedback);
  EXPECT_EQ(experiment.control->omega_n, Vector::Constant(2, 10.0));
  EXPECT_FALSE(experiment.control->assumed);
  expect_refused(control + simulation, {"section [reference] is missing"});
  expect_refused(reference + simulation, {"section [control] is missing"});
  expect_refused(control + reference, {"section [simulation] is missing"});
  expect_refused(control + reference + simulation, {"section [log] is missing"}, Use::identification);
}

TEST_F(SimulationSections, AreCheckedForAnIdentificationToo) {
  const std::string log = "[log]\nfiles = \"a.csv\"\n[signal]\ncutoff_hz = 20\n";
  EXPECT_EQ(refusal(log, Use::identification), "");
  EXPECT_EQ(refusal(log + control + reference + simulation, Use::identification), "");
  expect_refused(log + "[control]\nlaw = \"pdd\"\n", {"[control] law is \"pdd\", must be one of \"pd\""},
                 Use::identification);
  expect_refused(log + "[simulaton]\n", {"unknown key \"simulaton\"; did you mean \"simulation\"?"},
                 Use::identification);
}

TEST_F(SimulationSections, TakeEveryLawByPolesAndByGains) {
  EXPECT_EQ(law_of("[control]\nlaw = \"pd\"\nomega_n = [1, 10]\n").gains[1].values, (Vector{{8.0, 2.0}}));
  EXPECT_EQ(law_of("[control]\nlaw = \"pd\"\nk_p = 5\nk_v = [8, 2]\n").gains[1].values, (Vector{{8.0, 2.0}}));
  EXPECT_EQ(law_of("[control]\nlaw = \"pd\"\nk_p = 5\nk_v = 8\nJ_apriori = [2, 0.2]\n").gains[1].values,
            (Vector{{16.0, 4.0}}));
  EXPECT_EQ(law_of("[control]\nlaw = \"pid\"\nK_p = 5\nK_i = 1\nK_d = 2\ntracking_time = 1\n").law, "PID");
  EXPECT_EQ(law_of("[control]\nlaw = \"cascade\"\nomega_n = 10\nomega_i = 1\nfeed_forward = 0.5\n").law,
            "cascade");
  EXPECT_EQ(law_of("[control]\nlaw = \"computed_torque\"\nk_p = 100\nk_d = 20\nmodel = \"a_priori\"\n")
                .gains[0]
                .values,
            Vector::Constant(2, 100.0));
}

TEST_F(SimulationSections, TellWhichKeyOfTheControlIsWrong) {
  const auto refused = [&](const std::string& section, const std::vector<std::string_view>& words) {
    expect_refused("[control]\n" + section + reference + simulation, words);
  };
  refused("", {":2:1: [control] must name its law"});
  refused("low = \"pd\"\n", {":3:1: unknown key \"low\" in [control]; did you mean \"law\"?"});
  refused("law = \"pd\"\nK_p = 1\nk_v = 2\n",
          {":4:1: unknown key \"K_p\" in [control]; did you mean \"k_p\"?"});
  refused("law = \"pd\"\nomega_n = [1, 2, 3]\n",
          {":4:11: [control] omega_n has 3 entries, must have one for each"});
  refused("law = \"pd\"\nomega_n = [1]\n", {":4:11: [control] omega_n has 1 entry, must have one for each"});
  refused("law = \"pd\"\nk_p = 1\nk_v = 0\n",
          {"[control] k_v of joint \"joint_1\" is 0, must be finite and of the sign"});
  refused("law = \"pd\"\nk_p = 1\nk_v = 1\nomega_n = 1\n", {"give either omega_n and zeta, or k_p and k_v"});
  refused("law = \"pd\"\nomega_n = 1\ndelay = 1\n", {":5:9: [control] delay goes with rate_hz"});
  refused("law = \"pd\"\nomega_n = 1\nrate_hz = 0\n", {"[control] rate_hz is 0 Hz, must be positive"});
  refused("law = \"pd\"\nomega_n = 1\nrate_hz = 100\ndelay = -1\n",
          {":6:9: [control] delay is -1 periods, must not be negative"});
  refused("law = \"pd\"\nomega_n = 1\nrate_hz = 100\nvelocity_filter = \"center\"\n",
          {"velocity_filter is \"center\", must be one of \"backward\"", "\"central\" and \"none\""});
}

TEST_F(SimulationSections, SampleTheController) {
  const Sampling sampling = read(
                                "[control]\nlaw = \"pd\"\nomega_n = 1\nrate_hz = 1000\ndelay = 2\n"
                                "velocity_filter = \"central\"\nquantum = 1e-4\nreference_lead = 1\n" +
                                reference + simulation)
                                .control->sampling;
  EXPECT_EQ(sampling.period, 1e-3);
  EXPECT_EQ(sampling.delay, 2);
  EXPECT_EQ(sampling.velocity_filter, (std::vector<double>{0.5, 0.0, -0.5}));
  EXPECT_EQ(sampling.quantum, Vector::Constant(2, 1e-4));
  EXPECT_EQ(sampling.reference_lead, 1);
}

TEST_F(SimulationSections, TellWhichKeyOfTheReferenceIsWrong) {
  const auto refused = [&](const std::string& section, const std::vector<std::string_view>& words) {
    expect_refused(control + "[reference]\n" + section + simulation, words);
  };
  refused("", {"[reference] must say its type"});
  refused("type = \"sine\"\n",
          {"type is \"sine\", must be one of \"logged\", \"fourier\" and \"point_to_point\""});
  refused("type = \"point_to_point\"\n", {"must list the points, via"});
  refused("type = \"point_to_point\"\nvia = [[0, 0], [1]]\n",
          {":8:16: [reference] via must be lists of 2 numbers: one list a point, one number a joint"});
  refused("type = \"point_to_point\"\nvia = [[0, 0], [1, 1]]\n", {"[reference] ", "durations"});
  refused("type = \"point_to_point\"\nvia = [[0, 0], [1, 1]]\nduration = 1\n",
          {":9:1: unknown key \"duration\" in [reference]; did you mean \"durations\"?"});
  refused("type = \"fourier\"\nA = [[1], [1]]\nB = [[0], [0]]\n", {"must say omega_f"});
  refused("type = \"fourier\"\nomega_f = 1\n", {"must list A and B, or name a file of coefficients"});
  refused("type = \"fourier\"\nomega_f = 1\nA = [[1], [1, 2]]\nB = [[0], [0]]\n",
          {":9:11: [reference] A must be 2 lists of numbers"});
  refused("type = \"logged\"\nposition = [\"q1\", \"q2\"]\n", {":8:12: [reference] position goes with file"});
  refused("type = \"logged\"\nfile = \"a.csv\"\nunits = { position = \"deg\" }\n",
          {"[reference] units names \"position\", whose columns are not listed beside it"});
}

TEST_F(SimulationSections, TakeTheCoefficientsOfASeriesFromAFile) {
  folder_.write("series.csv", "B1,B2,A1,A2\n5,6,1,2\n7,8,3,4\n");
  const std::string head = control + "[reference]\ntype = \"fourier\"\nomega_f = 2\n";
  const auto series = [&](const std::string& text) {
    return std::get<FourierSeries>(read(head + text + simulation).reference->motion);
  };
  const FourierSeries from_file = series("file = \"series.csv\"\nq0 = 0.5\n");
  const FourierSeries inline_ = series("A = [[1, 3], [2, 4]]\nB = [[5, 7], [6, 8]]\n");
  EXPECT_EQ(from_file.A, inline_.A);
  EXPECT_EQ(from_file.B, inline_.B);
  EXPECT_EQ(from_file.q0, Vector::Constant(2, 0.5));
}

TEST_F(SimulationSections, TellWhichKeyOfTheSimulationIsWrong) {
  const auto refused = [&](const std::string& section, const std::vector<std::string_view>& words) {
    expect_refused(control + reference + "[simulation]\n" + section, words);
  };
  refused("rtol = 0\n", {":11:8: [simulation] rtol is 0, must be between 1e-15 and 1"});
  refused("rate_hz = -1\n", {"[simulation] rate_hz is -1 Hz, must be positive"});
  refused("duration = 0\n", {"[simulation] duration is 0 s, must be positive"});
  refused("position_noise = -1\n", {":11:18: [simulation] position_noise of joint 1 is -1"});
  refused("seed = -1\n", {"seed is -1, must not be negative"});
  refused("torque_noise = 1\n", {":11:16: [simulation] torque_noise is an error of the recorded torques"});
  refused("record = [\"torques\"]\n", {"record is \"torques\"", "did you mean \"torque\"?"});
  refused("integrator = \"rk4\"\n", {"rk4 knows no events; friction must be smooth or held"});
  refused("added_control = { file = \"a.csv\" }\n", {"must name file and columns"});
  refused("q_0 = [0, 0, 0]\n", {"q_0 has 3 entries"});
  refused("parameters = \"\"\n", {"parameters must name a file"});
  expect_refused("[control]\nlaw = \"pd\"\nomega_n = 1\n" + reference + simulation,
                 {"[simulation] must say rate_hz, the rate of the log: the law is continuous"});
  expect_refused("[control]\nlaw = \"pd\"\nomega_n = 1\n" + reference +
                     "[simulation]\nrate_hz = 9\nnoise_feedback = true\n",
                 {"noise_feedback is true, but the law of [control] is continuous"});
}

TEST_F(SimulationSections, RunWithWhatTheySay) {
  const Experiment experiment = read(control + "quantum = 1e-3\nassumed = true\n" + reference +
                                     "[simulation]\nduration = 1.5\nrate_hz = 50\nrecord = [\"torque\", "
                                     "\"reference\", \"reference_velocity\"]\n"
                                     "seed = 4\n");
  const SimulationRecord record = run_simulation(experiment);
  EXPECT_EQ(record.simulation.outcome, Outcome::completed) << record.simulation.reason;
  EXPECT_EQ(record.log.samples(), 76);
  EXPECT_EQ(record.log.f_m, 50.0);
  EXPECT_EQ(record.log.v_tau.size(), 0);
  EXPECT_EQ(record.log.tau.cols(), 2);
  EXPECT_EQ(record.log.qd_r.cols(), 2);
  EXPECT_EQ(record.seed, 4U);
  EXPECT_EQ(record.control_hz, 100.0);
  EXPECT_TRUE(record.control_assumed);
  const Matrix steps = record.log.q / 1e-3;
  EXPECT_LT((steps.array() - steps.array().round()).abs().maxCoeff(), 1e-9);
}

TEST_F(SimulationSections, TellTheProgressOfASimulation) {
  const Experiment experiment = read(control + reference + "[simulation]\nduration = 20\n");
  std::vector<double> told;
  const SimulationRecord record = run_simulation(experiment, [&](std::string_view stage, double fraction) {
    EXPECT_EQ(stage, "simulating");
    told.push_back(fraction);
  });
  EXPECT_EQ(record.log.samples(), 2001);
  ASSERT_GE(told.size(), 4U);
  EXPECT_TRUE(std::ranges::is_sorted(told));
  EXPECT_GT(told.front(), 0.0);
  EXPECT_LE(told.back(), 1.0);
}

TEST_F(SimulationSections, FollowTheReferenceOfALogOrOfAFile) {
  std::string rows = "t,q1,q2,qref1,qref2\n";
  for (int k = 0; k <= 100; ++k) {
    const double t = 0.01 * k;
    const double q = 0.1 * (1.0 - std::cos(2.0 * std::numbers::pi * t));
    rows += std::to_string(t) + ",0,0," + std::to_string(q) + "," + std::to_string(q) + "\n";
  }
  folder_.write("motion.csv", rows);
  const std::string log = "[log]\nfiles = \"motion.csv\"\n";
  const SimulationRecord of_log =
      run_simulation(read(log + control + "[reference]\ntype = \"logged\"\n" + simulation));
  EXPECT_EQ(of_log.log.samples(), 101);
  EXPECT_NEAR(of_log.log.q_r(50, 0), 0.2, 1e-6);
  const std::string of_file = "[reference]\ntype = \"logged\"\nfile = \"motion.csv\"\n";
  EXPECT_EQ(run_simulation(read(control + of_file + simulation)).log.q, of_log.log.q);
  const Experiment lines = read(control + of_file + "interpolation = \"linear\"\n" + simulation);
  EXPECT_NEAR(run_simulation(lines).log.q_r(50, 0), 0.2, 1e-6);
  EXPECT_TRUE(test::says(test::complaint_of([&] {
                           return run_simulation(
                               read(control + "[reference]\ntype = \"logged\"\n" + simulation));
                         }),
                         "names no file, and there is no [log]"));
}

TEST_F(SimulationSections, AddControlSignalsBehindTheController) {
  folder_.write(
      "pulses.csv", "p,zero\n" + [] {
        std::string rows;
        for (int k = 0; k < 100; ++k) {
          rows += (k >= 20 && k < 40 ? "2,0\n" : "0,0\n");
        }
        return rows;
      }());
  const Experiment experiment = read(
      control + reference +
      "[simulation]\nrecord = [\"torque\", \"control\"]\n"
      "added_control = { file = \"pulses.csv\", columns = [{ column = \"p\", scale = 1.5 }, \"zero\"] }\n");
  EXPECT_EQ(experiment.inputs(Use::simulation).back(), folder_.path() / "pulses.csv");
  const Log log = run_simulation(experiment).log;
  EXPECT_NEAR(log.tau(30, 0) - log.v_tau(30, 0), 3.0, 1e-12);
  EXPECT_EQ(log.tau(50, 0), log.v_tau(50, 0));
  EXPECT_EQ(log.tau(30, 1), log.v_tau(30, 1));
}

}  // namespace
}  // namespace rivid
