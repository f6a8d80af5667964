#include <algorithm>
#include <cmath>
#include <functional>

#include "paper_study/figures.hpp"
#include "paper_study/runs.hpp"
#include "paper_study/study.hpp"

namespace rivid::study {

namespace {

// What each log is identified by.
struct All {
  Runs ols;
  Runs good_start;
  Runs regular_start;
  Runs clean_rows;
  Runs raw_ols;
  Runs raw_iv;
  Runs half;
  Runs enough;
  Runs too_little;
};

All identified_all(const Scara& scara, std::uint64_t seeds) {
  // Beyond the paper: without the rows where a joint hardly moves, for a joint that sticks does not obey the model.
  SignalOptions moving = filtered();
  moving.velocity_threshold = {0.1, 0.1};
  All out;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Log s2 = scara.log(S2, seed);
    out.ols.push_back(identify(scara.robot, s2, {.method = Ols{}, .signal = filtered()}));
    Estimation from_ols = scara.iv(filtered());
    std::get<Iv>(from_ols.method).chi_0 = out.ols.back().chi;
    out.good_start.push_back(identify(scara.robot, s2, from_ols));
    out.regular_start.push_back(identify(scara.robot, s2, scara.iv(filtered())));
    // A torque that is held for a sample acts half a sample late.
    out.clean_rows.push_back(identify(scara.robot, shift_torque(s2, -0.5), scara.iv(moving)));
    out.raw_ols.push_back(identify(scara.robot, s2, {.method = Ols{}, .signal = raw()}));
    out.raw_iv.push_back(identify(scara.robot, s2, scara.iv(raw())));
    out.half.push_back(identify(scara.robot, s2, scara.iv(filtered(), 0.5)));
    const Log s1 = scara.log(S1, seed);
    out.enough.push_back(identify(scara.robot, s1, scara.iv(filtered(), 0.40)));
    out.too_little.push_back(identify(scara.robot, s1, scara.iv(filtered(), 0.28)));
  }
  return out;
}

std::string by_iteration(const Identification& found) {
  const auto& iterates = history(found).iterations;
  std::vector<std::size_t> widths = {11, 10, 8, 8, 8};
  widths.insert(widths.end(), iterates.size() - 1, 10);
  std::vector<std::vector<std::string>> rows = {{"parameter"}};
  for (std::size_t k = 0; k < table_4.size(); ++k) {
    rows[0].push_back((k == 0 ? "paper: " : "") + std::to_string(k));
  }
  for (std::size_t k = 0; k < iterates.size(); ++k) {
    rows[0].push_back((k == 0 ? "rivid: " : "") + std::to_string(k));
  }
  for (std::size_t i = 0; i < b; ++i) {
    auto& row = rows.emplace_back(std::vector<std::string>{names[i]});
    for (const auto& of_paper : table_4) {
      row.push_back(number(of_paper[i], 4));
    }
    for (const IvIteration& iterate : iterates) {
      row.push_back(number(in_paper[i] * iterate.chi[static_cast<Index>(i)], 4));
    }
  }
  return "\nTable 4, IDIM-IV, filtered, regular start, parameters by iteration (seed 1)\n\n" +
         table(widths, rows);
}

// How far two estimates of the same logs are apart, in standard deviations.
double largest_difference(const Runs& a, const Runs& c) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (identified(a[k]) && identified(c[k])) {
      for (std::size_t i = 0; i < b; ++i) {
        largest = std::max(largest, std::abs(value(a[k], i) - value(c[k], i)) / sigma(a[k], i));
      }
    }
  }
  return largest;
}

void check(const All& runs, Report& report) {
  const auto all = [](const Runs& of, const std::function<bool(const Identification&)>& holds) {
    return std::ranges::all_of(of, holds);
  };
  const auto inertias_within = [](double part) {
    return [part](const Identification& run) {
      return identified(run) && off(run, 0) < part && off(run, 3) < part;
    };
  };
  report.expect(all(runs.good_start, inertias_within(0.02)) && all(runs.regular_start, inertias_within(0.02)),
                "IV on filtered data finds the inertias within 2 % from either start");
  report.expect(all(runs.raw_iv, inertias_within(0.01)), "IV on raw data finds the inertias within 1 %");
  report.expect(all(runs.raw_ols, [](const Identification& run) { return off(run, 0) > 0.5; }),
                "least squares on raw data misses ZZ1R by more than half");
  bool same = true;
  for (std::size_t i = 0; i < runs.half.size(); ++i) {
    same = same && identified(runs.half[i]) &&
           std::abs(value(runs.half[i], 0) / value(runs.regular_start[i], 0) - 1.0) < 0.002;
  }
  report.expect(same, "half the bandwidth gives the same ZZ1R within 0.2 %");
  report.expect(all(runs.enough, identified), "on S1, 0.40 of the bandwidth is enough");
  report.expect(std::ranges::none_of(runs.too_little, identified), "on S1, 0.28 of the bandwidth is refused");
}

}  // namespace

void identification(const Scara& scara, std::uint64_t seeds, Report& report) {
  const All runs = identified_all(scara, seeds);
  report.print(beside("Table 1, IDIM-OLS, filtered", table_1, runs.ols));
  report.print(beside("Table 2, IDIM-IV, filtered, started from IDIM-OLS", table_2, runs.good_start));
  report.print(beside("Table 3, IDIM-IV, filtered, regular start", table_3, runs.regular_start));
  report.print("  Tables 2 and 3 are at most " +
               number(largest_difference(runs.good_start, runs.regular_start), 2) + " σ apart in any log.\n");
  report.print(
      beside("As Table 3, without slow rows, torques moved by half a sample", table_3, runs.clean_rows));
  report.print(by_iteration(runs.regular_start.front()));
  report.print(motion_errors("Figs 8 and 9", runs.regular_start));
  report.print(beside("Table 5, IDIM-OLS, nothing filtered", table_5, runs.raw_ols));
  report.print(beside("Table 6, IDIM-IV, nothing filtered, regular start", table_6, runs.raw_iv));
  report.print(beside("Table 7, IDIM-IV, filtered, regular start, half the bandwidth", table_7, runs.half));
  report.print(motion_errors("Figs 12 and 13", runs.half));
  report.print(outcomes("Section 4.5, S1, 0.40 of the bandwidth", runs.enough));
  report.print(outcomes("Section 4.5, S1, 0.28 of the bandwidth", runs.too_little));

  const Log first = scara.log(S2, 1);
  figure_torques(scara, first, runs.good_start.front(), report);
  figure_motion_errors(8, "regular start", runs.regular_start.front(), report);
  figure_parameters(runs.regular_start.front(), report);
  figure_torque_errors(scara, first, runs.regular_start.front(), report);
  figure_motion_errors(12, "half the bandwidth", runs.half.front(), report);
  check(runs, report);
}

}  // namespace rivid::study
