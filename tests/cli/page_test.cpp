// What a browser makes of the pages that rivid_identify, rivid_montecarlo and rivid_excite write with
// --report.

#include <gtest/gtest.h>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;
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

// Opens every fold, in which plots become as wide as the page then.
constexpr const char* unfolded = R"(
  document.querySelectorAll("details").forEach((fold) => (fold.open = true));
  await wait();
)";

class Page : public rivid::test::IdentifyTool {
 protected:
  void SetUp() override {
    if (std::string_view(RIVID_CHROMIUM).empty()) {
      GTEST_SKIP() << "chromium was not found when CMake ran";
    }
  }

  // A page after its scripts have run, and the log of the browser, which has what goes to the console.
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

  // What a script of the test's own returns on the page, a while after it was opened. It may say more than
  // once `await`.
  [[nodiscard]] std::string answer(const std::string& file, const std::string& script,
                                   const std::vector<std::string>& flags = {"--window-size=1280,900"}) const {
    std::string page = folder().read(file);
    page.insert(page.rfind("</body>"), R"(<script>
setTimeout(async () => {
  const wait = () => new Promise((resolve) => setTimeout(resolve, 500));
  const answer = await (async () => {
)" + script + R"(
  })();
  document.documentElement.dataset.answer = encodeURIComponent(JSON.stringify(answer));
}, 1000);
</script>)");
    folder().write("asked.html", page);
    const std::string key = "data-answer=\"";
    Outcome run;
    std::size_t at = std::string::npos;
    // A browser that waits for a processor ends its virtual time before the page is drawn.
    constexpr int most_attempts = 3;
    for (int attempt = 0; attempt < most_attempts && at == std::string::npos; ++attempt) {
      run = opened("asked.html", flags);
      EXPECT_EQ(run.err.find("CONSOLE"), std::string::npos) << run.err;
      at = run.out.find(key);
    }
    if (at == std::string::npos) {
      ADD_FAILURE() << "the script gave no answer: " << run.err;
      return "null";
    }
    return decoded(run.out.substr(at + key.size(), run.out.find('"', at + key.size()) - at - key.size()));
  }

  // All figures of the page, of which so many are plots over time.
  void expect_figures(const std::string& file, std::size_t figures, std::size_t over_time) const {
    const Json found = Json::parse(
        answer(file,
               std::string(unfolded) +
                   "const all = [...document.querySelectorAll('figure.chart')];\n"
                   "return [all.length, document.querySelectorAll('figure.chart .picture > svg').length,\n"
                   "        all.filter((figure) => figure.dataset.log !== undefined && figure.plot).length,\n"
                   "        document.querySelectorAll('figure.chart .tools').length];",
               {"--window-size=1280,900"}));
    EXPECT_EQ(found, Json({figures, figures, over_time, figures})) << "figures, pictures, plots, tools";
  }

  void provide_iv(const std::string& options = {}) const {
    folder().write("scara_iv.toml",
                   rivid::test::content_of(std::filesystem::path(RIVID_DATA) / "scara" / "scara_iv.toml"));
    if (!options.empty()) {
      edit("scara_iv.toml", "name = \"iv\"", "name = \"iv\"\n" + options);
    }
  }

 private:
  // The inverse of encodeURIComponent().
  [[nodiscard]] static std::string decoded(const std::string& text) {
    std::string out;
    for (std::size_t k = 0; k < text.size(); ++k) {
      if (text[k] == '%') {
        out += static_cast<char>(std::stoi(text.substr(k + 1, 2), nullptr, 16));
        k += 2;
      } else {
        out += text[k];
      }
    }
    return out;
  }

  TemporaryFolder profile_;
};

TEST_F(Page, FaultsWouldBeSeen) {
  folder().write("broken.html", "<!DOCTYPE html><title>x</title><script>none_such();</script>");
  EXPECT_NE(opened("broken.html").err.find("CONSOLE"), std::string::npos);
}

