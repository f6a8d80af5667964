// The pages that rivid_identify and rivid_montecarlo write with --report, and what a browser makes of them.

#include <gtest/gtest.h>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Outcome;
using rivid::test::TemporaryFolder;

std::size_t count(std::string_view text, std::string_view word) {
  std::size_t out = 0;
  for (std::size_t at = text.find(word); at != std::string_view::npos;
       at = text.find(word, at + word.size())) {
    ++out;
  }
  return out;
}

class Report : public rivid::test::IdentifyTool {
 protected:
  [[nodiscard]] bool exists(const std::string& file) const {
    return std::filesystem::exists(folder().path() / file);
  }
};

TEST_F(Report, StandsBesideTheResultWhereItIsAskedFor) {
  EXPECT_EQ(identify({"scara.toml"}).exit_code, 0);
  EXPECT_FALSE(exists("scara_result/report.html"));
  const Outcome run = identify({"scara.toml", "--report"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(run.err.ends_with("wrote scara_result/result.json\nwrote scara_result/report.html\n"))
      << run.err;
  const std::string page = folder().read("scara_result/report.html");
  EXPECT_TRUE(page.starts_with("<!DOCTYPE html>"));
  EXPECT_NE(page.find("Identification: scara_s2.csv"), std::string::npos);
  EXPECT_NE(page.find("Validation: scara_validation.csv"), std::string::npos);
}

TEST_F(Report, IsTheSameEachTime) {
  EXPECT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const std::string page = folder().read("scara_result/report.html");
  EXPECT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  EXPECT_EQ(folder().read("scara_result/report.html"), page);
}

TEST_F(Report, IsNotWrittenByADryRun) {
  const Outcome run = identify({"scara.toml", "--report", "--dry-run"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("would write scara_result/report.html\n"), std::string::npos) << run.out;
  EXPECT_FALSE(exists("scara_result"));
}

// What a browser made of a page.
class InABrowser : public Report {
 protected:
  void SetUp() override {
    if (std::string_view(RIVID_CHROMIUM).empty()) {
      GTEST_SKIP() << "chromium was not found when CMake ran";
    }
  }

  // The page after its scripts have run, and the log of the browser, which tells what goes to the console.
  [[nodiscard]] Outcome opened(const std::string& file, const std::vector<std::string>& flags = {}) const {
    const std::filesystem::path page = std::filesystem::absolute(folder().path() / file);
    std::vector<std::string> command = {RIVID_CHROMIUM,
                                        "--headless=new",
                                        "--no-sandbox",
                                        "--disable-gpu",
                                        "--disable-dev-shm-usage",
                                        "--user-data-dir=" + profile_.path().string(),
                                        "--enable-logging=stderr",
                                        "--v=0",
                                        "--virtual-time-budget=20000"};
    command.insert(command.end(), flags.begin(), flags.end());
    command.insert(command.end(), {"--dump-dom", "file://" + page.string()});
    return rivid::test::outcome_of(command, folder().path());
  }

  void expect_plots(const std::string& file, std::size_t plots) const {
    const Outcome run = opened(file);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err.find("CONSOLE"), std::string::npos) << run.err;
    EXPECT_EQ(count(run.out, "data-kind="), plots);
    EXPECT_EQ(count(run.out, "<canvas"), plots);
    EXPECT_EQ(count(run.out, "data-plots=\"" + std::to_string(plots) + "\""), 1U);
  }

 private:
  TemporaryFolder profile_;
};

TEST_F(InABrowser, FaultsWouldBeSeen) {
  folder().write("broken.html", "<!DOCTYPE html><title>x</title><script>none_such();</script>");
  EXPECT_NE(opened("broken.html").err.find("CONSOLE"), std::string::npos);
}

TEST_F(InABrowser, AllPlotsAreMade) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  // Torques and residuals of two joints in two logs; histogram and autocorrelation of two joints.
  expect_plots("scara_result/report.html", 12);
}

TEST_F(InABrowser, ZoomingReachesSingleSamplesInAllPlotsOfALogAndInNoOther) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  std::string page = folder().read("scara_result/report.html");
  page.insert(page.rfind("</body>"), R"(<script>
setTimeout(() => {
  const button = document.querySelector(".toolbar [data-move=in]");
  for (let i = 0; i < 40; ++i) {
    button.click();
  }
  setTimeout(() => {
    const shown = (kind, log, joint) => {
      const { plot } = document.querySelector(`.${kind}[data-log="${log}"][data-joint="${joint}"]`);
      const t = plot.data[0];
      const { min, max } = plot.scales.x;
      return t.filter((x) => x >= min - 1e-9 && x <= max + 1e-9).length + " of " + t.length;
    };
    document.documentElement.dataset.shown =
        [shown("torque", 0, 0), shown("torque", 0, 1), shown("torque", 1, 0)].join(", ");
    const ranges = [...document.querySelectorAll(`.torque[data-log="0"], .residual[data-log="0"]`)].map(({ plot }) => JSON.stringify([plot.scales.x.min, plot.scales.x.max]));
    document.documentElement.dataset.ranges = new Set(ranges).size;
  }, 1000);
}, 1000);
</script>)");
  folder().write("zoomed.html", page);
  const Outcome run = opened("zoomed.html");
  EXPECT_EQ(run.err.find("CONSOLE"), std::string::npos) << run.err;
  // 4001 samples of 200 Hz over 20 s, of which trim = 20 takes 20 at either end. Five samples span four periods; the
  // middle of the log decides whether four or five of them are in sight.
  const std::size_t at = run.out.find("data-shown=");
  ASSERT_NE(at, std::string::npos);
  const std::string shown = run.out.substr(at, run.out.find('>', at) - at);
  EXPECT_TRUE(shown.starts_with("data-shown=\"5 of 3961, 5 of 3961, 3961 of 3961\"") ||
              shown.starts_with("data-shown=\"4 of 3961, 4 of 3961, 3961 of 3961\""))
      << shown;
  // Residuals have fewer points, one a row, and show the same time.
  EXPECT_NE(run.out.find("data-ranges=\"1\""), std::string::npos);
}

