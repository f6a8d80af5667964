// The page that rivid_identify writes with --report; page_test has what a browser makes of it.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <sstream>

#include "rivid/text.hpp"
#include "support/identify_tool.hpp"

namespace {

using rivid::test::Outcome;

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
  EXPECT_TRUE(
      run.err.ends_with("wrote scara_result/result.json\nwrote scara_result/report.html\n"
                        "next: rivid export scara_result --to header\n"))
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

TEST_F(Report, TablesFollowTheWidthOfTheTerminal) {
  if (!std::filesystem::exists("/usr/bin/script")) {
    GTEST_SKIP() << "script of util-linux, which makes a terminal, was not found";
  }
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal < 0) {
    GTEST_SKIP() << "this system gives no terminals (/dev/ptmx)";
  }
  ::close(terminal);
  constexpr std::size_t columns = 60;
  const Outcome run =
      rivid::test::outcome_of({"/usr/bin/script", "--quiet", "--return", "--command",
                               "stty cols " + std::to_string(columns) +
                                   "; " RIVID_IDENTIFY " scara.toml --verbose --color never 2>/dev/null",
                               "/dev/null"},
                              folder().path());
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_NE(run.out.find("  parameter  95 % interval"), std::string::npos) << "goes on below: " << run.out;
  std::istringstream lines(run.out.substr(run.out.find("\n  parameter")));
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(rivid::display_width(line), columns + 1) << line;  // and a carriage return
  }
}

TEST_F(Report, IsNotWrittenByADryRun) {
  const Outcome run = identify({"scara.toml", "--report", "--dry-run"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("would write scara_result/report.html\n"), std::string::npos) << run.out;
  EXPECT_FALSE(exists("scara_result"));
}

}  // namespace