TEST_F(Page, AllFiguresAreThere) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  // Over time: that of the worst joint; torques and residuals of two joints in two logs. Besides, of each
  // joint friction, residual over speed and position, two spectra, histogram, autocorrelation, coverage;
  // correlation and robot.
  expect_figures("scara_result/report.html", 9 + 2 * 8 + 2, 9);
}

TEST_F(Page, TheJointsAndTheFirstPlotAreAboveTheFold) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const Json found = Json::parse(answer("scara_result/report.html", R"(
  const bottom = (selector) => document.querySelector(selector).getBoundingClientRect().bottom;
  const right = (selector) => document.querySelector(selector).getBoundingClientRect().right;
  return { plot: bottom("#worst-joint svg"), table: bottom(".first-look table"), verdict: bottom(".verdict"),
           fold: innerHeight, right: Math.max(right(".first-look table"), right("#worst-joint svg")), width: innerWidth };)"));
  EXPECT_GT(found.at("plot"), 200.0) << found;
  EXPECT_LT(found.at("plot"), found.at("fold")) << found;
  EXPECT_LT(found.at("table"), found.at("fold")) << found;
  EXPECT_LE(found.at("fold"), 900) << found;
  EXPECT_LT(found.at("right"), found.at("width")) << found;
}

// The sum over what is drawn in another order than that of the table, which has it from triangular factors.
TEST_F(Page, TheErrorOfWhatIsPlottedIsThatOfTheTable) {
  constexpr double rounding = 1e-12;
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const Json found = Json::parse(answer("scara_result/report.html", R"(
  const [measured, predicted] = document.getElementById("worst-joint").plot.series;
  let [error, norm, rows] = [0, 0, 0];
  measured.y.forEach((y, k) => {
    if (!Number.isNaN(y)) {
      error += (y - predicted.y[k]) ** 2;
      norm += y * y;
      ++rows;
    }
  });
  return { error: Math.sqrt(error / norm), rows, caption: document.querySelector("#worst-joint figcaption").textContent };)"));
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  const Json worst = *std::ranges::max_element(result.at("fit").at("joints"), {}, [](const Json& joint) {
    return joint.at("relative_error").get<double>();
  });
  EXPECT_EQ(found.at("rows"), worst.at("rows"));
  const double error = worst.at("relative_error");
  EXPECT_NEAR(found.at("error"), error, rounding * error);
  EXPECT_NE(found.at("caption").get<std::string>().find(worst.at("name").get<std::string>()),
            std::string::npos);
}

TEST_F(Page, IsNoWiderThanAPhone) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const Json found = Json::parse(answer("scara_result/report.html", R"(
  const width = document.documentElement.clientWidth;
  const wide = [...document.querySelectorAll("main figure, main p, main h2, main li, main .picture > svg")].filter(
      (part) => part.getBoundingClientRect().right > width + 1);
  const bar = document.querySelector("#parameters ~ .scroll svg").getBoundingClientRect();
  return { width, page: document.documentElement.scrollWidth, wide: wide.map((part) => part.outerHTML.slice(0, 80)), bar: bar.right };)",
                                        {"--window-size=390,844"}));
  EXPECT_LE(found.at("page"), found.at("width")) << found;
  EXPECT_TRUE(found.at("wide").empty()) << found;
  EXPECT_LE(found.at("bar"), found.at("width")) << "bars of the intervals are in sight";
}

TEST_F(Page, HasNothingThatAxeCallsSerious) {
  if (std::string_view(RIVID_AXE).empty()) {
    GTEST_SKIP() << "axe-core was not found when CMake ran";
  }
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const std::string script = std::string(unfolded) + rivid::test::content_of(RIVID_AXE) + R"(
  await wait();
  const { violations, passes } = await axe.run(document, { resultTypes: ["violations"] });
  return { passes: passes.length, serious: violations.filter((v) => v.impact === "serious" || v.impact === "critical")
      .map((v) => [v.id, v.nodes.length, v.nodes[0].html.slice(0, 160), v.nodes[0].failureSummary]) };)";
  for (const std::vector<std::string>& flags :
       std::vector<std::vector<std::string>>{{"--window-size=1280,900"},
                                             {"--window-size=1280,900", "--force-dark-mode"},
                                             {"--window-size=390,844"}}) {
    const Json found = Json::parse(answer("scara_result/report.html", script, flags));
    EXPECT_GT(found.at("passes"), 10) << found;
    EXPECT_TRUE(found.at("serious").empty()) << flags.back() << ": " << found.at("serious").dump(1);
  }
}

