// Summaries of runs that are made up, so that what they must say is known.

#include "rivid/experiment/monte_carlo.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "rivid/error.hpp"
#include "support/monte_carlo_rows.hpp"

namespace rivid {
namespace {

using test::normal_error;
using test::rows_with;
using test::scara_plan;

constexpr int runs = 200;  // no multiple of 7, so that normal_error() takes every rank once
constexpr const char* label = "IV; exact rows";

MonteCarloSummary summary_of(const MonteCarlo& plan, const std::vector<MonteCarloRow>& rows) {
  for (const MonteCarloSummary& summary : summaries(plan, rows)) {
    if (summary.label == label) {
      return summary;
    }
  }
  ADD_FAILURE() << "no summary of " << label;
  return {};
}

TEST(MonteCarlo, AShareHasTheIntervalThatSciPyGives) {
  struct Case {
    int held;
    int runs;
    double low;
    double high;
  };
  // Of monte_carlo_oracle.py.
  constexpr Case cases[] = {
      {19, 20, 0.763868806553258, 0.9911185511992047},
      {20, 20, 0.8388748419471808, 1.0},
      {0, 20, 0.0, 0.16112515805281935},
      {285, 300, 0.9191529665272559, 0.9694683593706527},
      {229, 300, 0.7120967390716029, 0.8079112960834696},
  };
  constexpr double tolerance = 1e-13;  // another order of a dozen operations on numbers of order one
  for (const Case& c : cases) {
    SCOPED_TRACE(std::to_string(c.held) + " of " + std::to_string(c.runs));
    const MonteCarlo plan = scara_plan(c.runs);
    const MonteCarloSummary summary =
        summary_of(plan, rows_with(plan, label, [&](int run, Index) { return run < c.held ? 1.0 : 3.0; }));
    for (const MonteCarloParameter& p : summary.parameters) {
      EXPECT_NEAR(p.coverage, static_cast<double>(c.held) / c.runs, tolerance);
      EXPECT_NEAR(p.coverage_95[0], c.low, tolerance);
      EXPECT_NEAR(p.coverage_95[1], c.high, tolerance);
    }
  }
}

TEST(MonteCarlo, ErrorsOfANormalVariableAreUnbiasedAndHonest) {
  const MonteCarlo plan = scara_plan(runs);
  const MonteCarloSummary summary =
      summary_of(plan, rows_with(plan, label, [](int run, Index i) { return normal_error(run, i, runs); }));
  EXPECT_TRUE(summary.verdict.unbiased);
  EXPECT_TRUE(summary.verdict.honest);
  EXPECT_EQ(summary.outcomes, (std::map<std::string, int>{{"identified", runs}}));
  EXPECT_EQ(summary.most_iterations, 4);
  EXPECT_DOUBLE_EQ(summary.mean_iterations, 3.5);
  // Between two quantiles of 2.0 lies 95.45 % of the distribution.
  EXPECT_NEAR(summary.mean_coverage, 0.9545, 1.0 / runs);
}

TEST(MonteCarlo, OneBiasedParameterIsEnoughToBeBiased) {
  const MonteCarlo plan = scara_plan(runs);
  const auto with_bias = [&](double bias) {
    return summary_of(plan, rows_with(plan, label, [&](int run, Index i) {
                        return normal_error(run, i, runs) + (i == 3 ? bias : 0.0);
                      }));
  };
  // 0.2, and 1.96 / √200 that chance may have added.
  EXPECT_TRUE(with_bias(0.33).verdict.unbiased);
  EXPECT_FALSE(with_bias(0.35).verdict.unbiased);
  EXPECT_FALSE(with_bias(-0.35).verdict.unbiased);
}

TEST(MonteCarlo, ErrorBarsThatAreTooNarrowOrTooWideAreNotHonest) {
  const MonteCarlo plan = scara_plan(runs);
  const auto scaled = [&](double all, double one) {
    return summary_of(plan, rows_with(plan, label, [&](int run, Index i) {
                        return normal_error(run, i, runs) * (i == 5 ? one : all);
                      }));
  };
  EXPECT_TRUE(scaled(1.0, 1.0).verdict.honest);
  EXPECT_FALSE(scaled(1.4, 1.4).verdict.honest);  // 85 %
  EXPECT_FALSE(scaled(0.4, 0.4).verdict.honest);  // 100 %
  // One parameter alone may have error bars too wide, not too narrow.
  EXPECT_FALSE(scaled(1.0, 1.4).verdict.honest);
  EXPECT_TRUE(scaled(1.0, 0.4).verdict.honest);
}

TEST(MonteCarlo, EfficiencyComparesWithTheBoundAndNeedsOne) {
  MonteCarlo plan = scara_plan(runs);
  const auto times_the_bound = [&](double factor) {
    // The bound, from errors of one deviation.
    const MonteCarloSummary known =
        summary_of(plan, rows_with(plan, label, [](int run, Index i) { return normal_error(run, i, runs); }));
    return summary_of(plan, rows_with(plan, label, [&](int run, Index i) {
                        const double over = known.parameters[static_cast<std::size_t>(i)].rmse_over_bound;
                        return factor * normal_error(run, i, runs) / over;
                      }));
  };
  EXPECT_EQ(times_the_bound(1.0).verdict.efficient, true);
  // 1.35, and 1.96 / √400 of the figure that chance may have added.
  EXPECT_EQ(times_the_bound(1.48).verdict.efficient, true);
  EXPECT_EQ(times_the_bound(1.51).verdict.efficient, false);
  test::calm(plan);
  const MonteCarloSummary without =
      summary_of(plan, rows_with(plan, label, [](int run, Index i) { return normal_error(run, i, runs); }));
  EXPECT_EQ(without.verdict.efficient, std::nullopt);
}

TEST(MonteCarlo, FiguresAreThoseOfTheErrors) {
  MonteCarlo plan = scara_plan(4);
  constexpr std::array errors = {1.0, 2.0, 3.0, 6.0};  // in the deviations that the runs report
  const auto figures = [&] {
    return summary_of(plan, rows_with(plan, label,
                                      [&](int run, Index) { return errors[static_cast<std::size_t>(run)]; }))
        .parameters.front();
  };
  const MonteCarloParameter found = figures();
  const double spread = std::sqrt((4.0 + 1.0 + 0.0 + 9.0) / 3.0);
  constexpr double tolerance = 1e-9;  // values of order 1 whose errors are of order 0.01
  EXPECT_NEAR(found.bias, 0.03, tolerance);
  EXPECT_NEAR(found.rmse, 0.01 * std::sqrt(50.0 / 4.0), tolerance);
  EXPECT_NEAR(found.spread, 0.01 * spread, tolerance);
  EXPECT_NEAR(found.bias_in_spreads, 3.0 / spread, 1e2 * tolerance);
  EXPECT_NEAR(found.sigma_over_spread, 1.0 / spread, 1e2 * tolerance);
  // Noise of the torques beside their disturbance: the bound is that of both.
  ASSERT_TRUE(plan.experiment.simulation);
  NoiseOptions& noise = plan.experiment.simulation->noise;
  noise.torque = 2.0 * noise.disturbance;
  EXPECT_NEAR(found.rmse_over_bound / figures().rmse_over_bound, std::sqrt(5.0), 1e-6);
}

TEST(MonteCarlo, TheBoundDoesNotTakeRoundedPositionsForExcitation) {
  MonteCarlo plan = scara_plan(runs);
  const auto ratios = [&]() {
    std::vector<double> out;
    const MonteCarloSummary summary =
        summary_of(plan, rows_with(plan, label, [](int run, Index i) { return normal_error(run, i, runs); }));
    for (const MonteCarloParameter& p : summary.parameters) {
      out.push_back(p.rmse_over_bound);
    }
    return out;
  };
  const std::vector<double> exact = ratios();
  ASSERT_TRUE(plan.experiment.control);
  plan.experiment.control->sampling.quantum = Vector::Constant(plan.experiment.robot.size(), 1e-4);
  EXPECT_EQ(ratios(), exact);
}

TEST(MonteCarlo, RunsThatAreNotIdentifiedAreCountedByTheirReason) {
  const MonteCarlo plan = scara_plan(20);
  std::vector<MonteCarloRow> rows = rows_with(plan, label, [](int, Index) { return 0.5; });
  for (int run = 0; run < 5; ++run) {
    MonteCarloRow& row = rows[static_cast<std::size_t>(run)];
    row.status = run < 3 ? "cycling" : "refused";
    row.value.setConstant(std::nan(""));
  }
  const MonteCarloSummary summary = summary_of(plan, rows);
  EXPECT_EQ(summary.runs, 20);
  EXPECT_EQ(summary.identified, 15);
  EXPECT_EQ(summary.outcomes,
            (std::map<std::string, int>{{"cycling", 3}, {"identified", 15}, {"refused", 2}}));
  for (const MonteCarloParameter& p : summary.parameters) {
    EXPECT_NEAR(p.bias, 0.005, 1e-12);
  }
}

TEST(MonteCarlo, ATrialWithoutAnIdentifiedRunPromisesNothing) {
  const MonteCarlo plan = scara_plan(5);
  std::vector<MonteCarloRow> rows = rows_with(plan, label, [](int, Index) { return 0.0; });
  for (MonteCarloRow& row : rows) {
    row.status = "not_simulated";
  }
  const MonteCarloVerdict verdict = summary_of(plan, rows).verdict;
  EXPECT_FALSE(verdict.unbiased);
  EXPECT_FALSE(verdict.honest);
  EXPECT_EQ(verdict.efficient, std::nullopt);
}

TEST(MonteCarlo, APlanWithoutSimulationIsRefused) {
  MonteCarlo plan = scara_plan(2);
  plan.experiment.simulation.reset();
  EXPECT_THROW((void)monte_carlo_run(plan, 0), InputError);
  EXPECT_THROW((void)summaries(plan, {}), InputError);
}

TEST(MonteCarloRuns, AreMadeOnceEachAndAFailureReachesTheCaller) {
  MonteCarlo plan = scara_plan(6);
  plan.trials.resize(1);
  std::vector<int> wanted(6);
  std::iota(wanted.begin(), wanted.end(), 10);
  std::multiset<int> made;
  monte_carlo_runs(plan, wanted, 3,
                   [&](const std::vector<MonteCarloRow>& rows) { made.insert(rows.front().run); });
  EXPECT_EQ(made, std::multiset<int>(wanted.begin(), wanted.end()));
  int handed_over = 0;
  EXPECT_THROW(monte_carlo_runs(plan, wanted, 2,
                                [&](const std::vector<MonteCarloRow>&) {
                                  if (++handed_over == 2) {
                                    throw InputError("the disk is full");
                                  }
                                }),
               InputError);
  EXPECT_LT(handed_over, 6);
}

}  // namespace
}  // namespace rivid