TEST_F(InABrowser, AllPlotsOfInstrumentalVariablesAreMade) {
  folder().write("scara_iv.toml",
                 rivid::test::content_of(std::filesystem::path(RIVID_DATA) / "scara" / "scara_iv.toml"));
  ASSERT_EQ(identify({"scara_iv.toml", "--report"}).exit_code, 0);
  // Torque error of all, motion errors of two joints.
  expect_plots("scara_iv_result/report.html", 15);
}

TEST_F(InABrowser, ThePageOfAMonteCarloStudyIsShown) {
  folder().write("montecarlo_s1.toml",
                 rivid::test::content_of(std::filesystem::path(RIVID_DATA) / "scara" / "montecarlo_s1.toml"));
  const Outcome run = rivid::test::outcome_of(
      {RIVID_MONTECARLO, "montecarlo_s1.toml", "--runs", "4", "--report"}, folder().path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::string page = folder().read("montecarlo_s1_montecarlo/report.html");
  // A script of the test's own measures on a narrow screen whether anything is wider than it.
  page.insert(page.rfind("</body>"), R"(<script>
const width = document.documentElement.clientWidth;
const wide = [...document.querySelectorAll("main svg, main p, main h2, main li")].filter(
    (part) => part.getBoundingClientRect().right > width + 1);
document.documentElement.dataset.wide = document.documentElement.scrollWidth > width ? "page" : wide.length;
</script>)");
  folder().write("measured.html", page);
  const Outcome shown = opened("measured.html", {"--window-size=390,800"});
  EXPECT_EQ(shown.err.find("CONSOLE"), std::string::npos) << shown.err;
  // Five plots for each of six ways to identify.
  EXPECT_EQ(count(shown.out, "<svg"), 30U);
  EXPECT_NE(shown.out.find("data-wide=\"0\""), std::string::npos);
}

TEST_F(InABrowser, PrefilterEssentialAndPhysicalParametersAreShown) {
  folder().write("scara_iv.toml",
                 rivid::test::content_of(std::filesystem::path(RIVID_DATA) / "scara" / "scara_iv.toml"));
  edit("scara_iv.toml", "name = \"iv\"",
       "name = \"iv\"\nprefilter = true\nessential = true\nphysical = true");
  ASSERT_EQ(identify({"scara_iv.toml", "--report"}).exit_code, 0);
  expect_plots("scara_iv_result/report.html", 15);
  const std::string page = opened("scara_iv_result/report.html").out;
  for (const char* const section : {"prefilter", "essential", "physical"}) {
    EXPECT_EQ(count(page, "<h2 id=\"" + std::string(section) + "\""), 1U) << section;
    EXPECT_EQ(count(page, "href=\"#" + std::string(section) + "\""), 1U) << section;
  }
}

TEST_F(InABrowser, AResultThatIsNotIdentifiedIsShown) {
  // Joint 2 stands still.
  rewrite_rows("scara_s2.csv", [](std::string line) {
    const std::size_t q2 = line.find(',', line.find(',') + 1) + 1;
    return line.replace(q2, line.find(',', q2) - q2, "0.5");
  });
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 1);
  // Joint 2 has no row, and so no residual to look at.
  expect_plots("scara_result/report.html", 10);
}

}  // namespace