TEST_F(Page, ZoomsAllPlotsOfALogAndNoOtherDownToFewRows) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const Json found = Json::parse(answer("scara_result/report.html", std::string(unfolded) + R"(
  const toolbars = [...document.querySelectorAll(".toolbar")].map((bar) => bar.querySelectorAll("button").length);
  const button = document.querySelector(".toolbar [data-move=in]");
  for (let i = 0; i < 40; ++i) {
    button.click();
  }
  await wait();
  const part = (id) => {
    const { series, x } = document.getElementById(id).plot;
    return series[0].x.filter((t) => t >= x.low && t <= x.high).length;
  };
  const ranges = new Set([...document.querySelectorAll("figure[data-log='1']")].map(({ plot }) => plot.x.low + " " + plot.x.high));
  const all = (id) => document.getElementById(id).plot.series[0].x.length;
  const result = [part("torque-1"), part("torque-2"), part("torque-1-log-2") === all("torque-1-log-2"), part("worst-joint") === all("worst-joint"), ranges.size];
  const place = document.querySelector("#torque-1 .picture");
  place.dispatchEvent(new KeyboardEvent("keydown", { key: "0" }));
  await wait();
  return [...result, part("torque-1") === all("torque-1"), toolbars];)"));
  EXPECT_GE(found[0], 2) << found;
  EXPECT_LE(found[0], 6) << found;
  EXPECT_LE(found[1], 6) << found;
  EXPECT_EQ(Json(std::vector<Json>(found.begin() + 2, found.end())), Json({true, true, 1, true, {5, 5}}))
      << "the other log, the first plot, one range for all, all rows by a key, buttons of two logs";
}

TEST_F(Page, EachChartHasRoundTicksAndNamesOfTheMapAreInThePicture) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const Json found = Json::parse(answer("scara_result/report.html", std::string(unfolded) + R"(
  const plots = [...document.querySelectorAll("figure.chart")].filter((figure) => figure.plot);
  const axes = plots.flatMap(({ plot }) => [plot.x.ticks, plot.y.ticks]);
  const ticks = axes.map((axis) => axis.length);
  const uneven = axes.filter((axis) => {
    const step = axis[1] - axis[0];
    return ![1, 2, 5].includes(parseInt(step.toExponential(6))) || axis.some((tick, k) => Math.abs(axis[0] + k * step - tick) > 1e-6 * step);
  });
  const map = document.querySelector("#correlation-map svg");
  const names = [...map.querySelectorAll("text")].map((name) => name.getBoundingClientRect().top);
  return { plots: plots.length, fewest: Math.min(...ticks), most: Math.max(...ticks), uneven, top: Math.min(...names) - map.getBoundingClientRect().top };)"));
  EXPECT_EQ(found.at("plots"), 9 + 2 * 8);
  EXPECT_GE(found.at("fewest"), 2) << found;
  EXPECT_LE(found.at("most"), 18) << found;
  EXPECT_TRUE(found.at("uneven").empty()) << found;
  EXPECT_GE(found.at("top"), 0.0) << found;
}

