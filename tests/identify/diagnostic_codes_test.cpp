// The table of diagnostic codes, and the page that shows it.

#include "rivid/identify/diagnostic_codes.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <sstream>
#include <string>

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

TEST(DiagnosticCodes, StandOnTheirPageToTheLetter) {
  std::string expected = "| code | severity | meaning | cause | cure |\n|---|---|---|---|---|\n";
  for (const DiagnosticCode& c : diagnostic_codes()) {
    expected += "| `" + std::string(c.code) + "` | " + std::string(name(c.severity)) + " | " +
                std::string(c.meaning) + " | " + std::string(c.cause) + " | " + std::string(c.cure) + " |\n";
  }
  const std::string page = test::content_of(std::filesystem::path(RIVID_DOCS) / "diagnostics.md");
  EXPECT_NE(page.find("\n" + expected + "\n"), std::string::npos)
      << "docs/diagnostics.md must show this table:\n"
      << expected;
}

}  // namespace
}  // namespace rivid
