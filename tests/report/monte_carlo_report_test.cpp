// The page, the JSON and the table of runs that are made up.

#include <gtest/gtest.h>

#include "report/documents.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "support/monte_carlo_rows.hpp"

namespace rivid {
namespace {

using test::normal_error;
using test::rows_with;

constexpr int runs = 100;

std::size_t count(std::string_view text, std::string_view word) {
  std::size_t out = 0;
  for (std::size_t at = text.find(word); at != std::string_view::npos;
       at = text.find(word, at + word.size())) {
    ++out;
  }
  return out;
}

// Two ways to identify: one that is right, and one whose third parameter is off by two deviations.
struct Study {
  MonteCarlo plan = test::scara_plan(runs);
  std::vector<MonteCarloRow> rows;
  Provenance provenance = {
      .program = "a test", .inputs = {{"study.toml", std::string(64, '0')}}, .overrides = {{"runs", "100"}}};

  Study() {
    plan.trials.resize(2);
    for (int k = 0; k < 2; ++k) {
      const std::vector<MonteCarloRow> more = rows_with(
          plan, plan.trials[static_cast<std::size_t>(k)].label,
          [&](int run, Index i) { return normal_error(run, i, runs) + (k == 1 && i == 2 ? 2.0 : 0.0); });
      rows.insert(rows.end(), more.begin(), more.end());
    }
  }

  [[nodiscard]] std::vector<MonteCarloSummary> found() const { return summaries(plan, rows); }
  [[nodiscard]] std::string page() const { return html_report(plan, found(), rows, provenance); }
};

TEST(MonteCarloReport, SaysWhichWaysCanBeTrusted) {
  const std::string page = Study().page();
  EXPECT_NE(page.find("1 of 2 ways to identify can be trusted"), std::string::npos);
  EXPECT_NE(page.find("unbiased (at most 0.0"), std::string::npos);
  // The spread of 100 quantiles is a little less than one deviation.
  EXPECT_NE(page.find("biased (at most 2.0"), std::string::npos);
  EXPECT_NE(page.find(", Fc1)"), std::string::npos);
  EXPECT_NE(page.find("intervals are not honest"), std::string::npos);
}

TEST(MonteCarloReport, DrawsFivePlotsForEachWayAndLoadsNothing) {
  const std::string page = Study().page();
  EXPECT_EQ(count(page, "<figure class=\"chart panel\" id=\"way-"), 10U);
  EXPECT_EQ(count(page, "<script"), 2U) << "numbers and report.js";
  // Names the kind of a picture that is taken along.
  EXPECT_EQ(count(page, "\"http://www.w3.org/2000/svg\""), 1U);
  EXPECT_EQ(count(page, "http://") + count(page, "https://"), 1U);
  EXPECT_EQ(count(page, ">nan") + count(page, "\"nan") + count(page, "inf\""), 0U);
  // Bias and coverage of the third parameter; and all errors, since the deviations of 0.01 that are made up
  // here are far above the bound.
  std::size_t off = 0;
  for (std::size_t at = page.find("\"off\":["); at != std::string::npos;
       at = page.find("\"off\":[", at + 1)) {
    off += count(std::string_view(page).substr(at, page.find(']', at) - at), "true");
  }
  EXPECT_EQ(off, 2U + 16U);
}

TEST(MonteCarloReport, WithoutABoundThereIsNoPrecisionToDraw) {
  Study study;
  test::calm(study.plan);
  EXPECT_EQ(count(study.page(), "<figure class=\"chart"), 8U);
}

TEST(MonteCarloReport, TellsWhyRunsWereNotIdentified) {
  Study study;
  for (MonteCarloRow& row : study.rows) {
    if (row.label == study.plan.trials[1].label && row.run > 0) {
      row.status = row.run < 10 ? "cycling" : "refused";
    }
  }
  const std::string page = study.page();
  EXPECT_NE(page.find("9 runs cycling: the iteration goes round among a few estimates"), std::string::npos);
  EXPECT_NE(page.find("90 runs refused: the log could not be used"), std::string::npos);
  EXPECT_NE(page.find("too few runs are identified to say anything"), std::string::npos);
  EXPECT_EQ(count(page, "<figure class=\"chart"), 5U);
}

TEST(MonteCarloReport, NamesAreText) {
  Study study;
  study.plan.experiment.robot.name = "<i>&";
  study.plan.trials[0].label = "<script>";
  for (MonteCarloRow& row : study.rows) {
    row.label = row.label == study.plan.trials[1].label ? row.label : "<script>";
  }
  const std::string page = study.page();
  EXPECT_EQ(count(page, "<script>"), 1U) << "report.js";
  EXPECT_GT(count(page, "&lt;script&gt;"), 0U);
  EXPECT_EQ(count(page, "<i>"), 0U);
}

TEST(MonteCarloReport, TimesDoNotEnterWhatIsWritten) {
  Study study;
  const std::string page = study.page();
  const std::string json = to_json(study.found());
  for (MonteCarloRow& row : study.rows) {
    row.seconds *= 3.0;
  }
  EXPECT_EQ(study.page(), page);
  EXPECT_EQ(to_json(study.found()), json);
  // The screen shows them.
  const std::string table = in_words(study.found());
  EXPECT_NE(table.find("0.75 s each"), std::string::npos) << table;
}

TEST(MonteCarloReport, ErrorsAreThoseOfIdentifiedRunsInTheirDeviations) {
  Study study;
  study.rows[0].status = "cycling";
  const auto errors = detail::standardised_errors(study.found()[0], study.rows);
  ASSERT_EQ(errors.size(), 8U);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    ASSERT_EQ(errors[i].size(), static_cast<std::size_t>(runs - 1));
    // Truths of order one and deviations of 0.01: differences keep 14 digits of the former.
    EXPECT_NEAR(errors[i][4], normal_error(5, static_cast<Index>(i), runs), 1e-11);
  }
}

}  // namespace
}  // namespace rivid