// A pen that is set down once a stretch, and once a point of a cloud; squares as strong as their correlation.
TEST_F(Page, DrawsWhatTheNumbersSay) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const Json found = Json::parse(answer("scara_result/report.html", R"(
  const wrong = [];
  const seen = { line: 0, points: 0, bars: 0, band: 0, gaps: 0 };
  for (const figure of document.querySelectorAll("figure.chart")) {
    for (const s of (figure.plot?.series ?? []).filter((each) => !each.hidden)) {
      const known = [...s.y].map((y) => !Number.isNaN(y));
      const stretches = known.filter((now, k) => now && !known[k - 1]).length;
      const rows = known.filter((now) => now).length;
      const kind = { line: "path.curve", points: "path.cloud", bars: "rect.bar", band: "path.area" }[s.kind];
      const drawn = [...figure.querySelectorAll(`${kind}.${s.style}`)];
      const strokes = s.kind === "bars" ? drawn.length : drawn[0].getAttribute("d").split("M").length - 1;
      if (strokes !== (s.kind === "line" || s.kind === "band" ? stretches : rows)) {
        wrong.push([figure.id, s.name, strokes, stretches, rows]);
      }
      ++seen[s.kind];
      seen.gaps += s.kind === "line" ? stretches - 1 : 0;
    }
  }
  const squares = [...document.querySelectorAll("#correlation-map path")].map((each) => [each.className.baseVal, each.getAttribute("opacity")]);
  return { wrong, seen, squares };)"));
  EXPECT_TRUE(found.at("wrong").empty()) << found;
  EXPECT_GT(found.at("seen").at("gaps"), 10) << found;
  for (const char* const kind : {"line", "points", "bars", "band"}) {
    EXPECT_GT(found.at("seen").at(kind), 1) << found;
  }
  const Json result = Json::parse(folder().read("scara_result/result.json"));
  const Json& C = result.at("covariance").at("C_chi");
  std::vector<Json> squares;
  for (std::size_t i = 0; i < C.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double r = C[i][j].get<double>() / std::sqrt(C[i][i].get<double>() * C[j][j].get<double>());
      const auto level = std::lround(10.0 * std::abs(r));
      if (level > 0) {
        const std::string digits = level == 10 ? "1" : "0." + std::to_string(level);
        squares.push_back({r < 0.0 ? "against" : "together", digits});
      }
    }
  }
  EXPECT_EQ(found.at("squares"), Json(squares));
}

TEST_F(Page, SelectsATimeAndShowsValuesUnderThePointer) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const Json found = Json::parse(answer("scara_result/report.html", std::string(unfolded) + R"(
  const figure = document.getElementById("torque-1");
  const place = figure.querySelector(".picture");
  place.scrollIntoView();
  const { left, top, width, height } = place.getBoundingClientRect();
  const at = (part) => ({ clientX: left + part * width, clientY: top + 0.4 * height, pointerType: "mouse", buttons: 1, bubbles: true });
  const before = { ...figure.plot.x };
  place.dispatchEvent(new PointerEvent("pointermove", { ...at(0.5), buttons: 0 }));
  const tip = document.querySelector(".tip").textContent;
  const cursors = [...document.querySelectorAll("figure[data-log='1'] .cursor")].filter((each) => each.getAttribute("x1")).length;
  place.dispatchEvent(new PointerEvent("pointerdown", at(0.25)));
  place.dispatchEvent(new PointerEvent("pointermove", at(0.75)));
  const selected = figure.querySelector(".selection").getAttribute("width") / width;
  place.dispatchEvent(new PointerEvent("pointerup", at(0.75)));
  const after = { ...figure.plot.x };
  place.dispatchEvent(new MouseEvent("dblclick", { bubbles: true }));
  return { tip, cursors, selected, part: (after.high - after.low) / (before.high - before.low), all: figure.plot.x.high === before.high,
           legend: figure.querySelectorAll(".legend button").length, curves: figure.querySelectorAll(".curve").length,
           more: (figure.querySelector(".legend button:last-child").click(), figure.querySelectorAll(".curve").length) };)"));
  EXPECT_TRUE(found.at("tip").get<std::string>().starts_with("t: ")) << found;
  EXPECT_NE(found.at("tip").get<std::string>().find(", predicted: "), std::string::npos) << found;
  EXPECT_EQ(found.at("cursors"), 4) << "torques and residuals of two joints";
  EXPECT_NEAR(found.at("selected").get<double>(), 0.5, 0.01);
  EXPECT_NEAR(found.at("part").get<double>(), 0.5, 0.1) << "the plot is a little narrower than its picture";
  EXPECT_TRUE(found.at("all").get<bool>());
  EXPECT_EQ(found.at("legend"), 3);
  EXPECT_EQ(found.at("curves"), 2);
  EXPECT_EQ(found.at("more"), 3) << "the robot description, once it is asked for";
}

