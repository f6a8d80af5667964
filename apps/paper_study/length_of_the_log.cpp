#include <algorithm>
#include <array>
#include <cmath>

#include "paper_study/runs.hpp"
#include "paper_study/study.hpp"

namespace rivid::study {

namespace {

constexpr std::array<double, 6> lengths = {5.0, 10.0, 20.0, 40.0, 80.0, 160.0};  // s

Log beginning(const Log& log, double length) {
  const auto rows = static_cast<Index>(std::lround(length * log.f_m)) + 1;
  Log out = log;
  out.t = log.t.head(rows);
  out.q = log.q.topRows(rows);
  out.v_tau = log.v_tau.topRows(rows);
  out.q_r = log.q_r.topRows(rows);
  return out;
}

// Root mean square of the relative errors of ZZ1R, ZZ2 and LMX2.
double inertia_error(const Runs& runs) {
  return std::sqrt(
      (std::pow(rms_off(runs, 0), 2) + std::pow(rms_off(runs, 3), 2) + std::pow(rms_off(runs, 4), 2)) / 3.0);
}

struct Method {
  std::string name;
  bool iv;
  SignalOptions signal;
  std::vector<double> errors = {};
};

}  // namespace

void length_of_the_log(const Scara& scara, std::uint64_t seeds, Report& report) {
  const PointToPointReference reference = Scara::moves(S2, 8);
  std::vector<Log> logs;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    logs.push_back(scara.log(reference, seed, {}));
  }
  std::vector<Method> methods = {{"OLS, filtered", false, filtered()},
                                 {"OLS, not filtered", false, raw()},
                                 {"IV, filtered", true, filtered()},
                                 {"IV, not filtered", true, raw()}};
  std::vector<std::vector<std::string>> rows = {{"length"}};
  for (const Method& method : methods) {
    rows[0].push_back(method.name);
  }
  for (const double length : lengths) {
    auto& row = rows.emplace_back(std::vector<std::string>{number(length) + " s"});
    for (Method& method : methods) {
      Runs runs;
      for (const Log& whole : logs) {
        const Log log = beginning(whole, length);
        runs.push_back(method.iv ? identify(scara.robot, log, scara.iv(method.signal))
                                 : identify(scara.robot, log, {.method = Ols{}, .signal = method.signal}));
      }
      const Runs good = only_identified(runs);
      method.errors.push_back(good.empty() ? std::nan("") : inertia_error(good));
      row.push_back(percent(method.errors.back()) +
                    (good.size() == runs.size()
                         ? ""
                         : " (" + std::to_string(good.size()) + " of " + std::to_string(runs.size()) + ")"));
    }
  }
  report.print(
      "\nEqs. (24–33), root mean square of the relative errors of ZZ1R, ZZ2 and LMX2 by the length of the "
      "log\n\n" +
      table({9, 18, 20, 18}, rows));

  svg::Panel panel;
  panel.title = "ZZ1R, ZZ2 and LMX2, root mean square";
  panel.x = {.label = "length of the log [s]", .logarithmic = true};
  panel.y = {.label = "relative error [%]", .logarithmic = true};
  for (std::size_t m = 0; m < methods.size(); ++m) {
    svg::Series& series = panel.series.emplace_back();
    series.label = methods[m].name;
    series.markers = true;
    series.dashed = m % 2 == 0;
    series.color = m < 2 ? 1 : 0;
    for (std::size_t k = 0; k < lengths.size(); ++k) {
      series.x.push_back(lengths[k]);
      series.y.push_back(100.0 * methods[m].errors[k]);
    }
  }
  report.figure("length_of_the_log.svg", "Eqs. (24–33): the error by the length of the log", {panel}, 1,
                620.0, 380.0);
  report.expect(methods[1].errors.back() > 0.3,
                "least squares on raw data stays wrong, however long the log");
  report.expect(methods[3].errors.back() < 0.5 * methods[3].errors.front(),
                "IV on raw data gets better with the length of the log");
}

}  // namespace rivid::study
