// The lists of docs/experiment.md, docs/experiment_more.md, docs/result.md and docs/excite.md are those of
// the fields, and the reader knows their keys.
//
// After a change of a field: RIVID_WRITE_PAGES=1 build/test/tests/report_page_tables_test

#include "report/page_tables.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "report/page_lists.hpp"
#include "rivid/experiment/excitation.hpp"
#include "rivid/experiment/experiment.hpp"
#include "rivid/experiment/monte_carlo.hpp"
#include "support/complaint.hpp"

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

TEST(PageTables, OfTheExperimentFileAreThoseOfItsFields) {
  expect_tables("experiment.md");
  expect_tables("experiment_more.md");
}
TEST(PageTables, OfTheResultAreThoseOfItsFields) { expect_tables("result.md"); }

TEST(PageTables, OfThePlanAreThoseOfItsFields) { expect_tables("excite.md"); }

TEST(PageTables, OfLimitsAreThoseOfTheFieldsAndCommandLines) { expect_tables("reliability.md"); }

TEST(ExperimentSchema, IsThatOfTheFields) {
  const std::string path = RIVID_DOCS "/experiment.schema.json";
  if (std::getenv("RIVID_WRITE_PAGES") != nullptr) {
    std::ofstream(path) << experiment_schema();
  }
  EXPECT_TRUE(text_of(path) == experiment_schema())
      << path << ": RIVID_WRITE_PAGES=1 with this program writes it anew";
}

// What is a count, a size, a tolerance or a time by its type, unit or name.
bool wants_limits(const KeyRow& row) {
  constexpr auto units = std::to_array<std::string_view>({"s", "Hz", "periods", "samples"});
  const auto has = [&](ValueKind kind) { return std::ranges::find(row.kinds, kind) != row.kinds.end(); };
  const bool column =
      has(ValueKind::column) || has(ValueKind::columns) || has(ValueKind::string) || has(ValueKind::table);
  return !column && (has(ValueKind::integer) || std::ranges::find(units, row.unit) != units.end() ||
                     row.key.find("tol") != std::string::npos || std::isfinite(row.range.least) ||
                     std::isfinite(row.range.most));
}

TEST(PageTables, HaveALeastAndAMostOfEachCountSizeToleranceAndTime) {
  int limited = 0;
  for (const auto& [name, rows] : key_rows()) {
    for (const KeyRow& row : rows) {
      if (wants_limits(row)) {
        ++limited;
        EXPECT_TRUE(std::isfinite(row.range.least) && std::isfinite(row.range.most))
            << name << "." << row.key;
      }
    }
  }
  EXPECT_GT(limited, 50);
}

// What an experiment that has the table says of a setting.
std::string refusal(const std::string& table, const std::string& setting) {
  const std::string data = RIVID_DATA;
  const std::vector<std::string> settings = {setting};
  return test::complaint_of([&] {
    if (table.starts_with("excitation")) {
      (void)read_excitation(data + "/six_axis/excite.toml", settings);
    } else if (table.starts_with("montecarlo")) {
      (void)read_monte_carlo(data + "/scara/montecarlo_s1.toml", settings);
    } else if (table.starts_with("simulation") || table.starts_with("reference")) {
      (void)read_experiment(data + "/scara/simulate_s1.toml", Use::simulation, settings);
    } else {
      (void)read_experiment(data + "/scara/scara_iv.toml", Use::identification, settings);
    }
  });
}

