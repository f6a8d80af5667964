// rivid identify --write-friction: friction of each joint over its velocity, by the law and in the rows.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <vector>

#include "support/identify_tool.hpp"

namespace {

using rivid::test::Json;

using Line = std::map<std::string, std::string>;

std::vector<Line> lines_of(const std::string& csv) {
  std::istringstream text(csv);
  std::string line;
  std::getline(text, line);
  std::istringstream header(line);
  std::vector<std::string> names;
  for (std::string name; std::getline(header, name, ',');) {
    names.push_back(name);
  }
  std::vector<Line> out;
  while (std::getline(text, line)) {
    std::istringstream cells(line);
    std::size_t at = 0;
    Line& row = out.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) {
      row[names.at(at++)] = cell;
    }
  }
  return out;
}

double number(const Line& line, const char* column) { return std::stod(line.at(column)); }

class WriteFriction : public rivid::test::IdentifyTool {};

// φ = (q̇, sign q̇), whose parameters and covariance are those of the result.
TEST_F(WriteFriction, IsTheLawOfTheResultWithItsDeviation) {
  const Json result = result_of({"scara.toml", "--write-friction", "friction.csv"});
  const Json& parameters = result.at("parameters");
  const auto place = [&](const std::string& name) {
    std::size_t i = 0;
    while (parameters.at(i).at("name") != name) {
      ++i;
    }
    return i;
  };
  const auto lines = lines_of(folder().read("friction.csv"));
  ASSERT_EQ(lines.size(), 2U * 122U);
  const Json& covariance = result.at("covariance");
  const double quantile = covariance.at("quantile_975");
  for (const Line& line : lines) {
    const std::string joint = line.at("joint").substr(6);
    const double v = number(line, "velocity");
    const std::array<double, 2> phi = {v, v > 0.0 ? 1.0 : -1.0};
    const std::array<std::size_t, 2> at = {place("Fv" + joint), place("Fc" + joint)};
    double torque = 0.0;
    double variance = 0.0;
    for (std::size_t i = 0; i < 2; ++i) {
      torque += phi[i] * parameters.at(at[i]).at("value").get<double>();
      for (std::size_t j = 0; j < 2; ++j) {
        variance += phi[i] * phi[j] * covariance.at("C_chi").at(at[i]).at(at[j]).get<double>();
      }
    }
    const double sigma = std::sqrt(variance);
    EXPECT_NEAR(number(line, "friction"), torque, 1e-12);
    EXPECT_NEAR(number(line, "sigma"), sigma, 1e-9 * sigma);
    EXPECT_NEAR(number(line, "low_95"), torque - quantile * sigma, 1e-6 * sigma);
    EXPECT_NEAR(number(line, "high_95"), torque + quantile * sigma, 1e-6 * sigma);
  }
}

// The means of the rows scatter about the law by their noise, and the rows of the validation are not among
// them.
TEST_F(WriteFriction, HasTheMeansOfTheRowsOfTheFit) {
  const Json result = result_of({"scara.toml", "--write-friction", "friction.csv"});
  std::map<std::string, double> rows;
  std::map<std::string, double> squares;
  std::map<std::string, double> bins;
  for (const Line& line : lines_of(folder().read("friction.csv"))) {
    const double count = number(line, "rows");
    rows[line.at("joint")] += count;
    if (count > 0.0) {
      const double off = number(line, "measured") - number(line, "friction");
      squares[line.at("joint")] += count * off * off;
      bins[line.at("joint")] += 1.0;
    } else {
      EXPECT_EQ(line.at("measured"), "nan");
    }
  }
  for (const Json& joint : result.at("fit").at("joints")) {
    const std::string name = joint.at("name");
    EXPECT_EQ(rows.at(name), joint.at("rows").get<double>());
    // A mean of so many rows has the variance of one over their number; four deviations of the mean of
    // chi-squares.
    const double sigma = joint.at("sigma_rho");
    const double mean = squares.at(name) / bins.at(name) / (sigma * sigma);
    EXPECT_GT(bins.at(name), 40.0);
    EXPECT_LT(mean, 1.0 + 4.0 * std::sqrt(2.0 / bins.at(name))) << name;
    EXPECT_GT(mean, 1.0 - 4.0 * std::sqrt(2.0 / bins.at(name))) << name;
  }
}

TEST_F(WriteFriction, IsACsvFile) {
  expect_refused({"--write-friction: friction.npz must end in .csv"},
                 {"scara.toml", "--write-friction", "friction.npz"});
}

}  // namespace
