// One document, shown as text and as a page: both say the same.

#include "report/document.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "report/documents.hpp"
#include "report/markup.hpp"

namespace rivid::detail {
namespace {

constexpr std::array marks = {Mark::none, Mark::weak, Mark::unseen, Mark::apart, Mark::gone,
                              Mark::sum,  Mark::good, Mark::mixed,  Mark::bad};

// A row for each mark, a column for each format.
Table table_of_everything() {
  Table out{{{"what", format::name},
             {"words"},
             {"count", format::count},
             {"digits", format::significant(3)},
             {"decimals", format::fixed(2), "σ"},
             {"share", format::percent},
             {"estimate", format::deviation}}};
  for (std::size_t k = 0; k < marks.size(); ++k) {
    const double x = 1.0 + static_cast<double>(k);
    out.rows.push_back({{"row" + std::string(k, 'i'), "word", 1000.0 * x, 12.3456 * x, -0.125 * x, 0.0625 * x,
                         Cell(3.25 * x, 0.01)},
                        marks[k]});
  }
  out.rows.back().cells[3] = std::numeric_limits<double>::infinity();
  return out;
}

// Every kind of block that has words.
Document document_of_everything() {
  Document out;
  out.line = out.headline = "the verdict";
  out.verdict = Mark::mixed;
  out.opening = {{KeyFigures{{{"17 %", "of something"}}}},
                 {FindingList{{{"torque_sign", "joint_1", "found 41"}, {"log_note", "", "noted 42"}}}}};
  List list{"reasons"};
  for (const Mark mark : marks) {
    list.items.push_back({"item", ": " + std::to_string(50 + static_cast<int>(mark)), mark});
  }
  out.sections = {
      {"first", "First", "The first", {{table_of_everything()}, {Sentence{"A sentence with 61"}}}},
      {"second", "Second", "The second", {{Heading{"Of 71"}}, {list}}}};
  out.sections[1].blocks.push_back({Table{{{""}, {""}}, {{{"left 81", "right 82"}}}, {"folded", true}}});
  return out;
}

// The words of a page without what only looks.
std::string words_of(std::string page) {
  page = page.substr(page.find("<main>"), page.find("</main>") - page.find("<main>"));
  page =
      std::regex_replace(page, std::regex("<svg[^]*?</svg>|<nav[^]*?</nav>|<summary>[^]*?</summary>"), " ");
  return std::regex_replace(page, std::regex("<[^>]*>"), " ");
}

std::vector<std::string> numbers_in(const std::string& text) {
  const std::regex number("[-+]?[0-9]+(\\.[0-9]+)?");
  std::vector<std::string> out;
  for (std::sregex_iterator at(text.begin(), text.end(), number); at != std::sregex_iterator(); ++at) {
    out.push_back(at->str());
  }
  std::ranges::sort(out);
  return out;
}

TEST(Document, TextAndPageShowTheSameNumbers) {
  const Document document = document_of_everything();
  // The list of findings counts itself on a page.
  std::vector<std::string> of_text = numbers_in(text_of(document));
  of_text.emplace_back("2");
  std::ranges::sort(of_text);
  EXPECT_GT(of_text.size(), 50U);
  EXPECT_EQ(numbers_in(words_of(html_of(document))), of_text);
}

TEST(Document, TextTellsThreeFindingsAndNamesTheOthers) {
  FindingList list;
  for (int k = 0; k < 5; ++k) {
    list.findings.push_back({k < 3 ? "torque_sign" : "log_note", "", "found " + std::to_string(k)});
  }
  Document document;
  document.opening = {{list}};
  const std::string text = text_of(document);
  EXPECT_NE(text.find("found 2"), std::string::npos) << text;
  EXPECT_EQ(text.find("found 3"), std::string::npos) << text;
  EXPECT_NE(text.find("2 more findings: log_note, log_note"), std::string::npos) << text;
}

TEST(Document, ShowsNumbersInTheFormatOfTheirColumn) {
  EXPECT_EQ(shown({"", format::percent}, 0.0625), "6.250 %");
  EXPECT_EQ(shown({"", format::fixed(2), "σ"}, -0.125), "-0.12 σ");
  EXPECT_EQ(shown({"", format::significant(3)}, 12.3456), "12.3");
  EXPECT_EQ(shown({"", format::count}, 1000.0), "1000");
  EXPECT_EQ(shown({"", format::deviation}, std::nan("")), "-");
}

// Widths of 10, 9 and 30, two blanks before each: 55 columns.
Table wide_table() {
  return {{{"name", format::name}, {"number", format::fixed(3)}, {"what"}},
          {{{"parameter1", 12345.678, "some words that make up 30 ch."}}, {{"two", 1.0, "few"}}}};
}

TEST(Document, WhatRoundsToZeroHasNoSign) {
  EXPECT_EQ(shown({"", format::fixed(2), "σ"}, Cell(-0.004)), "0.00 σ");
  EXPECT_EQ(shown({"", format::fixed(2)}, Cell(-0.006)), "-0.01");
  EXPECT_EQ(shown({"", format::percent}, Cell(-1e-9)), "0.000 %");
  EXPECT_EQ(with_decimals_of(-1e-7, 0.01), "0.00000");
}

TEST(Document, ATableThatIsWiderThanTheScreenGoesOnBelow) {
  Document document;
  document.sections = {{"", "", "", {{wide_table()}}}};
  const std::string whole =
      "\n\n"
      "  name           number  what\n"
      "  parameter1  12345.678  some words that make up 30 ch.\n"
      "  two             1.000  few\n";
  EXPECT_EQ(text_of(document), whole);
  EXPECT_EQ(text_of(document, 55), whole);
  EXPECT_EQ(text_of(document, 54),
            "\n\n"
            "  name           number\n"
            "  parameter1  12345.678\n"
            "  two             1.000\n"
            "\n"
            "  name        what\n"
            "  parameter1  some words that make up 30 ch.\n"
            "  two         few\n");
}

TEST(Document, SentencesEndWithTheScreen) {
  Document document;
  std::string words;
  for (int k = 0; k < 60; ++k) {
    words += "word ";
  }
  document.opening = {{Sentence{words}}};
  for (const std::size_t screen : std::array<std::size_t, 4>{40, 80, 0, 300}) {
    std::istringstream lines(text_of(document, screen));
    const std::size_t most = screen == 0 ? 100 : std::min<std::size_t>(screen, 100);
    std::size_t widest = 0;
    for (std::string line; std::getline(lines, line);) {
      widest = std::max(widest, line.size());
    }
    EXPECT_LE(widest, most);
    EXPECT_GT(widest, most - 5) << "no room for one word more";
  }
}

// Decimals of the fourth significant digit of σ, nine at most.
TEST(Document, ShowsAValueAsExactlyAsItsDeviationIsKnown) {
  EXPECT_EQ(shown({"", format::deviation}, Cell(3.25, 0.01)), "3.25000");
  EXPECT_EQ(shown({"", format::deviation}, Cell(3.25, 0.0099)), "3.250000");
  EXPECT_EQ(shown({"", format::deviation}, Cell(3.25, 20.0)), "3.25");
  EXPECT_EQ(shown({"", format::deviation}, Cell(3.25, 2e-6)), "3.250000000");
  EXPECT_EQ(shown({"", format::deviation}, Cell(1234.5678, 5000.0)), "1235");
}

TEST(Document, FoldsWhatIsLongAndOpensWhatShallBeSeen) {
  Document document;
  for (const bool open : {false, true}) {
    const std::string title = open ? "open one" : "closed one";
    document.sections.push_back({"a", "A", "A", {{Table{{{""}}, {{{"word"}}}, {title, open}}}}});
  }
  const std::string page = html_of(document);
  EXPECT_NE(page.find("<details><summary>closed one</summary>"), std::string::npos) << page;
  EXPECT_NE(page.find("<details open><summary>open one</summary>"), std::string::npos) << page;
}

TEST(Document, TextAndPageShowTheSameMarks) {
  const Document document = document_of_everything();
  const std::string text = text_of(document);
  const std::string page = html_of(document);
  for (std::size_t k = 0; k < marks.size(); ++k) {
    const std::string name = "row" + std::string(k, 'i');
    const std::string sign(rivid::detail::sign(marks[k]));
    const std::string kind(rivid::detail::name(marks[k]));
    EXPECT_NE(text.find("  " + name + (sign.empty() ? "  " : " " + sign)), std::string::npos) << text;
    const std::string badge = sign.empty() ? "" : "<span class=\"sign " + kind + "\">" + sign + "</span>";
    EXPECT_NE(page.find((kind.empty() ? "<tr><td><b>" : "<tr class=\"" + kind + "\"><td><b>") + name +
                        "</b>" + (badge.empty() ? "" : " ") + badge + "</td>"),
              std::string::npos)
        << name;
    const std::string item = ": " + std::to_string(50 + static_cast<int>(marks[k]));
    EXPECT_NE(text.find("  " + (sign.empty() ? "" : sign + " ") + "item" + item), std::string::npos) << text;
    EXPECT_NE(page.find("<li>" + badge + (badge.empty() ? "" : " ") + "<b>item</b>" + item),
              std::string::npos);
  }
}

TEST(Document, TextAndPageShowFindingsInTheSameWords) {
  const Document document = document_of_everything();
  const std::string cure(diagnostic_code("torque_sign").value().cure);
  const std::string text = std::regex_replace(text_of(document), std::regex("\\s+"), " ");
  EXPECT_NE(text.find("error [torque_sign] joint_1: found 41. " + cure), std::string::npos) << text;
  // A note needs no cure.
  EXPECT_NE(text.find("note [log_note] noted 42. what words"), std::string::npos) << text;
  const std::string page = html_of(document);
  EXPECT_NE(
      page.find("error <code>torque_sign</code> joint_1: found 41. <span class=\"cure\">" + escaped(cure)),
      std::string::npos);
  EXPECT_NE(page.find("note <code>log_note</code> noted 42. "), std::string::npos);
}

TEST(Document, WhatIsForOnePlaceIsNotShownAtTheOther) {
  Document document;
  document.sections = {
      {"a", "A", "A", {{Sentence{"screen alone"}, Shown::screen}, {Sentence{"page alone"}, Shown::page}}},
      {"b", "B", "the page's section", {}, Shown::page}};
  Table table{
      {{"left"}, {"middle", format::text, "", Shown::page}, {"right", format::text, "", Shown::screen}}};
  table.rows.push_back({{"both", "for the page", "for the screen"}});
  document.sections[0].blocks.push_back({table});
  const std::string text = text_of(document);
  const std::string page = html_of(document);
  for (const char* const words : {"screen alone", "for the screen"}) {
    EXPECT_NE(text.find(words), std::string::npos) << words;
    EXPECT_EQ(page.find(words), std::string::npos) << words;
  }
  for (const char* const words : {"page alone", "for the page", "the page&#39;s section"}) {
    EXPECT_EQ(text.find(words), std::string::npos) << words;
    EXPECT_NE(page.find(words), std::string::npos) << words;
  }
}

TEST(Document, PlotsStandOnThePageWithTheirMarks) {
  DotPlot dots{"bias", "Bias", "of <this>", "label", "bias", 0.0, {-1.0, 1.0}};
  dots.dots = {{"Fv1", {-0.5, 0.5, 0.1}, Mark::none}, {"Fv2", {1.5, 2.5, 2.0}, Mark::bad}};
  PathPlot path{"path-1", "ZZ1R", "3.5 kg·m²", "ZZ1R from 1 to 3.5", {1.0, 3.0, 3.5}, {{3.25, 3.75}}};
  Chart chart{
      .id = "torque-2", .title = "Torque <2>", .label = "Torque", .x_label = "t [s]", .y_label = "N·m"};
  const Vector t = Eigen::Vector4d(0.0, 1.0, 2.0, 3.0);
  const double none = std::nan("");
  chart.series = {{"measured", "measured", Series::Kind::line, t, Eigen::Vector4d(1.0, 2.0, none, 4.0)},
                  {"band", "band", Series::Kind::band, t, Eigen::Vector4d::Zero(), Eigen::Vector4d::Ones()},
                  {"dots", "dots", Series::Kind::points, t, Eigen::Vector4d(1.0, none, 3.0, 4.0)}};
  chart.log = 3;
  HeatMap map{"map", "Map", "", "Map", {"a", "b"}, Matrix::Identity(2, 2)};
  map.values(1, 0) = map.values(0, 1) = -0.75;
  Document document;
  document.sections = {
      {"plots",
       "Plots",
       "Plots",
       {{Legend{{{"dot", "a parameter"}}, "a remark"}},
        {Plots{"panels", {{"joint_1", "7 rows", {chart, map, dots, path}}}, {"a log", false}}}}}};
  const std::string page = html_of(document);
  EXPECT_NE(page.find("<details><summary>a log</summary>"), std::string::npos);
  EXPECT_NE(page.find("<figure class=\"chart panel\" id=\"torque-2\" data-log=\"3\">"), std::string::npos);
  EXPECT_NE(page.find("Torque &lt;2&gt;"), std::string::npos);
  EXPECT_NE(page.find("{\"name\":\"dots\",\"style\":\"dots\",\"kind\":\"points\",\"exact\":false,\"fine\":"
                      "false,\"x\":0,"),
            std::string::npos)
      << "series with the same abscissa have it once";
  // Python: base64.b64encode(struct.pack("<4f", 1, 2, math.nan, 4)), and of "<4f", 1, -0.75, -0.75, 1.
  EXPECT_NE(page.find("\"y\":\"AACAPwAAAEAAAMB/AACAQA==\""), std::string::npos) << "the gap";
  EXPECT_NE(page.find("\"values\":\"AACAPwAAQL8AAEC/AACAPw==\""), std::string::npos) << "−0.75";
  EXPECT_NE(page.find("of &lt;this&gt;"), std::string::npos);
  EXPECT_NE(page.find("\"off\":[false,true]"), std::string::npos);
  EXPECT_NE(page.find("\"bias\":{\"rows\":[[\"\",\"bias\",\"from\",\"to\"],[\"Fv1\",0.1,-0.5,0.5],"),
            std::string::npos);
  EXPECT_NE(page.find("{\"steps\":[1.0,3.0,3.5],\"interval\":[3.25,3.75],\"label\":\"ZZ1R from 1 to 3.5\"}"),
            std::string::npos);
  EXPECT_EQ(text_of(document).find("joint_1"), std::string::npos);
}

// A parameter whose interval holds zero, and one whose does not: the verdict alone marks them.
Identification judged(Verdict first, Verdict second) {
  Identification out;
  out.parameters = {{.name = "YY6",
                     .unit = "kg·m²",
                     .regrouped = "YY6",
                     .value = 0.1,
                     .sigma = 0.2,
                     .relative_sigma_percent = 200.0,
                     .interval_95 = {-0.3, 0.5},
                     .verdict = first,
                     .advice = "why"},
                    {.name = "Fv1",
                     .unit = "N·m",
                     .regrouped = "Fv1",
                     .value = 4.0,
                     .sigma = 0.1,
                     .relative_sigma_percent = 2.5,
                     .interval_95 = {3.8, 4.2},
                     .verdict = second,
                     .advice = "why"}};
  return out;
}

TEST(Document, MarksParametersByTheirVerdictOnScreenAndPageAlike) {
  const std::vector<std::pair<Verdict, std::string>> verdicts = {
      {Verdict::identified, ""}, {Verdict::weak, "?"}, {Verdict::not_excited, "x"}};
  for (const auto& [verdict, sign] : verdicts) {
    for (const Identification& result :
         {judged(verdict, Verdict::identified), judged(Verdict::identified, verdict)}) {
      const std::string name = result.parameters[0].verdict == verdict ? "YY6" : "Fv1";
      const std::string text = text_of(document_of(result));
      const std::string page = html_of(document_of(Robot(), result, {}, {}));
      EXPECT_EQ(text.find("\n  " + name + " " + sign + " ") != std::string::npos, true) << text;
      EXPECT_EQ(page.find("<b>" + name + "</b> <span class=\"sign ") != std::string::npos, !sign.empty());
      EXPECT_EQ(page.find("<tr class=\"weak\">") != std::string::npos, verdict == Verdict::weak);
      EXPECT_EQ(page.find("<tr class=\"unseen\">") != std::string::npos, verdict == Verdict::not_excited);
    }
  }
}

TEST(Document, ShowsDriveGainsWithTheirUnitInSentences) {
  Identification result = judged(Verdict::identified, Verdict::identified);
  result.fit.joints = {
      {.name = "lift", .unit = "N"}, {.name = "turn", .unit = "N·m"}, {.name = "end", .unit = "N·m"}};
  GainReport& gains = result.gains.emplace();
  gains.identified = true;
  gains.scale = "Only ratios of the gains are determined";
  gains.joints = {{"lift", 100.0, 100.0, 1e-3, {99.998, 100.002}, true},
                  {"turn", 10.0, 12.5, 0.25, {12.0, 13.0}, true},
                  {"end", 5.0, 9.0, 4.0, {1.0, 17.0}, false}};
  const std::string text = text_of(document_of(result));
  EXPECT_NE(text.find("\n  Only ratios of the gains are determined\n"), std::string::npos) << text;
  EXPECT_TRUE(std::regex_search(text, std::regex("  lift +100 +100 +N/A +- +counts as exact"))) << text;
  EXPECT_TRUE(std::regex_search(text, std::regex("  turn +10 +12.5000 +N·m/A +0.2500 +12 … 13"))) << text;
  EXPECT_TRUE(std::regex_search(text, std::regex("  end x +5 .* not identifiable"))) << text;
  EXPECT_NE(text.find("Used, on the joint side: 100, 12.5, 5. The unit"), std::string::npos) << text;
  gains.scale = "The scale of the gains comes from the payload of 2 kg";
  EXPECT_NE(
      html_of(document_of(result)).find("<p>The scale of the gains comes from the payload of 2 kg.</p>"),
      std::string::npos);
}

TEST(Document, OfAResultShowsItsFindings) {
  Identification result = judged(Verdict::identified, Verdict::identified);
  result.warnings = {{"base_doubt", "", "the doubt"}};
  EXPECT_NE(text_of(document_of(result)).find("\n  warning [base_doubt] the doubt. Round the angles"),
            std::string::npos);
}

}  // namespace
}  // namespace rivid::detail
