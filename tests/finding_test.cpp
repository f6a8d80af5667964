// The table of diagnostic codes, and the page that shows it.

#include "rivid/finding.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "rivid/identify/identification.hpp"
#include "support/temporary_folder.hpp"

namespace rivid {
namespace {

TEST(DiagnosticCodes, AreDifferentAndFullSentences) {
  std::set<std::string_view> seen;
  for (const DiagnosticCode& c : diagnostic_codes()) {
    EXPECT_TRUE(seen.insert(c.code).second) << c.code;
    for (const std::string_view text : {c.meaning, c.cause, c.cure}) {
      EXPECT_TRUE(text.ends_with('.')) << c.code << ": " << text;
    }
  }
}

TEST(DiagnosticCodes, AreFoundByTheirNames) {
  EXPECT_EQ(diagnostic_code("torque_sign")->severity, Severity::error);
  EXPECT_FALSE(diagnostic_code("torque_sing"));
}

// One line a severity, the gravest first.
TEST(DiagnosticCodes, StandOnTheirPageToTheLetter) {
  std::string page = test::content_of(std::filesystem::path(RIVID_DOCS) / "diagnostics.md");
  std::ranges::replace(page, '\n', ' ');
  for (const auto& [severity, heading] :
       {std::pair{Severity::error, "**Errors**: "}, std::pair{Severity::warning, "**Warnings**: "},
        std::pair{Severity::note, "**Notes**: "}}) {
    std::string expected;
    for (const DiagnosticCode& c : diagnostic_codes()) {
      if (c.severity == severity) {
        expected += (expected.empty() ? heading : ", ") + ("`" + std::string(c.code) + "`");
      }
    }
    expected += ".";
    EXPECT_NE(page.find(" " + expected + " "), std::string::npos)
        << "docs/diagnostics.md must show, in lines of 110 characters:\n"
        << expected;
  }
}

// The sources of the library and of the tools, by their paths.
std::vector<std::pair<std::string, std::string>> sources() {
  std::vector<std::pair<std::string, std::string>> out;
  const std::filesystem::path root = std::filesystem::path(RIVID_DOCS).parent_path();
  for (const char* const folder : {"include", "src", "apps"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
      if (entry.path().extension() == ".cpp" || entry.path().extension() == ".hpp") {
        out.emplace_back(entry.path().lexically_relative(root).string(), test::content_of(entry.path()));
      }
    }
  }
  return out;
}

std::vector<std::string> found(const std::string& text, const char* pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> out;
  for (auto at = std::sregex_iterator(text.begin(), text.end(), regex); at != std::sregex_iterator(); ++at) {
    out.push_back((*at)[1].str());
  }
  return out;
}

TEST(DiagnosticCodes, AreAllThatIsWarnedWithAndEachIsUsed) {
  std::set<std::string> used;
  std::set<std::string> quoted;
  for (const Status status : {Status::rank_deficient, Status::not_converged, Status::cycling,
                              Status::weak_instruments, Status::not_simulable, Status::gave_up}) {
    used.emplace(name(status));
  }
  for (const auto& [path, text] : sources()) {
    std::vector<std::string> codes = found(text, R"re(\bFinding\{\s*"([^"]*)")re");
    if (path.find("identify/check") != std::string::npos) {
      for (const char* const pattern : {R"re(\badd\(\s*"([^"]*)")re", R"re(push_back\(\{\s*"([^"]*)")re"}) {
        std::ranges::move(found(text, pattern), std::back_inserter(codes));
      }
    }
    used.insert(codes.begin(), codes.end());
    if (!path.ends_with("src/finding_codes.hpp")) {
      std::ranges::move(found(text, R"re("([a-z_]+)")re"), std::inserter(quoted, quoted.end()));
    }
    for (const std::string& what : found(text, R"re((?:warnings|faults)_?\.push_back\(\s*(.{8}))re")) {
      EXPECT_EQ(what, "Finding{") << path << ": a warning without a code";
    }
  }
  for (const std::string& code : used) {
    EXPECT_TRUE(diagnostic_code(code)) << code << " is not in the table";
  }
  for (const DiagnosticCode& c : diagnostic_codes()) {
    EXPECT_TRUE(quoted.contains(std::string(c.code))) << c.code << " is never used";
  }
}

TEST(Finding, TakesSeverityAndCureFromTheTable) {
  const Finding finding{"torque_sign", "joint_1", "its torque has the other sign"};
  EXPECT_EQ(severity(finding), Severity::error);
  EXPECT_EQ(cure(finding), diagnostic_code("torque_sign")->cure);
  EXPECT_EQ(in_words(finding), "error [torque_sign] joint_1: its torque has the other sign");
  EXPECT_EQ(in_words(Finding{"log_note", "", "the text"}), "note [log_note] the text");
}

}  // namespace
}  // namespace rivid
