#include "rivid/report/html.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "rivid/finding.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/signal/filter.hpp"
#include "support/random_matrix.hpp"
#include "support/robots.hpp"

namespace rivid {
namespace {

std::size_t count(std::string_view text, std::string_view word) {
  std::size_t out = 0;
  for (std::size_t at = text.find(word); at != std::string_view::npos;
       at = text.find(word, at + word.size())) {
    ++out;
  }
  return out;
}

// A SCARA that swings, with noise on its torques, and what is found of it.
struct Study {
  static constexpr Index samples = 2000;

  Robot robot = test::scara();
  Log log;
  Identification result;
  std::vector<Prediction> predictions;
  Provenance provenance = {
      .program = "a test", .inputs = {{"study.toml", std::string(64, '0')}}, .overrides = {}};

  explicit Study(const std::string& joint = "joint_1") {
    robot.joints[0].name = joint;
    const BaseParameters base = base_parameters(robot);
    log.source = "swing.csv";
    log.f_m = 200.0;
    log.t = Vector::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) / log.f_m);
    log.q.resize(samples, 2);
    log.q.col(0) = (2.0 * log.t.array()).sin() + 0.3 * (7.1 * log.t.array()).cos();
    log.q.col(1) = (3.0 * log.t.array()).cos() + 0.2 * (9.3 * log.t.array()).sin();
    const Vector Y = observation(robot, base, differentiate(log.q, log.f_m)).dense() *
                     Vector::LinSpaced(base.size(), 0.5, 2.0);
    log.tau = Y.reshaped(samples, 2) + 0.1 * test::random_matrix(samples, 2, 7);
    result = identify(robot, log,
                      {.method = Ols{}, .signal = {.cutoff_hz = 20.0, .decimation = {10}}, .judge = false});
    predictions.push_back(predict(robot, result, log));
  }

  [[nodiscard]] std::string page() const { return html_report(robot, result, predictions, provenance); }
};

// A page of so many joints and rows.
std::string large_page(Index joints, Index rows) {
  Robot robot;
  robot.name = "large";
  Identification result;
  Prediction log{.source = "large.csv", .f_m = 1000.0};
  for (Index j = 0; j < joints; ++j) {
    const std::string name = "joint_" + std::to_string(j + 1);
    robot.joints.push_back({.name = name, .link = name, .friction = Friction::none});
    result.fit.joints.push_back({.name = name, .unit = "N·m", .rows = rows, .relative_error = 0.5});
    const Matrix noise = test::random_matrix(rows, 8, static_cast<unsigned>(3 + j));
    JointPrediction& joint = log.joints.emplace_back();
    joint.measured = noise.col(0);
    joint.residual = noise.col(1);
    joint.fitted = {noise.col(2), noise.col(3), noise.col(0), noise.col(4),   noise.col(5),
                    noise.col(6), noise.col(7), noise.col(1), Vector::Zero(0)};
    for (Index k = 0; k < rows; ++k) {
      joint.rows.push_back(k);
    }
  }
  robot.chain.links.resize(static_cast<std::size_t>(joints));
  robot.inertials.assign(static_cast<std::size_t>(joints), Inertial::Zero());
  return html_report(robot, result, std::span(&log, 1), {});
}

TEST(HtmlReport, EscapesWhatOthersWrote) {
  const std::string hostile = "<i onload='x'>&\"</script>";
  const std::string harmless = "&lt;i onload=&#39;x&#39;&gt;&amp;&quot;&lt;/script&gt;";
  Study study(hostile);
  study.robot.name = hostile + "robot";
  study.predictions[0].source = hostile + "log";
  study.result.reasons = {hostile + "reason"};
  study.result.warnings = {
      {.code = hostile + "code", .subject = hostile + "subject", .text = hostile + "warning"}};
  study.result.notes = {hostile + "note"};
  study.result.parameters[0].name = hostile + "name";
  study.result.parameters[0].unit = hostile + "unit";
  study.result.parameters[0].regrouped = hostile + "regrouped";
  study.provenance.inputs[0].path = hostile + "path";
  study.provenance.overrides = {{hostile + "flag", hostile + "value"}};
  const std::string page = study.page();
  EXPECT_EQ(page.find(hostile), std::string::npos);
  for (const char* const what : {"robot", "log", "reason", "code", "subject", "warning", "note", "name",
                                 "unit", "regrouped", "path", "flag", "value"}) {
    EXPECT_NE(page.find(harmless + what), std::string::npos) << what;
  }
  EXPECT_NE(page.find("<h4>" + harmless), std::string::npos);
  EXPECT_EQ(count(page, "</script>"), 2U) << "numbers and report.js";
}

