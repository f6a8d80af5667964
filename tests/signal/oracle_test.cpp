#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "rivid/signal/decimate.hpp"
#include "rivid/signal/filter.hpp"
#include "signal/probe.hpp"

// oracle.csv is what SciPy makes of the same filters and the same series; oracle.py wrote it.

namespace rivid {
namespace {

using probe::series;

constexpr double f_m = 200.0;
constexpr double cutoff_hz = 20.0;
constexpr Index length = 160;

std::map<std::string, Vector> read_oracle() {
  std::map<std::string, Vector> cases;
  std::ifstream file(std::filesystem::path(RIVID_TEST_DATA) / "signal/oracle.csv");
  std::string line;
  while (std::getline(file, line)) {
    if (line.starts_with('#')) {
      continue;
    }
    std::istringstream cells(line);
    std::string name;
    std::getline(cells, name, ',');
    std::vector<double> values;
    for (std::string cell; std::getline(cells, cell, ',');) {
      values.push_back(std::stod(cell));
    }
    cases[name] = Eigen::Map<const Vector>(values.data(), static_cast<Index>(values.size()));
  }
  return cases;
}

Vector oracle(const std::string& name) {
  static const std::map<std::string, Vector> cases = read_oracle();
  return cases.at(name);
}

// Largest difference in units of the oracle's largest value.
double relative_error(const Matrix& got, const std::string& name) {
  const Vector expected = oracle(name);
  EXPECT_EQ(got.rows(), expected.size()) << name;
  EXPECT_EQ(got.cols(), 1) << name;
  const double error = (got - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
  return error;
}

Vector gains(const Filter& filter) {
  const Vector frequencies_hz = oracle("frequencies_hz");
  Vector out(frequencies_hz.size());
  std::transform(frequencies_hz.begin(), frequencies_hz.end(), out.begin(),
                 [&](double f_hz) { return gain(filter, f_hz, f_m); });
  return out;
}

const std::map<std::string, Convention> conventions = {{"standard", Convention::standard},
                                                       {"matlab", Convention::matlab}};

// Other factors of the same transfer function: both round, and a pole near z = 1 amplifies it.
constexpr double other_algorithm = 1e-13;

// SciPy's own sections lose (f_m / (π f_c))² ε for the slowest pole pair, f_c = 0.004 f_m / 2 at n_d = 100.
constexpr double narrow_filter = 1e-11;

TEST(SignalOracle, ButterworthHasTheGainOfScipy) {
  for (int order = 1; order <= 8; ++order) {
    EXPECT_LT(relative_error(gains(butterworth(order, cutoff_hz, f_m)),
                             "gain butterworth " + std::to_string(order)),
              other_algorithm)
        << "order " << order;
  }
}

TEST(SignalOracle, Chebyshev1HasTheGainOfScipy) {
  for (int order = 1; order <= 8; ++order) {
    EXPECT_LT(relative_error(gains(chebyshev1(order, 0.5, cutoff_hz, f_m)),
                             "gain chebyshev1 " + std::to_string(order)),
              other_algorithm)
        << "order " << order;
  }
}

TEST(SignalOracle, ZeroPhaseIsSosfiltfilt) {
  for (const auto& [name, convention] : conventions) {
    for (int order = 1; order <= 8; ++order) {
      EXPECT_LT(relative_error(zero_phase(series(length), f_m, cutoff_hz, order, convention),
                               "zero_phase butterworth " + std::to_string(order) + " " + name),
                other_algorithm)
          << "order " << order << " " << name;
    }
  }
  EXPECT_LT(
      relative_error(zero_phase(series(length), chebyshev1(8, 0.05, cutoff_hz, f_m), Convention::matlab),
                     "zero_phase chebyshev1 8 matlab"),
      other_algorithm);
}

TEST(SignalOracle, ZeroPhaseIsSosfiltfiltAtAVeryLowCutoff) {
  EXPECT_LT(relative_error(zero_phase(series(length), f_m, 0.2, 4, Convention::matlab),
                           "zero_phase butterworth 4 at 0.2 Hz matlab"),
            narrow_filter);
}

TEST(SignalOracle, DecimateIsSosfiltfiltAndEveryNthSampleUpToAHundred) {
  for (const auto& [name, convention] : conventions) {
    for (const int n_d : {2, 10, 20, 50, 100}) {
      EXPECT_LT(relative_error(decimate(series(20 * n_d - n_d / 3), n_d, convention),
                               "decimate " + std::to_string(n_d) + " " + name),
                narrow_filter)
          << "n_d " << n_d << " " << name;
    }
  }
}

}  // namespace
}  // namespace rivid
