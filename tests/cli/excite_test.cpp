// rivid_excite: the files that it writes, what rivid_simulate and rivid_identify make of them, and what it
// refuses.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <random>

#include "rivid/data/csv.hpp"
#include "rivid/data/table.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/text.hpp"
#include "support/identify_tool.hpp"

namespace {

using rivid::test::content_of;
using rivid::test::Json;
using rivid::test::Outcome;
using rivid::test::outcome_of;
using rivid::test::parameter;
using rivid::test::TemporaryFolder;

const std::filesystem::path arm = std::filesystem::path(RIVID_DATA) / "six_axis";

// Of log det, by the digits of the motion in motion.csv.
constexpr double rounding = 1e-3;

rivid::Matrix matrix(const Json& rows) {
  const auto n = static_cast<rivid::Index>(rows.size());
  rivid::Matrix out(n, n);
  for (rivid::Index i = 0; i < n; ++i) {
    for (rivid::Index k = 0; k < n; ++k) {
      out(i, k) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
    }
  }
  return out;
}

double log_det(const rivid::Matrix& M) { return Eigen::LDLT<rivid::Matrix>(M).vectorD().array().log().sum(); }

class Excite : public testing::Test {
 protected:
  Excite() {
    folder_.write("arm/six_axis.urdf", content_of(arm / "six_axis.urdf"));
    folder_.write("arm/excite.toml", content_of(arm / "excite.toml"));
  }