TEST(HtmlReport, NamesEveryParameterAndJoint) {
  const Study study;
  const std::string page = study.page();
  ASSERT_EQ(study.result.parameters.size(), 8U);
  for (const ParameterEstimate& p : study.result.parameters) {
    EXPECT_NE(page.find("<b>" + p.name + "</b>"), std::string::npos) << p.name;
  }
  for (const Joint& joint : study.robot.joints) {
    EXPECT_NE(page.find("<td>" + joint.name + "</td>"), std::string::npos) << joint.name;
  }
}

TEST(HtmlReport, LoadsNothing) {
  const std::string page = Study().page();
  EXPECT_NE(
      page.find("content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'\""),
      std::string::npos);
  for (const char* const loader :
       {" src=", "<link", "@import", "url(", "fetch(", "XMLHttpRequest", "import(", "<iframe", "<img"}) {
    EXPECT_EQ(count(page, loader), 0U) << loader;
  }
  // The one address names the kind of a picture that is taken along.
  EXPECT_EQ(count(page, "\"http://www.w3.org/2000/svg\""), 1U);
  EXPECT_EQ(count(page, "http://") + count(page, "https://"), 1U);
}

TEST(HtmlReport, BeginsWithTheVerdict) {
  Study study;
  study.result.reasons = {"the reason"};
  study.result.warnings = {{.code = "base_doubt", .subject = "arm", .text = "the warning"}};
  const std::vector<std::pair<Status, std::string>> words = {
      {Status::identified, "Identified"},
      {Status::rank_deficient, "the data do not determine all parameters"},
      {Status::not_converged, "the iteration did not settle"},
      {Status::cycling, "the iteration goes round among a few estimates"},
      {Status::weak_instruments, "the simulated motion says too little about some parameters"},
      {Status::not_simulable, "no closed loop could be simulated with the estimate"},
      {Status::gave_up, "a budget of steps or seconds was used up first"}};
  for (const auto& [status, sentence] : words) {
    study.result.status = status;
    const std::string page = study.page();
    const std::string before = page.substr(0, page.find("id=\"parameters\""));
    for (const std::string& text :
         {sentence, std::string("the reason"), std::string("<code>base_doubt</code> arm: the warning. "),
          std::string(diagnostic_code("base_doubt").value().cure)}) {
      EXPECT_NE(before.find(text), std::string::npos) << text;
    }
    EXPECT_EQ(before.find("class=\"verdict good\"") != std::string::npos, status == Status::identified);
  }
}

TEST(HtmlReport, HasPlotsOfEveryJointAndLog) {
  Study study;
  study.predictions.push_back(study.predictions[0]);
  study.predictions[1].validation = true;
  const std::string page = study.page();
  EXPECT_EQ(count(page, "id=\"worst-joint\""), 1U);
  for (const std::string& joint : {std::string("1"), std::string("2")}) {
    for (const std::string& plot :
         {"torque-" + joint, "residual-" + joint, "torque-" + joint + "-log-2",
          "residual-" + joint + "-log-2", "friction-" + joint, "residual-speed-" + joint,
          "residual-position-" + joint, "residual-spectrum-" + joint, "residual-orders-" + joint,
          "residual-histogram-" + joint, "residual-autocorrelation-" + joint, "coverage-" + joint}) {
      EXPECT_EQ(count(page, " id=\"" + plot + "\""), 1U) << plot;
      EXPECT_EQ(count(page, "\"" + plot + "\":{"), 1U) << "numbers of " << plot;
    }
  }
  EXPECT_EQ(count(page, "id=\"correlation-map\""), 1U);
  EXPECT_EQ(count(page, "id=\"robot-picture\""), 1U);
  EXPECT_EQ(count(page, "id=\"torque-error\""), 0U);
  EXPECT_EQ(count(page, "<figure class=\"chart"), count(page, "<div class=\"picture\"></div></figure>"))
      << "each plot is drawn by report.js alone";
}

