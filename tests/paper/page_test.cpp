// The rows of rivid in the table of docs/paper.md are what data/scara/paper_s2.toml gives.
//
// After a change that moves them: RIVID_WRITE_PAGES=1 build/test/tests/paper_page_test

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <numeric>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/experiment/monte_carlo.hpp"

namespace {

using rivid::MonteCarloParameter;
using rivid::MonteCarloSummary;

// "3.4434±0.0025", the deviation with two digits.
std::string cell(double value, double sigma) {
  std::ostringstream out;
  const int decimals = std::max(0, 1 - static_cast<int>(std::floor(std::log10(sigma))));
  out << std::fixed << std::setprecision(decimals) << value << "±" << sigma;
  return out.str();
}

std::string row(const MonteCarloSummary& of) {
  std::string out = "| " + of.label + " |";
  for (const MonteCarloParameter& p : of.parameters) {
    out += " " + cell(p.truth + p.bias, p.sigma_over_spread * p.spread) + " |";
  }
  return out;
}

// Values and deviations of a row.
std::vector<std::array<double, 2>> numbers(const std::string& line) {
  std::vector<std::array<double, 2>> out;
  std::istringstream cells(line.substr(line.find('|', 1) + 1));
  for (std::string text; std::getline(cells, text, '|');) {
    std::array<double, 2> read = {};
    const std::size_t sign = text.find("±");
    if (sign != std::string::npos) {
      read = {std::stod(text), std::stod(text.substr(sign + std::string_view("±").size()))};
      out.push_back(read);
    }
  }
  return out;
}

TEST(PageOfThePaper, HasTheMeansOfTheStudy) {
  const rivid::MonteCarlo plan = rivid::read_monte_carlo(RIVID_DATA "/scara/paper_s2.toml");
  std::vector<int> runs(static_cast<std::size_t>(plan.runs));
  std::iota(runs.begin(), runs.end(), 0);
  std::vector<rivid::MonteCarloRow> rows;
  monte_carlo_runs(plan, runs, 1, [&](const auto& of) { rows.insert(rows.end(), of.begin(), of.end()); });

  const std::string path = RIVID_DOCS "/paper.md";
  std::stringstream page;
  page << std::ifstream(path).rdbuf();
  std::string text = page.str();
  // Columns of the page.
  constexpr std::array<const char*, 8> names = {"ZZ1R", "Fv1", "Fc1", "ZZ2", "MX2", "MY2", "Fv2", "Fc2"};
  for (const MonteCarloSummary& trial : summaries(plan, rows)) {
    EXPECT_EQ(trial.identified, plan.runs) << trial.label;
    for (std::size_t i = 0; i < names.size(); ++i) {
      EXPECT_EQ(trial.parameters.at(i).name, names[i]);
    }
    // The page says 2, and 3 to 4; single runs may take one more by another rounding.
    if (trial.label.starts_with("Table 2")) {
      EXPECT_LT(trial.mean_iterations, 2.5);
    } else if (trial.label.starts_with("Table 3")) {
      EXPECT_LT(trial.mean_iterations, 4.0);
    }
    const std::size_t begin = text.find("| " + trial.label + " |");
    ASSERT_NE(begin, std::string::npos) << trial.label;
    const std::size_t end = text.find('\n', begin);
    const auto printed = numbers(text.substr(begin, end - begin));
    text.replace(begin, end - begin, row(trial));
    if (std::getenv("RIVID_WRITE_PAGES") != nullptr) {
      continue;
    }
    const auto found = numbers(row(trial));
    ASSERT_EQ(printed.size(), 8U) << trial.label;
    for (std::size_t i = 0; i < 8; ++i) {
      // Signs that flip with the last bits move single runs, and the mean by a twentieth of that.
      EXPECT_NEAR(printed[i][0], found[i][0], 0.1 * found[i][1]) << trial.label << ", parameter " << i;
      EXPECT_NEAR(printed[i][1], found[i][1], 0.1 * found[i][1]) << trial.label << ", parameter " << i;
    }
  }
  if (std::getenv("RIVID_WRITE_PAGES") != nullptr) {
    std::ofstream(path) << text;
  }
}

}  // namespace
