// Intervals of real robots: what disjoint logs of one robot say of a parameter differs by no more than their
// intervals tell, in 95 of 100 cases if these know the errors of the model.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <vector>

#include "rivid/identify/check.hpp"
#include "support/real_experiment.hpp"

namespace {

using rivid::Index;

template <const char* Robot>
class Disjoint : public rivid::test::RealExperiment {
 protected:
  Disjoint() : RealExperiment(Robot) {}

  // Every log, or each of so many parts of it, by itself, as a newcomer would identify it.
  [[nodiscard]] std::vector<rivid::Identification> parts(Index of_each) const {
    const rivid::Experiment e = experiment();
    std::vector<rivid::Identification> out;
    std::vector<rivid::Log> logs = read_logs(e.log, e.robot);
    if (logs.size() == 1 && of_each == 1) {
      std::ranges::move(read_logs(e.validation, e.robot), std::back_inserter(logs));
    }
    for (const rivid::Log& log : logs) {
      for (Index k = 0; k < of_each; ++k) {
        const Index count = log.samples() / of_each;
        const rivid::Log part = excerpt(log, k * count, count);
        out.push_back(identify(e.robot, part, {}));
      }
    }
    return out;
  }

  // Share of the differences within their 95 % intervals.
  static double within(const std::vector<rivid::Identification>& parts, int& pairs) {
    double inside = 0.0;
    double all = 0.0;
    for (std::size_t a = 0; a < parts.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        for (std::size_t i = 0; i < parts[a].parameters.size(); ++i) {
          const rivid::ParameterEstimate& x = parts[a].parameters[i];
          const rivid::ParameterEstimate& y = parts[b].parameters[i];
          const double half =
              0.5 * std::hypot(x.interval_95[1] - x.interval_95[0], y.interval_95[1] - y.interval_95[0]);
          if (std::isfinite(half)) {
            inside += std::abs(x.value - y.value) < half ? 1.0 : 0.0;
            all += 1.0;
          }
        }
        ++pairs;
      }
    }
    return all > 0.0 ? inside / all : 0.0;
  }

  void expect_within(Index of_each, double least) const {
    int pairs = 0;
    const double share = within(parts(of_each), pairs);
    std::cout << "[ SHARE    ] " << Robot << ": " << 100.0 * share << " % of the differences of " << pairs
              << " pairs\n";
    RecordProperty("share_percent", std::to_string(100.0 * share));
    EXPECT_GE(share, least);
  }
};

constexpr char panda[] = "panda";
constexpr char ur10e[] = "ur10e";
constexpr char emps[] = "emps";
constexpr char tx40[] = "tx40";
constexpr char kuka_kr300[] = "kuka_kr300";

using DisjointPanda = Disjoint<panda>;
using DisjointUr10e = Disjoint<ur10e>;
using DisjointEmps = Disjoint<emps>;
using DisjointTx40 = Disjoint<tx40>;
using DisjointKuka = Disjoint<kuka_kr300>;

TEST_F(DisjointUr10e, LogsAgree) { expect_within(1, 0.92); }
TEST_F(DisjointKuka, LogsAgree) { expect_within(1, 0.92); }
TEST_F(DisjointPanda, ThirdsAgree) { expect_within(3, 0.92); }
TEST_F(DisjointTx40, HalvesAgree) { expect_within(2, 0.92); }
TEST_F(DisjointEmps, HalvesAgree) { expect_within(2, 0.92); }

}  // namespace