TEST(HtmlReport, NamesTheJointWithTheLargestErrorFirst) {
  Study study;
  for (const std::size_t worst : {0U, 1U}) {
    study.result.fit.joints[worst].relative_error = 0.0625;
    study.result.fit.joints[1 - worst].relative_error = 0.03125;
    const std::string page = study.page();
    const std::size_t at = page.find("id=\"worst-joint\"");
    const std::string figure = page.substr(at, page.find("</figcaption>", at) - at);
    EXPECT_NE(figure.find("Torque of joint_" + std::to_string(worst + 1)), std::string::npos) << figure;
    EXPECT_NE(figure.find("the joint with the largest error, 6.250 %"), std::string::npos) << figure;
    EXPECT_LT(page.find("class=\"verdict"), at);
    EXPECT_LT(at, page.find("<h2 id="));
  }
}

TEST(HtmlReport, FoldsParametersThatAreWeakAndSortsTheOthers) {
  Study study;
  for (std::size_t i = 0; i < study.result.parameters.size(); ++i) {
    study.result.parameters[i].verdict = i == 3 ? Verdict::weak : Verdict::identified;
    study.result.parameters[i].relative_sigma_percent = 10.0 - static_cast<double>(i);
  }
  const std::string page = study.page();
  const std::size_t fold = page.find("<summary>1 parameter that the data leave weak");
  ASSERT_NE(fold, std::string::npos);
  const std::size_t from = page.find("id=\"parameters\"");
  const auto at = [&](std::size_t i) {
    return page.find("<b>" + study.result.parameters[i].name + "</b>", from);
  };
  EXPECT_GT(at(3), fold);
  EXPECT_LT(at(7), at(6));
  EXPECT_LT(at(6), at(0));
  EXPECT_LT(at(0), fold);
}

TEST(HtmlReport, ShowsWhatTheRobotDescriptionWouldHavePredicted) {
  Study study;
  FittedRows& rows = study.predictions[0].joints[0].fitted;
  rows.a_priori = 0.75 * rows.measured;
  const std::string page = study.page();
  EXPECT_NE(page.find("<td>swing.csv</td><td><b>joint_1</b></td><td class=\"number\">25.00 %</td>"),
            std::string::npos);
}

TEST(HtmlReport, ShowsThePhysicalModelWhereThereIsOne) {
  Study study;
  EXPECT_EQ(study.page().find("id=\"physical\""), std::string::npos);
  PhysicalModel model;
  model.parameters.chi = study.result.chi;
  model.parameters.chi[2] += 3.0 * study.result.parameters[2].sigma;
  model.parameters.chi_st = Vector::Constant(static_cast<Index>(study.result.base.standard.size()), 0.25);
  model.fit = study.result.fit;
  model.fit.relative_error = 0.125;
  study.result.physical = model;
  const std::string page = study.page();
  EXPECT_NE(page.find("href=\"#physical\""), std::string::npos);
  EXPECT_NE(page.find("3.00 σ"), std::string::npos);
  EXPECT_NE(page.find("12.500 %"), std::string::npos);
  EXPECT_NE(page.find("<b>XX1</b></td><td class=\"number\">0.25</td>"), std::string::npos);
}

