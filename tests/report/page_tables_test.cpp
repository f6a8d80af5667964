// The tables of docs/experiment.md, docs/result.md and docs/excite.md are those of the fields, and the reader knows their keys.
//
// After a change of a field: RIVID_WRITE_PAGES=1 build/test/tests/report_page_tables_test

#include "report/page_tables.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace rivid::detail {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void expect_tables(const std::string& name) {
  const std::string path = RIVID_DOCS "/" + name;
  const std::string page = text_of(path);
  const std::string wanted = with_tables(page);
  if (std::getenv("RIVID_WRITE_PAGES") != nullptr) {
    std::ofstream(path) << wanted;
    return;
  }
  std::istringstream have(page);
  std::istringstream want(wanted);
  std::string line;
  for (std::string required; std::getline(want, required);) {
    std::getline(have, line);
    ASSERT_EQ(line, required) << path << ": RIVID_WRITE_PAGES=1 with this program writes its tables anew";
  }
  EXPECT_EQ(page, wanted);
}

TEST(PageTables, OfTheExperimentFileAreThoseOfItsFields) { expect_tables("experiment.md"); }
TEST(PageTables, OfTheResultAreThoseOfItsFields) { expect_tables("result.md"); }

TEST(PageTables, OfThePlanAreThoseOfItsFields) { expect_tables("excite.md"); }

TEST(PageTables, AreAllOnAPage) {
  const std::string pages = text_of(RIVID_DOCS "/experiment.md") + text_of(RIVID_DOCS "/result.md") +
                            text_of(RIVID_DOCS "/excite.md");
  for (const auto& [name, table] : page_tables()) {
    EXPECT_NE(pages.find("<!-- table: " + name + " -->"), std::string::npos) << name;
  }
}

TEST(PageTables, ExplainEachWordThatAKeyCanBeSetTo) {
  const std::string page = text_of(RIVID_DOCS "/experiment.md");
  for (const std::string& word : words_of_keys()) {
    EXPECT_NE(page.find("`\"" + word + "\"`"), std::string::npos) << word;
  }
}

}  // namespace
}  // namespace rivid::detail
