// What a person sees: at most 40 lines of 100 columns, kept in tests/cli/screens.
// After a change of words: RIVID_WRITE_PAGES=1 build/test/tests/cli_screens_test

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "rivid/text.hpp"
#include "support/identify_tool.hpp"

namespace {

class Screens : public rivid::test::IdentifyTool {
 protected:
  // The same as was kept under the name, and no larger than a screen.
  void expect_screen(const std::string& name, std::vector<std::string> arguments) const {
    std::string shown = "$ rivid";
    for (const std::string& argument : arguments) {
      shown += " " + argument;
    }
    arguments.insert(arguments.begin(), RIVID_PROGRAM);
    const rivid::test::Outcome run = rivid::test::outcome_of(arguments, folder().path());
    shown += "\n" + run.out + run.err + "[" + std::to_string(run.exit_code) + "]\n";
    constexpr std::size_t columns = 100;
    std::size_t rows = 0;
    // Messages stay on one line, for grep, which a terminal breaks.
    std::istringstream lines(run.out + run.err);
    for (std::string line; std::getline(lines, line);) {
      rows += 1 + rivid::display_width(line) / (columns + 1);
    }
    EXPECT_LE(rows, 40U) << shown;
    std::istringstream answer(run.out);
    for (std::string line; std::getline(answer, line);) {
      EXPECT_LE(rivid::display_width(line), columns) << line;
    }
    const std::filesystem::path kept = std::filesystem::path(RIVID_SCREENS) / (name + ".txt");
    if (std::getenv("RIVID_WRITE_PAGES") != nullptr) {
      std::ofstream(kept) << shown;
    }
    EXPECT_EQ(shown, rivid::test::content_of(kept)) << "RIVID_WRITE_PAGES=1 with this program writes it anew";
  }

  // A motor that turns the other way.
  void reverse_the_second_motor() const {
    edit("scara.toml", "control = [\"v1\", \"v2\"]", "control = [\"v1\", { column = \"v2\", sign = -1 }]");
  }
};

TEST_F(Screens, OfAResult) {
  expect_screen("help", {});
  expect_screen("identify", {"identify", "scara.toml", "--physical", "--report"});
  expect_screen("validate", {"validate", "scara_result", "scara_validation.csv"});
  expect_screen("compare", {"compare", "scara_result", "scara.urdf", "--log", "scara_validation.csv"});
  expect_screen("export", {"export", "scara_result", "--to", "urdf"});
  expect_screen("export_header", {"export", "scara_result", "--to", "header"});
  expect_screen("check", {"check", "scara.toml"});
  expect_screen("payload", {"payload", "scara.toml", "--loaded", "scara_validation.csv"});
  expect_screen("online", {"online", "scara_validation.csv", "--result", "scara_result"});
  expect_screen("factors", {"factors", "scara.toml", "--output", "a.factors"});
  expect_screen("merge", {"merge", "a.factors", "--output", "merged"});
}

TEST_F(Screens, OfTheHelpOfEachCommand) {
  std::istringstream overview(rivid::test::outcome_of({RIVID_PROGRAM, "help"}, folder().path()).out);
  int commands = 0;
  for (std::string line, program, word; std::getline(overview, line);) {
    std::istringstream(line) >> program >> word;
    if (program == "rivid" && word != "help") {
      expect_screen("help_" + word, {"help", word});
      ++commands;
    }
  }
  EXPECT_EQ(commands, 18);
}

TEST_F(Screens, OfADoubtfulResult) {
  reverse_the_second_motor();
  expect_screen("check_doubtful", {"check", "scara.toml"});
  expect_screen("identify_doubtful", {"identify", "scara.toml"});
  expect_screen("validate_doubtful", {"validate", "scara_result", "scara_validation.csv"});
  expect_screen("export_doubtful", {"export", "scara_result", "--to", "header"});
}

TEST_F(Screens, OfWhatIsRefused) {
  expect_screen("explain", {"explain", "torque_sign"});
  expect_screen("mistyped_command", {"idnetify", "scara.toml"});
  expect_screen("mistyped_option", {"identify", "scara.toml", "--phisical"});
  expect_screen("mistyped_key", {"identify", "scara.toml", "--set", "signal.decimaton=5"});
  expect_screen("missing_log", {"identify", "scara.toml", "--log", "scara_s3.csv"});
  std::filesystem::remove(folder().path() / "scara.toml");
  expect_screen("init", {"init", "scara.urdf", "scara_s2.csv", "scara_validation.csv"});
  keep_lines("scara_s2.csv", 140);
  expect_screen("identify_refused", {"identify", "scara.toml"});
}

}  // namespace
