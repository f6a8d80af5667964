#include "rivid/report/html.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "report/documents.hpp"
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
    result = identify(robot, log, {.method = Ols{}, .signal = {.cutoff_hz = 20.0, .decimation = {10}}});
    predictions.push_back(predict(robot, result, log));
  }

  [[nodiscard]] std::string page() const { return html_report(robot, result, predictions, provenance); }
};

// A page of so many joints and samples, with nothing identified.
std::string large_page(Index joints, Index samples) {
  Robot robot;
  robot.name = "large";
  Identification result;
  Prediction log{.source = "large.csv", .f_m = 1000.0};
  for (Index j = 0; j < joints; ++j) {
    result.fit.joints.push_back({.name = "joint", .unit = "N·m"});
    log.joints.push_back({.measured = test::random_matrix(samples, 1, 3),
                          .predicted = test::random_matrix(samples, 1, 3),
                          .kept = std::vector<std::uint8_t>(static_cast<std::size_t>(samples), 1)});
  }
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
  // Data, uPlot, our own.
  EXPECT_EQ(count(page, "</script>"), 3U);
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
  // The one address is the origin of uPlot, in its comment.
  EXPECT_EQ(count(page, "http://"), 0U);
  EXPECT_EQ(count(page, "https://"), 1U);
  EXPECT_EQ(count(page, "/*! https://github.com/leeoniya/uPlot (v1.6.32) */"), 1U);
  EXPECT_NE(page.find("The MIT License"), std::string::npos);
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
      {Status::not_simulable, "no closed loop could be simulated with the estimate"}};
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
  EXPECT_EQ(count(page, "class=\"plot torque\""), 4U);
  EXPECT_EQ(count(page, "class=\"plot residual\""), 4U);
  EXPECT_EQ(count(page, "class=\"plot histogram\""), 2U);
  EXPECT_EQ(count(page, "class=\"plot autocorrelation\""), 2U);
  EXPECT_EQ(count(page, "class=\"plot motion-error\""), 0U);
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
  study.result.validation = {
      {.file = "other.csv", .fit = study.result.fit, .physical = std::nullopt, .essential = model.fit}};
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
  EXPECT_EQ(count(page, "<td class=\"number\">0.00 σ</td>"), 10U);
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
  study.result.estimation.signal.trim = {{30, 40}};
  study.result.estimation.signal.window = {{1.5, 9.25}};
  study.result.estimation.signal.velocity_threshold = {0.1, 0.25};
  Coupling coupling;
  coupling.motor = 1;
  coupling.joints = {0};
  coupling.ratios = {-0.75};
  study.robot.couplings = {coupling};
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
  EXPECT_EQ(count(page, "class=\"plot torque\""), 2U);
  EXPECT_EQ(count(page, "class=\"plot residual\""), 0U);
  EXPECT_EQ(count(page, "class=\"plot histogram\""), 0U);
  EXPECT_EQ(count(page, "\"predicted\":null"), 2U);
}

TEST(HtmlReport, KeepsTorquesAsSinglePrecision) {
  Study study;
  study.predictions[0].joints[0].measured = Eigen::Vector2d(1.0, 2.0);
  study.predictions[0].joints[0].predicted = Eigen::Vector3d(-0.1, 1e-3, 1e30);
  const std::string page = study.page();
  // Python: base64.b64encode(struct.pack("<2f", 1, 2)), and of "<3f", -0.1, 1e-3, 1e30.
  EXPECT_NE(page.find("\"measured\":\"AACAPwAAAEA=\""), std::string::npos);
  EXPECT_NE(page.find("\"predicted\":\"zczMvW8SgzrK8klx\""), std::string::npos);
}

TEST(HtmlReport, OfSevenJointsAnd21000SamplesIsSmall) {
  constexpr std::size_t most_bytes = 4'000'000;
  EXPECT_LT(large_page(7, 21'000).size(), most_bytes);
}

TEST(HtmlReport, ThinsLogsThatNoBrowserWouldOpen) {
  constexpr std::size_t most_bytes = 22'000'000;  // of 2 000 000 samples
  const std::string page = large_page(2, 1'500'000);
  EXPECT_LT(page.size(), most_bytes);
  EXPECT_NE(page.find("one sample in 2 is shown"), std::string::npos);
  EXPECT_NE(page.find("\"step\":0.002,\"samples\":750000"), std::string::npos);
}

// Residuals of one joint at these samples, two apart from row to row.
Prediction residuals(const std::vector<Index>& rows, const Vector& residual) {
  Prediction log{.f_m = 100.0, .row_stride = 2};
  log.joints.push_back({.rows = rows, .residual = residual});
  return log;
}

TEST(ResidualShape, AutocorrelationKnowsOfGaps) {
  // + − + − + − + −, the second half 3 rows late: 6 neighbours, 4 pairs over 2 rows, and those over the gap.
  const Prediction log =
      residuals({0, 2, 4, 6, 14, 16, 18, 20}, (Vector(8) << 1, -1, 1, -1, 1, -1, 1, -1).finished());
  const detail::ResidualShape shape = detail::residual_shape(std::span(&log, 1), 0);
  ASSERT_EQ(shape.autocorrelation.size(), 2U);
  EXPECT_DOUBLE_EQ(shape.autocorrelation[0], -6.0 / 8.0);
  EXPECT_DOUBLE_EQ(shape.autocorrelation[1], 4.0 / 8.0);
}

TEST(ResidualShape, HistogramHasEveryRowAndLeavesValidationsOut) {
  constexpr Index rows = 1000;
  std::vector<Index> samples;
  for (Index k = 0; k < rows; ++k) {
    samples.push_back(2 * k);
  }
  Vector residual = test::random_matrix(rows, 1, 5);
  residual[3] = 50.0;
  std::vector<Prediction> logs = {residuals(samples, residual), residuals(samples, residual)};
  logs[1].validation = true;
  const detail::ResidualShape shape = detail::residual_shape(logs, 0);
  EXPECT_EQ(shape.rows, rows);
  EXPECT_EQ(shape.outside, 1);
  double counted = 0.0;
  for (std::size_t k = 0; k < shape.counts.size(); ++k) {
    const double from = shape.first_edge + static_cast<double>(k) * shape.bin;
    const auto inside = (residual.array() >= from && residual.array() < from + shape.bin).count();
    // A value on an edge may round to either side.
    EXPECT_NEAR(shape.counts[k], static_cast<double>(inside), 1.0);
    counted += shape.counts[k];
  }
  EXPECT_EQ(counted, static_cast<double>(rows - 1));
}

}  // namespace
}  // namespace rivid