TEST_F(Page, GivesNumbersAndPicturesOfEachPlot) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const Json found = Json::parse(answer("scara_result/report.html", R"(
  const blobs = [];
  URL.createObjectURL = (blob) => (blobs.push(blob), "#");
  document.querySelectorAll("figure.chart .tools button").forEach((button) => button.click());
  const texts = await Promise.all(blobs.map((blob) => blob.text()));
  const tables = texts.filter((_, k) => blobs[k].type === "text/csv");
  const pictures = texts.filter((_, k) => blobs[k].type === "image/svg+xml");
  const parsed = pictures.map((text) => new DOMParser().parseFromString(text, "image/svg+xml"));
  return { figures: document.querySelectorAll("figure.chart").length, tables: tables.length, pictures: pictures.length,
           broken: parsed.filter((doc) => doc.querySelector("parsererror")).length,
           variables: pictures.filter((text) => text.includes("var(")).length,
           short: tables.filter((text) => text.trim().split("\n").length < 2).length, first: tables[0] };)"));
  EXPECT_EQ(found.at("tables"), found.at("figures"));
  EXPECT_EQ(found.at("pictures"), found.at("figures"));
  EXPECT_EQ(found.at("broken"), 0);
  EXPECT_EQ(found.at("variables"), 0) << "other programs know no variables of style sheets";
  EXPECT_EQ(found.at("short"), 0);
  const std::string first = found.at("first");
  EXPECT_TRUE(first.starts_with("t [s],measured,predicted,robot description\n")) << first.substr(0, 100);
}

TEST_F(Page, SortsTablesAndTurnsTheRobot) {
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 0);
  const Json found = Json::parse(answer("scara_result/report.html", R"(
  const table = document.querySelector("#parameters ~ .scroll table");
  const column = [...table.tHead.rows[0].cells].findIndex((cell) => cell.textContent === "value");
  const values = () => [...table.tBodies[0].rows].map((row) => parseFloat(row.cells[column].textContent));
  const button = table.tHead.rows[0].cells[column].querySelector("button");
  button.click();
  const up = values();
  button.click();
  const down = values();
  const arm = () => document.querySelector("#robot-picture polyline").getAttribute("points");
  const before = arm();
  document.querySelector("#robot-picture .picture").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
  return { up, down, turned: arm() !== before };)"));
  const std::vector<double> up = found.at("up");
  const std::vector<double> down = found.at("down");
  EXPECT_EQ(up.size(), 8U);
  EXPECT_TRUE(std::ranges::is_sorted(up));
  EXPECT_TRUE(std::ranges::is_sorted(down, std::greater<>()));
  EXPECT_TRUE(found.at("turned").get<bool>());
}

TEST_F(Page, AllFiguresOfInstrumentalVariablesAreThere) {
  provide_iv();
  ASSERT_EQ(identify({"scara_iv.toml", "--report"}).exit_code, 0);
  // Torque error of all, motion errors of two joints.
  expect_figures("scara_iv_result/report.html", 9 + 2 * 8 + 2 + 3, 9);
}

TEST_F(Page, ThePageOfAMonteCarloStudyIsShown) {
  folder().write("montecarlo_s1.toml",
                 rivid::test::content_of(std::filesystem::path(RIVID_DATA) / "scara" / "montecarlo_s1.toml"));
  const Outcome run = rivid::test::outcome_of(
      {RIVID_MONTECARLO, "montecarlo_s1.toml", "--runs", "4", "--report"}, folder().path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json found = Json::parse(answer("montecarlo_s1_montecarlo/report.html", R"(
  const width = document.documentElement.clientWidth;
  const wide = [...document.querySelectorAll("main svg, main p, main h2, main li")].filter(
      (part) => part.getBoundingClientRect().right > width + 1);
  return { width, page: document.documentElement.scrollWidth, wide: wide.length, pictures: document.querySelectorAll("svg").length,
           tools: document.querySelectorAll("figure.chart .tools").length, sorted: document.querySelectorAll("th button").length };)",
                                        {"--window-size=390,844"}));
  // Five plots for each of six ways to identify.
  EXPECT_EQ(found.at("pictures"), 30);
  EXPECT_LE(found.at("page"), found.at("width"));
  EXPECT_EQ(found.at("wide"), 0);
  EXPECT_EQ(found.at("tools"), 30) << "CSV, SVG and link of each plot";
  EXPECT_GE(found.at("sorted"), 6) << "headings that sort a table";
}