  [[nodiscard]] Outcome excite(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), RIVID_EXCITE);
    return outcome_of(arguments, folder_.path());
  }

  // A quick design into the folder "plan".
  [[nodiscard]] Json plan(std::vector<std::string> arguments = {}) const {
    std::vector<std::string> all = {"arm/excite.toml",          "--output", "plan", "--starts", "1", "--set",
                                    "excitation.evaluations=60"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Outcome run = excite(all);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return Json::parse(folder_.read("plan/plan.json"));
  }

  void expect_refused(const std::vector<std::string>& arguments, std::string_view words) const {
    const Outcome run = excite(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  }

  // Simulates the plan, whose motion is the reference.
  void simulate() const {
    const Outcome simulated =
        outcome_of({RIVID_SIMULATE, "plan/experiment.toml", "--output", "plan"}, folder_.path());
    ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
    const rivid::Log log = rivid::read_csv(folder_.path() / "plan/log.csv");
    const rivid::Log motion = rivid::read_csv(folder_.path() / "plan/motion.csv");
    ASSERT_EQ(log.q_r.rows(), motion.q.rows());
    EXPECT_LE((log.q_r - motion.q).cwiseAbs().maxCoeff(), 1e-9);
  }

  TemporaryFolder folder_;
};

TEST_F(Excite, WritesAMotionThatSimulatesAndIdentifiesAsForecast) {
  const Json plan_json = plan();
  ASSERT_NO_FATAL_FAILURE(simulate());

  const Outcome identified = outcome_of(
      {RIVID_IDENTIFY, "plan/experiment.toml", "--method", "wls", "--output", "result"}, folder_.path());
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  const Json result = Json::parse(folder_.read("result/result.json"));
  // The robot lags behind its reference and the reported deviations are estimates themselves: the mean over
  // 52 parameters is held to the 15 % that a plan promises.
  double sum = 0.0;
  int inside = 0;
  for (const Json& forecast : plan_json["parameters"]) {
    const Json reported = parameter(result, forecast["name"].get<std::string>());
    sum += std::log(forecast["sigma"].get<double>() / reported["sigma"].get<double>());
    const double truth = forecast["value"];
    inside += reported["interval_95"][0] <= truth && truth <= reported["interval_95"][1] ? 1 : 0;
  }
  const auto count = static_cast<double>(plan_json["parameters"].size());
  EXPECT_EQ(count, 52.0);
  EXPECT_NEAR(std::exp(sum / count), 1.0, 0.15);

  // The same by the tool.
  const Outcome checked = outcome_of(
      {RIVID_IDENTIFY, "plan/experiment.toml", "--method", "wls", "--output", "checked", "--plan", "plan"},
      folder_.path());
  ASSERT_EQ(checked.exit_code, 0) << checked.err;
  EXPECT_NE(checked.out.find("Forecast of plan/plan.json: reported standard deviations are "),
            std::string::npos)
      << checked.out;
  const Json check = Json::parse(folder_.read("checked/plan_check.json"));
  EXPECT_NEAR(check["ratio"].get<double>(), std::exp(-sum / count), 1e-9);
  EXPECT_EQ(check["parameters"].size(), 52U);
  EXPECT_EQ(check["joints"].size(), 6U);
  for (const Json& each : check["parameters"]) {
    const double ratio = each["reported"].get<double>() / each["forecast"].get<double>();
    EXPECT_NEAR(each["ratio"].get<double>(), ratio, 1e-12 * ratio);
    EXPECT_EQ(each["apart"].get<bool>(), ratio > 1.5 || ratio < 1.0 / 1.5) << each;
  }
  // Of 52 intervals one log leaves out more than ten once in ten thousand.
  EXPECT_GE(inside, 42);
}

// The lead's rows are rows like the others: the log of the whole is identified, and counted in the forecast.
TEST_F(Excite, IdentifiesTheLogOfAMotionWithALead) {
  const Json plan_json = plan({"--set", "excitation.lead_from=[1.0,-0.5,0.8,0.0,1.0,-2.0]"});
  ASSERT_NO_FATAL_FAILURE(simulate());
  const double period = 2.0 * std::numbers::pi / plan_json["motion"]["omega_f"].get<double>();
  EXPECT_NEAR(plan_json["duration"].get<double>(),
              plan_json["lead_in"].get<double>() + period + plan_json["lead_out"].get<double>(), 1e-9);
  const Outcome identified = outcome_of(
      {RIVID_IDENTIFY, "plan/experiment.toml", "--method", "wls", "--output", "result", "--plan", "plan"},
      folder_.path());
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  const Json check = Json::parse(folder_.read("result/plan_check.json"));
  EXPECT_NEAR(std::log(check["ratio"].get<double>()), 0.0, 0.15);
}

// Every parameter of the arm is wrong by 20 % in the plan, and its torques saturate at what the drives have.
TEST_F(Excite, KeepsItsMarginsAndForecastsWithAWrongPrior) {
  const Json plan_json = plan();
  std::mt19937_64 random(17);
  Json truth;
  for (const Json& each : plan_json["parameters"]) {
    const double wrong = random() % 2 == 0 ? 0.8 : 1.2;
    truth["parameters"][each["name"].get<std::string>()] = wrong * each["value"].get<double>();
  }
  folder_.write("truth.json", truth.dump());
  // The plan uses these shares by default.
  constexpr double position_share = 0.95;
  constexpr double velocity_share = 0.9;
  constexpr double torque_share = 0.8;
  Json saturation = Json::array();
  for (const Json& limit : plan_json["limits"]) {
    if (limit["quantity"] == "torque") {
      saturation.push_back(std::abs(limit["limit"].get<double>()) / torque_share);
    }
  }
  ASSERT_EQ(saturation.size(), 6U);
  std::string experiment = folder_.read("plan/experiment.toml");
  experiment.insert(experiment.find("[control]") + 9, "\nv_tau_max = " + saturation.dump());
  folder_.write("plan/experiment.toml", experiment);
  const Outcome simulated =
      outcome_of({RIVID_SIMULATE, "plan/experiment.toml", "--parameters", "truth.json", "--output", "plan"},
                 folder_.path());
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const rivid::Log log = rivid::read_csv(folder_.path() / "plan/log.csv");
  const rivid::Index last = log.q.rows() - 1;
  const rivid::Matrix qd = (log.q.bottomRows(last) - log.q.topRows(last)) * log.f_m;
  for (const Json& limit : plan_json["limits"]) {
    const std::string name = limit["joint"];
    const rivid::Index j = name.back() - '1';
    const double most = std::abs(limit["limit"].get<double>());
    if (limit["quantity"] == "position") {
      EXPECT_LE(log.q.col(j).cwiseAbs().maxCoeff(), most / position_share) << name;
    } else if (limit["quantity"] == "velocity") {
      EXPECT_LE(qd.col(j).cwiseAbs().maxCoeff(), most / velocity_share) << name;
    } else if (limit["quantity"] == "torque") {
      EXPECT_LT(log.v_tau.col(j).cwiseAbs().maxCoeff(), most / torque_share) << name;
    }
  }
  // By default errors that last longer than any lag count, too, which a log of ten seconds shows little of:
  // that reports some 20 % more, whatever the prior.
  const Outcome identified = outcome_of({RIVID_IDENTIFY, "plan/experiment.toml", "--method", "wls", "--set",
                                         "method.covariance=\"hac\"", "--output", "result", "--plan", "plan"},
                                        folder_.path());
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  EXPECT_NEAR(Json::parse(folder_.read("result/plan_check.json"))["ratio"].get<double>(), 1.0, 0.15);
  int inside = 0;
  const Json result = Json::parse(folder_.read("result/result.json"));
  for (const auto& [name, value] : truth["parameters"].items()) {
    const Json interval = parameter(result, name)["interval_95"];
    inside += interval[0] <= value && value <= interval[1] ? 1 : 0;
  }
  EXPECT_GE(inside, 42);
}

TEST_F(Excite, WritesSplinesThatOtherToolsRead) {
  const Json plan_json =
      plan({"--set", "excitation.curve=\"spline\"", "--set", "excitation.points=10", "--player", "ros"});
  EXPECT_FALSE(plan_json.contains("motion"));
  for (const Json& limit : plan_json["limits"]) {
    EXPECT_LE(limit["share"].get<double>(), 1.0) << limit;
  }
  EXPECT_NE(folder_.read("plan/joint_trajectory.yaml").find("time_from_start: {sec: 10, nanosec: 0}"),
            std::string::npos);
  ASSERT_NO_FATAL_FAILURE(simulate());
  const Outcome identified = outcome_of(
      {RIVID_IDENTIFY, "plan/experiment.toml", "--method", "wls", "--output", "result", "--plan", "plan"},
      folder_.path());
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  EXPECT_NEAR(Json::parse(folder_.read("result/plan_check.json"))["ratio"].get<double>(), 1.0, 0.15);
}

TEST_F(Excite, WritesTheMotionAtTheControllersRate) {
  const Json json = plan({"--set", "excitation.rate_hz=250"});
  const rivid::Table table = rivid::read_table(folder_.path() / "plan/motion.csv", {});
  EXPECT_EQ(table.values.rows(), 2501);
  EXPECT_EQ(table.values.cols(), 1 + 4 * 6);
  for (const rivid::Index k : {rivid::Index(0), rivid::Index(2500)}) {
    EXPECT_LE(table.values.row(k).segment(7, 12).cwiseAbs().maxCoeff(), 1e-9);
  }
  EXPECT_EQ(json["motion"]["duration"], 10.0);
  EXPECT_EQ(json["provenance"]["options"]["excitation"]["rate_hz"], 250.0);
  for (const Json& limit : json["limits"]) {
    EXPECT_LE(limit["share"].get<double>(), 1.0) << limit;
  }
}

TEST_F(Excite, ForecastsTheSameOfItsOwnMotion) {
  const Json designed = plan();
  const Outcome run =
      excite({"forecast", "arm/excite.toml", "plan/motion.csv", "--output", "again", "--quiet"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json again = Json::parse(folder_.read("again/forecast.json"));
  // Velocities and accelerations are differences of the positions of the file.
  EXPECT_NEAR(again["log_det"].get<double>(), designed["log_det"].get<double>(), 1e-2);
}

// Twice the noise is a quarter of the time, whatever the motion.
TEST_F(Excite, ComparesPlansByTheTimeThatTheyAreWorth) {
  const Json quiet = plan();
  const Outcome noisy = excite({"forecast", "arm/excite.toml", "plan/motion.csv", "--output", "noisy",
                                "--quiet", "--set", "excitation.noise=[0.8, 1, 0.4, 0.2, 0.2, 0.1]"});
  ASSERT_EQ(noisy.exit_code, 0) << noisy.err;
  const Outcome run = excite({"compare", "noisy/forecast.json", "plan", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json found = Json::parse(run.out);
  // Velocities and accelerations of the forecast are differences of the positions of the file.
  constexpr double tolerance = 1e-3;
  EXPECT_NEAR(found["sigma_ratio"].get<double>(), 0.5, tolerance);
  EXPECT_NEAR(found["time"].get<double>(), 40.0, 40.0 * tolerance);
  EXPECT_FALSE(found["same_noise"].get<bool>());
  EXPECT_EQ(found["parameters"].size(), 52U);
  for (const Json& each : found["parameters"]) {
    EXPECT_NEAR(each["ratio"].get<double>(), 0.5, 0.01) << each;
  }
  const Outcome words = excite({"compare", "plan", "plan"});
  EXPECT_NE(words.out.find("plan/plan.json (10 s) is worth 10 s of plan/plan.json (10 s)"), std::string::npos)
      << words.out;
}

TEST_F(Excite, RefusesToCompareWhatIsNoPlan) {
  folder_.write("other.json", "{}");
  expect_refused(
      {"compare", "other.json", "other.json"},
      "other.json: the file is no plan.json of rivid excite: it has no log_det, parameters and duration");
  expect_refused({"compare", "none.json", "other.json"}, "none.json");
}

TEST_F(Excite, AddsToWhatAnEarlierLogTells) {
  const Json first = plan();
  ASSERT_EQ(
      outcome_of({RIVID_SIMULATE, "plan/experiment.toml", "--output", "earlier"}, folder_.path()).exit_code,
      0);
  folder_.write("arm/excite.toml",
                content_of(arm / "excite.toml") +
                    "[log]\nfiles = \"none.csv\"\n[signal]\ncutoff_hz = \"off\"\ndecimation = 10\n");
  const Outcome run = excite({"forecast", "arm/excite.toml", "plan/motion.csv", "--output", "again",
                              "--quiet", "--set", "excitation.known=[\"../earlier/log.csv\"]"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  // What the rows of the log tell, one for ten samples, beside what the plan does.
  const rivid::ExcitationPlan ahead = rivid::read_excitation(folder_.path() / "arm/excite.toml");
  const rivid::Robot& robot = ahead.experiment.robot;
  const rivid::Rows log =
      rivid::rows(robot, rivid::base_parameters(robot), rivid::read_csv(folder_.path() / "earlier/log.csv"),
                  ahead.experiment.estimation.signal);
  rivid::Matrix M = matrix(first["information"]);
  double kept = 0.0;
  for (std::size_t j = 0; j < 6; ++j) {
    const auto& [columns, W] = log.W.joints[j];
    const double sigma = ahead.options.noise.sigma[static_cast<rivid::Index>(j)];
    M(columns, columns) += 10.0 / (sigma * sigma) * W.transpose() * W;
    kept += static_cast<double>(W.rows()) / 6.0 / 1000.0;
  }
  const double both = Json::parse(folder_.read("again/forecast.json"))["log_det"];
  EXPECT_NEAR(both, log_det(M), rounding);
  // The motion once more would be worth b log 2; rows near a reversal are left out, by the velocities of the
  // log here and of the plan there.
  EXPECT_GT(kept, 0.8);
  EXPECT_LT(kept, 1.0);
  const double once_more = 52.0 * std::log(2.0);
  EXPECT_LT(both - first["log_det"].get<double>(), once_more / kept);
  EXPECT_GT(both - first["log_det"].get<double>(), kept * once_more);
}

TEST_F(Excite, RehearsesAMotionBeforeTheRobotMoves) {
  (void)plan();
  const std::vector<std::string> rehearse = {"rehearse", "arm/excite.toml", "plan/motion.csv"};
  const auto with = [&](std::vector<std::string> options) {
    options.insert(options.begin(), rehearse.begin(), rehearse.end());
    return excite(options);
  };
  const Outcome go = with({"--json", "--output", "rehearsed"});
  ASSERT_EQ(go.exit_code, 0) << go.err;
  const Json found = Json::parse(go.out);
  EXPECT_TRUE(found["passes"].get<bool>());
  EXPECT_EQ(found["as_planned"]["status"], "identified");
  EXPECT_EQ(found["as_planned"]["parameters"].size(), 52U);
  ASSERT_EQ(found["troubles"].size(), 11U);
  EXPECT_EQ(found["troubles"][0]["trouble"], "torque_unit");
  EXPECT_EQ(found["troubles"][0]["warnings"][0]["code"], "torque_unit") << found["troubles"][0]["warnings"];
  EXPECT_EQ(Json::parse(folder_.read("rehearsed/rehearsal.json")), found);
  EXPECT_EQ(rivid::read_csv(folder_.path() / "rehearsed/log.csv").samples(), 10001);

  const Outcome soft = with({"--as-planned", "--set", "control.omega_n=[2, 2, 2, 2, 2, 2]"});
  EXPECT_EQ(soft.exit_code, 1) << soft.out;
  EXPECT_NE(soft.out.find("No go: "), std::string::npos) << soft.out;
  EXPECT_NE(soft.out.find("rehearsal_failed"), std::string::npos) << soft.out;

  expect_refused({"rehearse", "arm/excite.toml", "plan/motion.csv", "--spread", "2"}, "--spread");
  expect_refused({"rehearse", "arm/excite.toml", "none.csv"}, "none.csv");
  expect_refused({"rehearse", "plan/motion.csv", "plan/motion.csv"}, "plan/motion.csv");
}

TEST_F(Excite, GivesTheSameMotionForTheSameSeed) {
  const Json a = plan()["motion"];
  EXPECT_EQ(plan({"--threads", "2"})["motion"], a);
  EXPECT_NE(plan({"--seed", "9"})["motion"], a);
}

TEST_F(Excite, ShowsWhatWillBeKnown) {
  const Outcome run = excite({"arm/excite.toml", "--starts", "1", "--set", "excitation.evaluations=20"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("Motion of 10 s: 52 base parameters: "), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("forecast σ"), std::string::npos);
  EXPECT_EQ(run.err,
            "wrote excite_excitation/motion.csv\nwrote excite_excitation/experiment.toml\n"
            "wrote excite_excitation/plan.json\n");
}

TEST_F(Excite, RefusesPlayersOfOtherRobots) {
  expect_refused({"arm/excite.toml", "--player", "libfranka"},
                 "arm/excite.toml: player \"libfranka\": the robot has 6 joints, must have 7");
  expect_refused({"arm/excite.toml", "--player", "ur"},
                 "\"ur\" is none of \"ros\", \"urscript\" and \"libfranka\"");
  const Outcome run = excite({"arm/excite.toml", "--dry-run", "--player", "ros", "--player", "ros"});
  EXPECT_NE(run.out.find("would write excite_excitation/joint_trajectory.yaml"), std::string::npos)
      << run.out;
}

TEST_F(Excite, WritesNothingOnADryRun) {
  const Outcome run = excite({"arm/excite.toml", "--dry-run"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("excitation.limits.velocity_share"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("would write excite_excitation/plan.json"), std::string::npos) << run.out;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "excite_excitation"));
}

TEST_F(Excite, EndsInTime) {
  const Json json = plan({"--seconds", "1", "--set", "excitation.evaluations=1000000"});
  EXPECT_EQ(json["stopped"], true);
}

TEST_F(Excite, RefusesASpaceThatCanNotBeKept) {
  // 300 mm, typed for metres.
  expect_refused(
      {"arm/excite.toml", "--set", "excitation.space.floor=300"},
      "arm: distance to floor is -300 m where it must be at least 0.03 m; see to [excitation.space]");
  expect_refused({"arm/excite.toml", "--set",
                  "excitation.space.boxes=[{name=\"crate\", min=[-3, -3, -3], max=[3, 3, 3]}]"},
                 "arm: distance to crate is -2.");
  expect_refused({"arm/excite.toml", "--set",
                  "excitation.space.half_spaces=[{name=\"left\", normal=[0, 1, "
                  "0], offset=0.1}]"},
                 "arm: distance to left is ");
}

TEST_F(Excite, TellsTheSmallestDistanceOfEachPair) {
  const Json json = plan({"--set", "excitation.space.floor=0.1", "--player", "ros"});
  const Json& pairs = json["clearances"];
  const auto of = [&](const std::string& first, const std::string& second) {
    return std::ranges::count_if(
        pairs, [&](const Json& pair) { return pair["first"] == first && pair["second"] == second; });
  };
  EXPECT_EQ(of("arm", "floor"), 1);
  EXPECT_EQ(of("elbow", "floor"), 1);
  EXPECT_EQ(of("base", "elbow"), 1);
  EXPECT_EQ(of("base", "arm"), 1);  // which no pose keeps apart
  for (const Json& pair : pairs) {
    EXPECT_EQ(pair["wanted"].is_null(), pair["first"] == "base" && pair["second"] == "arm") << pair;
    EXPECT_TRUE(pair["wanted"].is_null() || pair["distance"] >= pair["wanted"]) << pair;
  }
  const Json& nearest = pairs.front();
  const std::string played = folder_.read("plan/joint_trajectory.yaml");
  EXPECT_NE(
      played.find("# Smallest distance: " + rivid::number(nearest["distance"].get<double>(), 4) + " m, " +
                  nearest["first"].get<std::string>() + " from " + nearest["second"].get<std::string>() +
                  ".\n# Not kept apart, since near in every pose: -0.12 m, base from arm.\n"),
      std::string::npos)
      << played.substr(0, 500);
}

TEST_F(Excite, RefusesWithTheJointAndTheNumber) {
  expect_refused(
      {"arm/excite.toml", "--set", "excitation.limits.torque=[100, 1, 60, 30, 30, 20]", "--set",
       "excitation.limits.lower=1", "--set", "excitation.limits.upper=1.2"},
      "no pose was found in which the robot can rest within its limits; in the best of 1000 random ones "
      "joint_2: torque is ");
  expect_refused({"arm/excite.toml", "--set", "excitation.start=[0, 0, 0, 0, 9, 0]"},
                 "joint_5: position is 9 where it may be ");
  expect_refused({"arm/excite.toml", "--set", "excitation.limits.velocity=[1, 2]"},
                 "velocity has 2 entries, must have one for each of the 6 joints");
  expect_refused(
      {"arm/excite.toml", "--set", "excitation.curve=\"spline\"", "--set", "excitation.duration=9.9995"},
      "duration is 9.9995 s, must be a whole number of samples of 1000 Hz for curve = \"spline\"");
  expect_refused({"arm/excite.toml", "--set", "excitation.curve=\"spline\"", "--player", "urscript"},
                 "player \"urscript\": the program evaluates a Fourier series");
  expect_refused({"arm/excite.toml", "--set", "excitation.harmonics=1"},
                 "harmonics is 1, must lie between 2 and 50");
  expect_refused({"arm/excite.toml", "--set", "excitation.harmonic=4"}, "did you mean \"harmonics\"");
  folder_.write("arm/excite.toml", "[robot]\nurdf = \"six_axis.urdf\"\n");
  expect_refused({"arm/excite.toml"}, "section [excitation] is missing");
}

}  // namespace