TEST(HtmlReport, ShowsWhichParametersAreEssentialBesideAllOfThem) {
  Study study;
  EXPECT_EQ(study.page().find("id=\"essential\""), std::string::npos);
  const Index b = study.result.base.size();
  EssentialModel model;
  model.fit = study.result.fit;
  model.fit.relative_error = 0.125;
  model.parameters.chi = Vector::Constant(b, 1.25);
  model.parameters.C_chi = 1e-4 * Matrix::Identity(b, b);
  model.parameters.kept = {0, 1, 2, 3, 4, 6, 7};
  study.result.essential = model;
  EXPECT_NE(study.page().find("All 8 are needed"), std::string::npos);
  study.result.essential->parameters.eliminated = {{.name = "MY2", .F = 0.75, .p = 0.3125}};
  study.result.essential->parameters.held = {"ZZ2"};
  study.result.validation = {{.file = "other.csv",
                              .fit = study.result.fit,
                              .forecast = {},
                              .physical = std::nullopt,
                              .essential = model.fit}};
  const std::string page = study.page();
  EXPECT_NE(page.find("href=\"#essential\""), std::string::npos);
  EXPECT_NE(page.find("7 of 8 parameters are enough"), std::string::npos);
  EXPECT_NE(page.find("no robot would move without: ZZ2."), std::string::npos);
  EXPECT_EQ(count(page, "class=\"gone\""), 1U);
  EXPECT_NE(page.find("removal 1: F = 0.75, p = 0.31"), std::string::npos);
  EXPECT_EQ(count(page, "<td class=\"number\">1.25000</td><td class=\"number\">0.800</td>"), 7U);
  EXPECT_NE(page.find("Their price on other.csv"), std::string::npos);
  EXPECT_EQ(count(page, "12.500 %"), 2U);
}

TEST(HtmlReport, ShowsTheGainsOfTheAssumedController) {
  Study study;
  IvIteration last;
  last.chi = study.result.chi;
  last.J = Eigen::Vector2d(3.5, 0.0625);
  last.gains = {{.name = "k_p", .values = Eigen::Vector2d(0.5, 5.25)}};
  study.result.iv = IvHistory();
  study.result.iv->iterations = {last};
  study.result.iv->loop.control_error = Eigen::Vector2d(0.25, 0.125);
  const std::string page = study.page();
  EXPECT_NE(page.find("<th class=\"number\">k_p</th>"), std::string::npos);
  EXPECT_NE(page.find("<td>joint_2</td><td class=\"number\">0.0625</td><td class=\"number\">5.25</td>"
                      "<td class=\"number\">12.500 %</td><td class=\"number\">-</td>"),
            std::string::npos);
}

TEST(HtmlReport, ShowsThePrefilterAndWhatItMoves) {
  Study study;
  EXPECT_EQ(study.page().find("id=\"prefilter\""), std::string::npos);
  PrefilterReport report;
  report.noise = {{.joint = "joint_1", .ar = Eigen::Vector3d(0.5, -0.25, 0.125), .innovation = 0.0625},
                  {.joint = "joint_2", .ar = Vector(), .innovation = 1.5}};
  report.rounds = 2;
  report.rows = 4321;
  report.chi = study.result.chi;
  report.sigma = Vector::Constant(report.chi.size(), 0.5);
  report.chi[3] += 2.0;
  report.covariance.quantile_975 = 1.96;
  study.result.prefilter = report;
  const std::string page = study.page();
  EXPECT_NE(page.find("href=\"#prefilter\""), std::string::npos);
  EXPECT_NE(page.find("4321 rows"), std::string::npos);
  EXPECT_NE(page.find("in 2 rounds"), std::string::npos);
  EXPECT_NE(
      page.find("<td>joint_1</td><td class=\"number\">3</td><td class=\"number\">0.0625</td><td>N·m</td>"
                "<td>0.5, -0.25, 0.125</td>"),
      std::string::npos);
  EXPECT_NE(page.find("<td>joint_2</td><td class=\"number\">0</td>"), std::string::npos);
  EXPECT_EQ(count(page, "<td class=\"number\">4.00 σ</td>"), 1U);
  EXPECT_EQ(count(page, "<td class=\"number\">0.00 σ</td>"), 15U) << "7 shifts, 8 biases";
  EXPECT_EQ(count(page, "class=\"apart\""), 1U) << "beyond the intervals";
}

TEST(HtmlReport, TellsTheMotionThatWouldHelpAWeakParameter) {
  Study study;
  for (ParameterEstimate& p : study.result.parameters) {
    p.verdict = Verdict::identified;
  }
  EXPECT_EQ(study.page().find("class=\"advice\""), std::string::npos);
  study.result.parameters[4].verdict = Verdict::weak;
  study.result.parameters[4].advice = "needs to be <fast>";
  study.result.parameters[5].verdict = Verdict::not_excited;
  const std::string page = study.page();
  EXPECT_NE(page.find("1 weak, 1 not excited, of 8 parameters"), std::string::npos);
  EXPECT_NE(page.find("<b>MX2</b> weak: needs to be &lt;fast&gt;"), std::string::npos);
  EXPECT_NE(page.find("<b>MY2</b> not excited"), std::string::npos);
}