TEST_F(Page, ThePageOfAReplayIsShown) {
  ASSERT_EQ(identify({"scara.toml", "--quiet"}).exit_code, 0);
  const Outcome run = rivid::test::outcome_of(
      {RIVID_ONLINE, "scara_validation.csv", "--result", "scara_result"}, folder().path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json found = Json::parse(answer("scara_validation_online/online.html", R"(
  const width = document.documentElement.clientWidth;
  const blobs = [];
  URL.createObjectURL = (blob) => (blobs.push(blob), "#");
  document.querySelectorAll("figure.chart .tools button").forEach((button) => button.click());
  const texts = await Promise.all(blobs.map((blob) => blob.text()));
  return { width, page: document.documentElement.scrollWidth, figures: document.querySelectorAll("figure.chart").length,
           first: texts[0].split("\n")[0], files: texts.length, ids: [...document.querySelectorAll("nav a")].map((a) => a.hash) };)",
                                        {"--window-size=390,844"}));
  EXPECT_LE(found.at("page"), found.at("width"));
  EXPECT_EQ(found.at("figures"), 5);
  EXPECT_EQ(found.at("files"), 10) << "CSV and SVG of each";
  EXPECT_EQ(found.at("first"), "series,t [s],mass [kg],upper");
  EXPECT_EQ(found.at("ids"), Json({"#payload", "#friction", "#contact"}));
}

#ifdef RIVID_EXCITE

