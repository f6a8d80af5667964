#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace rivid::test {

/// The rows of tests/solve/statistics_oracle.csv that begin with a name.
inline std::vector<std::vector<double>> statistics_oracle(const std::string& name) {
  std::vector<std::vector<double>> out;
  std::ifstream file(std::filesystem::path(RIVID_TEST_DATA) / "solve/statistics_oracle.csv");
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    std::string cell;
    std::getline(cells, cell, ',');
    if (cell != name) {
      continue;
    }
    std::vector<double>& row = out.emplace_back();
    while (std::getline(cells, cell, ',')) {
      row.push_back(std::stod(cell));
    }
  }
  return out;
}

}  // namespace rivid::test