// 1e300, or as much as an integer may be, is too much for each key of the files that the repository has.
TEST(PageTables, HoldLimitsThatTheReaderKeeps) {
  const std::map<std::string, std::string> sections = {{"excitation", "excitation"},
                                                       {"excitation.target", "excitation.target"},
                                                       {"excitation.limits", "excitation.limits"},
                                                       {"excitation.space", "excitation.space"},
                                                       {"montecarlo", "montecarlo"},
                                                       {"simulation", "simulation"},
                                                       {"reference.point_to_point", "reference"},
                                                       {"control", "control"},
                                                       {"log", "log"},
                                                       {"log.reference_file", "log.reference_file"},
                                                       {"signal", "signal"},
                                                       {"method", "method"},
                                                       {"method.iv", "method"},
                                                       {"method.physical", "method.physical"},
                                                       {"method.essential", "method.essential"},
                                                       {"robot", "robot"}};
  int kept = 0;
  for (const auto& [table, rows] : key_rows()) {
    const auto section = sections.find(table);
    for (const KeyRow& row : rows) {
      if (section == sections.end() || !(row.range.most <= largest_number)) {
        continue;
      }
      const std::string key = section->second + "." + row.key;
      const bool integer = std::ranges::find(row.kinds, ValueKind::integer) != row.kinds.end();
      const std::string most = !integer               ? "1e300"
                               : row.range.most < 2e9 ? "2000000000"
                                                      : "9000000000000000000";
      std::string setting =
          key + "=" + (row.kinds.front() == ValueKind::two_numbers ? "[0, " + most + "]" : most);
      if (table == "log.reference_file") {
        setting = section->second + "={ file = \"a.csv\", " + row.key + " = " + most + " }";
      }
      const std::string said = refusal(table, setting);
      EXPECT_NE(said.find(row.key + " "), std::string::npos) << setting << ": " << said;
      EXPECT_NE(said.find("must "), std::string::npos) << setting << ": " << said;
      ++kept;
    }
  }
  EXPECT_GT(kept, 50);
}

// What a key may be is said by the type of its member alone.
TEST(PageTables, TakeTypesFromMembers) {
  const auto tables = key_rows();
  const auto type = [&](const std::string& table, const std::string& key) {
    const std::vector<KeyRow>& rows = tables.at(table);
    const auto row = std::ranges::find(rows, key, &KeyRow::key);
    return row == rows.end() ? "nothing" : row->type;
  };
  EXPECT_EQ(type("robot", "urdf"), "file");
  EXPECT_EQ(type("robot", "gravity"), "three numbers");
  EXPECT_EQ(type("robot", "gear_matrix"), "list of lists");
  EXPECT_EQ(type("robot", "coupling"), "list of tables");
  EXPECT_EQ(type("log", "files"), "files");
  EXPECT_EQ(type("log", "position"), "columns");
  EXPECT_EQ(type("log", "time"), "column");
  EXPECT_EQ(type("log", "max_gap"), "number") << "a key of an embedded record";
  EXPECT_EQ(type("log.column", "column"), "string or integer");
  EXPECT_EQ(type("signal", "cutoff_hz"), "number or `\"off\"`");
  EXPECT_EQ(type("signal", "torque_held"), "boolean or `\"auto\"`");
  EXPECT_EQ(type("signal", "decimation"), "integers or `\"auto\"`");
  EXPECT_EQ(type("signal", "window"), "two numbers");
  EXPECT_EQ(type("method", "physical"), "boolean or table");
  EXPECT_EQ(type("method", "gains"), "word or table");
  EXPECT_EQ(type("method.iv", "prefilter"), "boolean or integer");
  EXPECT_EQ(type("method.iv", "initial_state"), "word");
  EXPECT_EQ(type("control", "omega_n"), "numbers");
  EXPECT_EQ(type("control", "velocity_filter"), "word or numbers");
  EXPECT_EQ(type("simulation", "record"), "words");
}

TEST(PageTables, AreAllOnAPage) {
  const std::string pages = text_of(RIVID_DOCS "/experiment.md") + text_of(RIVID_DOCS "/experiment_more.md") +
                            text_of(RIVID_DOCS "/result.md") + text_of(RIVID_DOCS "/excite.md") +
                            text_of(RIVID_DOCS "/reliability.md");
  for (const auto& [name, table] : page_tables()) {
    EXPECT_NE(pages.find("<!-- table: " + name + " -->"), std::string::npos) << name;
  }
}

TEST(PageTables, ExplainEachWordThatAKeyCanBeSetTo) {
  const std::string page = text_of(RIVID_DOCS "/experiment.md") + text_of(RIVID_DOCS "/experiment_more.md");
  for (const auto& [name, rows] : key_rows()) {
    for (const KeyRow& row : rows) {
      for (const std::string& word : row.words) {
        EXPECT_NE(page.find("`\"" + word + "\"`"), std::string::npos)
            << name << "." << row.key << ": " << word;
      }
    }
  }
}

}  // namespace
}  // namespace rivid::detail