TEST(HtmlReport, DescribesTheRobotAndTheSettings) {
  Study study;
  study.robot.joints[1].friction = Friction::asymmetric;
  study.robot.joints[1].sign_speed = 0.03;
  study.robot.joints[1].drive_gain = -12.5;
  study.robot.joints[1].rotor_inertia = true;  // which a coupling wants
  Coupling coupling;
  coupling.motor = 1;
  coupling.joints = {0};
  coupling.ratios = {-0.75};
  study.robot.couplings = {coupling};
  study.result = identify(study.robot, study.log, {.method = Ols{}, .signal = {.decimation = {10}}});
  study.predictions = {predict(study.robot, study.result, study.log)};
  study.result.estimation.signal.trim = {{30, 40}};
  study.result.estimation.signal.window = {{1.5, 9.25}};
  study.result.estimation.signal.velocity_threshold = {0.1, 0.25};
  const std::string page = study.page();
  for (const char* const words :
       {"<td>asymmetric, smooth over 0.03</td>", "<td class=\"number\">-12.5</td>", "30 and 40 samples",
        "1.5 to 9.25 s", "below 0.1, 0.25 rad/s or m/s", "The motor of joint_2 is turned by joint_1 (-0.75)",
        "Gravity in the frame of the base: 0, 0, -9.80665 m/s²"}) {
    EXPECT_NE(page.find(words), std::string::npos) << words;
  }
}

TEST(HtmlReport, HasNoPredictionWithoutAnEstimate) {
  Study study;
  study.result.status = Status::not_simulable;
  study.result.chi.setConstant(std::numeric_limits<double>::quiet_NaN());
  study.predictions = {predict(study.robot, study.result, study.log)};
  const std::string page = study.page();
  EXPECT_EQ(count(page, " id=\"torque-1\""), 1U);
  for (const char* const none : {" id=\"residual-1\"", " id=\"friction-1\"", " id=\"residual-histogram-1\"",
                                 "\"predicted\",\"kind\"", " id=\"description\""}) {
    EXPECT_EQ(count(page, none), 0U) << none;
  }
}

TEST(HtmlReport, KeepsTheTorquesOfTheWorstJointInDoublePrecisionAndAllElseInSingle) {
  Study study;
  JointPrediction& joint = study.predictions[0].joints[1];
  study.result.fit.joints[1].relative_error = 0.5;
  joint.rows = {0, 10};
  joint.residual = Eigen::Vector2d(0.5, 1.0);
  joint.fitted.measured = Eigen::Vector2d(1.0, 0.1);
  joint.fitted.position = joint.fitted.velocity = joint.fitted.a_priori = joint.fitted.gravity =
      joint.fitted.inertia = joint.fitted.coriolis = joint.fitted.friction = Eigen::Vector2d(1.0, 2.0);
  const std::string page = study.page();
  // Python: base64.b64encode(struct.pack("<2d", 1, 0.1)), and of "<2f", 0.5, 1.
  EXPECT_NE(page.find("\"exact\":true,\"fine\":false,\"x\":0,\"y\":\"AAAAAAAA4D"), std::string::npos)
      << "predicted";
  EXPECT_NE(page.find("\"y\":\"AAAAAAAA8D+amZmZmZm5Pw==\""), std::string::npos) << "measured";
  EXPECT_NE(page.find("\"y\":\"AAAAPwAAgD8=\""), std::string::npos) << "residual";
}

TEST(HtmlReport, OfSixJointsAnd100000SamplesIsSmall) {
  constexpr std::size_t most_bytes = 2'000'000;
  EXPECT_LT(large_page(6, 100'000).size(), most_bytes) << "every sample a row";
  const std::string page = large_page(6, 10'000);
  EXPECT_LT(page.size(), most_bytes) << "one sample in ten";
  EXPECT_NE(page.find("on the 10000 rows of the fit</figcaption>"), std::string::npos);
}

}  // namespace
}  // namespace rivid