// The six-joint arm above a floor and beside a box.
class ExcitePage : public Page {
 protected:
  void design(const std::vector<std::string>& more = {}) const {
    const std::filesystem::path arm = std::filesystem::path(RIVID_DATA) / "six_axis";
    folder().write("six_axis.urdf", rivid::test::content_of(arm / "six_axis.urdf"));
    folder().write("excite.toml",
                   rivid::test::content_of(arm / "excite.toml") +
                       "[excitation.space]\nfloor = -0.1\n[[excitation.space.boxes]]\nname = \"table\"\n"
                       "min = [0.9, -0.5, -0.1]\nmax = [1.4, 0.5, 0.2]\n");
    std::vector<std::string> command = {RIVID_EXCITE, "excite.toml", "--report",
                                        "--output",   "plan",        "--starts",
                                        "1",          "--set",       "excitation.evaluations=30"};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome run = rivid::test::outcome_of(command, folder().path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
};

TEST_F(ExcitePage, ADesignIsShownWithItsMotionObstaclesAndInformation) {
  design();
  // q, q̇, q̈ and τ of six joints, distances and information over time, the path in space.
  expect_figures("plan/report.html", 4 * 6 + 2 + 1, 0);
  const Json found = Json::parse(answer("plan/report.html", R"(
  const path = () => document.querySelector("#motion-in-space polyline.path-of-tool").getAttribute("points");
  const before = path();
  document.querySelector("#motion-in-space .picture").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
  const arm = () => document.querySelector("#motion-in-space polyline.arm").getAttribute("points");
  const at_rest = arm();
  const slider = document.querySelector("#motion-in-space input");
  slider.value = slider.max / 2;
  slider.dispatchEvent(new Event("input"));
  const column = (section, heading) => {
    const table = document.querySelector(section).closest("section").querySelector(".scroll table");
    const at = [...table.tHead.rows[0].cells].findIndex((cell) => cell.textContent === heading);
    return [...table.tBodies[0].rows].map((row) => row.cells[at].textContent);
  };
  const shares = [...document.querySelectorAll(`.first-look tbody td:nth-child(2)`)].map((cell) => parseFloat(cell.textContent));
  return { turned: path() !== before, moved: arm() !== at_rest,
           instant: document.querySelector("#motion-in-space .player span").textContent,
           curves: document.querySelectorAll("#clearances-over-time .curve").length, obstacles: document.querySelectorAll("#motion-in-space .obstacle").length,
           why: column("#parameters", "why").length, used: column("#limits", "used").map(parseFloat),
           distances: column("#clearances", "smallest distance m").length,
           information: shares.reduce((sum, share) => sum + share, 0) };)"));
  EXPECT_TRUE(found.at("turned").get<bool>());
  EXPECT_TRUE(found.at("moved").get<bool>());
  const Json plan = Json::parse(folder().read("plan/plan.json"));
  EXPECT_NEAR(std::stod(found.at("instant").get<std::string>()), 0.5 * plan.at("duration").get<double>(),
              0.1);
  const Json& pairs = plan.at("clearances");
  EXPECT_EQ(found.at("curves"),
            std::ranges::count_if(pairs, [](const Json& pair) { return !pair.at("wanted").is_null(); }));
  EXPECT_EQ(found.at("obstacles"), 2) << "floor and table";
  EXPECT_EQ(found.at("why"), 52);
  EXPECT_EQ(found.at("distances"), pairs.size());
  for (const double used : found.at("used")) {
    EXPECT_LE(used, 100.0);
  }
  // Six rounded percentages.
  EXPECT_NEAR(found.at("information").get<double>(), 100.0, 0.5) << found;
}

TEST_F(ExcitePage, IsNoWiderThanAPhoneAndLoadsNothing) {
  design();
  const Json found = Json::parse(answer("plan/report.html", R"(
  const width = document.documentElement.clientWidth;
  const wide = [...document.querySelectorAll("main figure, main p, main h2, main li")].filter(
      (part) => part.getBoundingClientRect().right > width + 1);
  return { width, page: document.documentElement.scrollWidth, wide: wide.map((part) => part.outerHTML.slice(0, 80)),
           loaded: performance.getEntriesByType("resource").length };)",
                                        {"--window-size=390,844"}));
  EXPECT_LE(found.at("page"), found.at("width")) << found;
  EXPECT_TRUE(found.at("wide").empty()) << found;
  EXPECT_EQ(found.at("loaded"), 0);
}

#endif

TEST_F(Page, PrefilterEssentialAndPhysicalParametersAreShown) {
  provide_iv("prefilter = true\nessential = true\nphysical = true");
  ASSERT_EQ(identify({"scara_iv.toml", "--report"}).exit_code, 0);
  expect_figures("scara_iv_result/report.html", 9 + 2 * 8 + 2 + 3, 9);
  const std::string page = opened("scara_iv_result/report.html").out;
  for (const char* const section : {"prefilter", "essential", "physical"}) {
    EXPECT_EQ(count(page, "<h2 id=\"" + std::string(section) + "\""), 1U) << section;
    EXPECT_EQ(count(page, "href=\"#" + std::string(section) + "\""), 1U) << section;
  }
  EXPECT_NE(page.find("<ellipse class=\"identified\""), std::string::npos);
}

TEST_F(Page, AResultThatIsNotIdentifiedIsShown) {
  // Joint 2 stands still.
  rewrite_rows("scara_s2.csv", [](std::string line) {
    const std::size_t q2 = line.find(',', line.find(',') + 1) + 1;
    return line.replace(q2, line.find(',', q2) - q2, "0.5");
  });
  ASSERT_EQ(identify({"scara.toml", "--report"}).exit_code, 1);
  const Json found = Json::parse(answer("scara_result/report.html", R"(
  return { verdict: document.querySelector(".verdict").className, first: document.querySelector("#worst-joint .curve") !== null,
           friction: document.getElementById("friction-2") !== null };)"));
  EXPECT_EQ(found.at("verdict"), "verdict bad");
  EXPECT_EQ(found.at("first"), true);
  EXPECT_EQ(found.at("friction"), false) << "joint 2 has no row";
}

}  // namespace
