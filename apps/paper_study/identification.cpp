#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "joined.hpp"
#include "paper_study/study.hpp"
#include "rivid/text.hpp"

namespace rivid::study {

namespace {

// IDIM-IV by rivid's defaults, and by the paper's procedure of section 3.4.
struct Both {
  Runs ours;
  Runs papers;

  [[nodiscard]] std::vector<Procedure> procedures() const {
    return {{"all samples", ours}, {"section 3.4", papers}};
  }
};

// What each log is identified by.
struct All {
  Both ols;  // the second without the samples that section 3.4 drops
  Both good_start;
  Both regular_start;
  Runs clean_rows;
  Both raw_iv;
  Runs raw_iv_classical;
  Runs raw_ols;
  Both half;
  Runs enough;
  Runs too_little;
};

void add(Runs& to, const Scara& scara, const Log& log, Estimation estimation, const Vector& start = {}) {
  if (start.size() > 0) {
    std::get<Iv>(estimation.method).chi_0 = start;
  }
  estimation.essential = Essential{};
  to.push_back(identify(scara.robot, log, estimation));
}

void add(Both& to, const Scara& scara, const Log& log, const SignalOptions& signal, double bandwidth = 1.0,
         const Vector& start = {}) {
  add(to.ours, scara, log, scara.iv(signal, bandwidth), start);
  add(to.papers, scara, log, scara.iv_of_section_3_4(signal, bandwidth), start);
}

All identified_all(const Scara& scara, std::uint64_t seeds) {
  // Beyond the paper: without the rows where a joint hardly moves, for a joint that sticks does not obey the
  // model.
  SignalOptions moving = filtered();
  moving.velocity_threshold = {0.1, 0.1};
  Estimation classical = scara.iv(raw());
  classical.covariance.kind = CovarianceKind::classical;
  All out;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Log s2 = scara.log(S2, seed);
    add(out.ols.ours, scara, s2, ols(filtered()));
    add(out.ols.papers, scara, s2, ols(scara.without_transient(filtered())));
    add(out.good_start, scara, s2, filtered(), 1.0, out.ols.ours.back().chi);
    add(out.regular_start, scara, s2, filtered());
    // A torque that is held for a sample acts half a sample late.
    out.clean_rows.push_back(identify(scara.robot, shift_torque(s2, -0.5), scara.iv(moving)));
    out.raw_ols.push_back(identify(scara.robot, s2, ols(raw())));
    add(out.raw_iv, scara, s2, raw());
    out.raw_iv_classical.push_back(identify(scara.robot, s2, classical));
    add(out.half, scara, s2, filtered(), 0.5);
    const Log s1 = scara.log(S1, seed);
    out.enough.push_back(identify(scara.robot, s1, scara.iv(filtered(), 0.40)));
    out.too_little.push_back(identify(scara.robot, s1, scara.iv(filtered(), 0.28)));
  }
  return out;
}

std::string by_iteration(const Identification& found) {
  Table rows = {{"parameter"}};
  const auto& iterates = found.iv->iterations;
  for (std::size_t k = 0; k < paper_iterates().size(); ++k) {
    rows[0].push_back((k == 0 ? "paper: " : "") + std::to_string(k));
  }
  for (std::size_t k = 0; k < iterates.size(); ++k) {
    rows[0].push_back((k == 0 ? "rivid: " : "") + std::to_string(k));
  }
  for (std::size_t i = 0; i < b; ++i) {
    auto& row = rows.emplace_back(std::vector<std::string>{names[i]});
    for (const auto& of_paper : paper_iterates()) {
      row.push_back(number(of_paper[i], 4));
    }
    for (const IvIteration& iterate : iterates) {
      row.push_back(number(in_paper[i] * iterate.chi[static_cast<Index>(i)], 4));
    }
  }
  return "\nTable 4, IDIM-IV by section 3.4, filtered, regular start, parameters by iteration (seed 1)\n\n" +
         aligned(rows);
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

// Which parameters the estimates of the logs can do without, and what that costs.
std::vector<std::string> essential_row(const std::string& method, const Runs& all) {
  const Runs runs = only_identified(all);
  std::map<std::string, int> eliminated;
  for (const Identification& run : runs) {
    for (const EliminatedParameter& parameter : run.essential.value().parameters.eliminated) {
      ++eliminated[parameter.name];
    }
  }
  const std::string list = detail::joined(
      eliminated, ", ", [](const auto& of) { return of.first + " in " + std::to_string(of.second); });
  return {method, list.empty() ? "none" : list,
          percent(mean(runs, [](const Identification& run) { return run.fit.relative_error; })),
          percent(mean(runs, [](const Identification& run) { return run.essential->fit.relative_error; }))};
}

// ‖Y − Wχ̂‖ / ‖Y‖ of least squares on the rows of Table 1, of both joints and of the second, without some
// columns of W.
std::array<double, 2> error_without(const std::vector<Index>& columns, const Scara& scara, const Log& log) {
  const Rows rows = rivid::rows(scara.robot, scara.base, log, filtered());
  Matrix W = rows.W.dense();
  Vector Y(W.rows());
  Y << rows.Y[0], rows.Y[1];
  for (const Index column : columns) {
    W.col(column).setZero();
  }
  const Vector error = Y - W * W.completeOrthogonalDecomposition().solve(Y);
  const Index second = rows.Y[1].size();
  return {error.norm() / Y.norm(), error.tail(second).norm() / Y.tail(second).norm()};
}

std::string essential_parameters(const All& runs) {
  const Table rows = {{"", "eliminated", "‖Y − Wχ‖ / ‖Y‖ of all", "of those that are left"},
                      essential_row("IDIM-OLS, all samples", runs.ols.ours),
                      essential_row("IDIM-OLS, section 3.4", runs.ols.papers),
                      essential_row("IDIM-IV, all samples", runs.regular_start.ours),
                      essential_row("IDIM-IV, section 3.4", runs.regular_start.papers)};
  return "\nSection 4.2, essential parameters, filtered, by number of logs\n\n" + aligned(rows);
}

std::string cost_of_cancelling(const Scara& scara, std::uint64_t seeds) {
  const std::array<std::pair<const char*, std::vector<Index>>, 4> cancelled = {
      {{"nothing", {}}, {"Fv1", {1}}, {"Fv2", {6}}, {"Fv1 and Fv2", {1, 6}}}};
  Table rows = {{"cancelled", "‖Y − Wχ‖ / ‖Y‖", "joint 2"}};
  for (const auto& [what, columns] : cancelled) {
    std::array<double, 2> sum = {0.0, 0.0};
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const auto error = error_without(columns, scara, scara.log(S2, seed));
      sum = {sum[0] + error[0], sum[1] + error[1]};
    }
    const auto count = static_cast<double>(seeds);
    rows.push_back({what, percent(sum[0] / count), percent(sum[1] / count)});
  }
  return "\nSection 4.2, IDIM-OLS on the rows of Table 1, all samples, without some parameters\n\n" +
         aligned(rows);
}

// How the runs ended, and for each way the reasons of the first run that ended so.
std::string outcomes(const std::string& title, const Runs& runs) {
  std::string out = "\n" + title + '\n';
  std::vector<Status> seen;
  for (const Identification& run : runs) {
    if (std::ranges::count(seen, run.status) > 0) {
      continue;
    }
    seen.push_back(run.status);
    out += "  " + std::string(name(run.status)) + ": " +
           std::to_string(std::ranges::count(runs, run.status, &Identification::status)) + " of " +
           std::to_string(runs.size());
    if (identified(run)) {
      const auto inertia = [](const Identification& found) { return value(found, 0); };
      const Runs good = only_identified(runs);
      const auto [least, most] = std::ranges::minmax(good, {}, inertia);
      out += ", ZZ1R from " + number(inertia(least), 4) + " to " + number(inertia(most), 4) + " kg·m²";
    }
    out += '\n';
    for (const std::string& reason : run.reasons) {
      out += "    " + reason + '\n';
    }
  }
  return out;
}

// Errors of the simulated motion of the last iteration, as figs 8, 9, 12 and 13 end.
std::string motion_errors(const std::string& title, const Runs& all) {
  const Runs runs = only_identified(all);
  const auto errors = [&](MotionError IvIteration::* from, Index j) {
    std::string out;
    for (const auto quantity : {&MotionError::q, &MotionError::qd, &MotionError::qdd}) {
      const double error = mean(
          runs, [&](const Identification& run) { return (run.iv->iterations.back().*from.*quantity)[j]; });
      out += (out.empty() ? "" : ", ") + number(100.0 * error, 3);
    }
    return out + " %";
  };
  // Section 4.3 has one number for both joints, and 4.5 says "close to" the same.
  Table rows = {{"", "against measured", "against reference"}, {"paper", "0.5, 5, 10 %", "1.5, 15, 30 %"}};
  for (Index j = 0; j < 2; ++j) {
    rows.push_back({"joint " + std::to_string(j + 1), errors(&IvIteration::to_measured, j),
                    errors(&IvIteration::to_reference, j)});
  }
  return "\n" + title + ", relative errors of q, q̇, q̈ of the simulated motion, all samples\n\n" +
         aligned(rows);
}

std::string joint(Index j) { return "joint " + std::to_string(j + 1); }

// One number an iteration.
detail::Series by_iteration(const std::string& label, const Identification& found,
                            const std::function<double(const IvIteration&)>& of, std::size_t color) {
  const auto& iterations = found.iv->iterations;
  const auto count = static_cast<Index>(iterations.size());
  detail::Series out =
      curve(label, color, Vector::LinSpaced(count, 0.0, static_cast<double>(count - 1)), Vector(count));
  std::ranges::transform(iterations, out.y.begin(), of);
  return out;
}

// Fig. 7: torques measured, and those of the model along the simulated motion.
void figure_torques(const Scara& scara, const Log& log, const Identification& found, Report& report) {
  const Simulation run =
      simulate(scara.robot, scara.base, found.chi, scara.control, found.iv->iterations.back().J,
               Scara::moves(S2), {.f_m = Scara::f_m, .sampling = scara.sampling});
  const Vector Y_e = observation(scara.robot, scara.base, run.motion).dense() * found.chi;
  std::vector<detail::Chart> charts;
  for (Index j = 0; j < 2; ++j) {
    const Vector predicted = Y_e.segment(j * run.t.size(), run.t.size());
    charts.push_back(
        {.title = joint(j),
         .x_label = "t [s]",
         .y_label = "τ [N·m]",
         .series = {curve("measured", 7, log.t, log.v_tau.col(j)), curve("predicted", 1, log.t, predicted),
                    curve("measured − predicted", 0, log.t, log.v_tau.col(j) - predicted)},
         .size = detail::Chart::Size::wide});
  }
  report.figure("Fig. 7: torques measured at 200 Hz and predicted along the simulated motion",
                std::move(charts));
}

// Figs 8 and 9, or 12 and 13, one a joint: distance of the simulated motion from the filtered measured one
// and from the reference.
void figure_motion_errors(const std::string& figures, const Identification& found, Report& report) {
  std::vector<detail::Chart> charts;
  for (Index j = 0; j < 2; ++j) {
    auto& chart = charts.emplace_back(detail::Chart{
        .title = joint(j), .x_label = "iteration", .y_label = "relative error [%]", .logarithmic = true});
    for (const auto& [against, from] : {std::pair(" against measured", &IvIteration::to_measured),
                                        std::pair(" against reference", &IvIteration::to_reference)}) {
      for (const auto& [symbol, member] : {std::pair("q", &MotionError::q), std::pair("q̇", &MotionError::qd),
                                           std::pair("q̈", &MotionError::qdd)}) {
        chart.series.push_back(by_iteration(
            std::string(symbol) + against, found,
            [&](const IvIteration& k) { return 100.0 * (k.*from.*member)[j]; }, chart.series.size()));
      }
    }
  }
  report.figure(figures + ": simulated motion, relative errors", std::move(charts));
}

// Fig. 10.
void figure_parameters(const Identification& found, Report& report) {
  std::vector<detail::Chart> charts;
  for (std::size_t i = 0; i < b; ++i) {
    const auto estimate = [i](const IvIteration& k) { return in_paper[i] * k.chi[static_cast<Index>(i)]; };
    charts.push_back({.title = names[i],
                      .x_label = "iteration",
                      .y_label = std::string(names[i]) + " [" + units[i] + "]",
                      .series = {by_iteration(
                                     "truth", found, [i](const IvIteration&) { return truth(i); }, 1),
                                 by_iteration("estimate", found, estimate, 0)}});
  }
  report.figure("Fig. 10: parameters by iteration, regular start", std::move(charts));
}

// Fig. 11; beside the error against W that of the stop rule, against the simulated V.
void figure_torque_errors(const Scara& scara, const Log& log, const Identification& found, Report& report) {
  const Rows rows = rivid::rows(scara.robot, scara.base, log, found.estimation.signal);
  std::vector<detail::Chart> charts;
  for (Index j = 0; j < 2; ++j) {
    const JointRows& W = rows.W.joints[static_cast<std::size_t>(j)];
    const Vector& Y = rows.Y[static_cast<std::size_t>(j)];
    const auto measured = [&](const IvIteration& k) {
      return 100.0 * (Y - W.W * k.chi(W.columns)).norm() / Y.norm();
    };
    const auto simulated = [&](const IvIteration& k) { return 100.0 * k.joint_error_norm[j] / Y.norm(); };
    charts.push_back({.title = joint(j),
                      .x_label = "iteration",
                      .y_label = "relative torque error [%]",
                      .series = {by_iteration("‖Y − Wχ‖ / ‖Y‖", found, measured, 0),
                                 by_iteration("‖Y − Vχ‖ / ‖Y‖", found, simulated, 1)},
                      .logarithmic = true});
  }
  report.figure("Fig. 11: torque error by iteration, regular start", std::move(charts));
}

void check(const All& runs, Report& report) {
  const auto inertias_within = [](double part) {
    return [part](const Identification& run) {
      return identified(run) && off(run, 0) < part && off(run, 3) < part;
    };
  };
  for (const auto& [name, of] : runs.good_start.procedures()) {
    report.expect(all(of, inertias_within(0.02)),
                  "IV on filtered data finds the inertias within 2 % from least squares, " + name);
  }
  for (const auto& [name, of] : runs.regular_start.procedures()) {
    report.expect(all(of, inertias_within(0.02)),
                  "IV on filtered data finds the inertias within 2 % from the regular start, " + name);
  }
  for (const auto& [name, of] : runs.raw_iv.procedures()) {
    report.expect(all(of, inertias_within(0.01)), "IV on raw data finds the inertias within 1 %, " + name);
  }
  report.expect(all(runs.raw_ols, [](const Identification& run) { return off(run, 0) > 0.5; }),
                "least squares on raw data misses ZZ1R by more than half");
  const Both& regular = runs.regular_start;
  for (std::size_t k = 0; k < runs.half.ours.size(); ++k) {
    report.expect(identified(runs.half.ours[k]) &&
                      std::abs(value(runs.half.ours[k], 0) / value(regular.ours[k], 0) - 1.0) < 0.002,
                  "half the bandwidth gives the same ZZ1R within 0.2 %");
    report.expect(regular.papers[k].fit.relative_error < regular.ours[k].fit.relative_error,
                  "without the samples that section 3.4 drops the relative error is smaller");
  }
  report.expect(all(runs.enough, identified), "on S1, 0.40 of the bandwidth is enough");
  report.expect(std::ranges::none_of(runs.too_little, identified), "on S1, 0.28 of the bandwidth is refused");
}

}  // namespace

void identification(const Scara& scara, std::uint64_t seeds, Report& report) {
  const All runs = identified_all(scara, seeds);
  const Both& regular = runs.regular_start;
  report.print(beside("Table 1, IDIM-OLS, filtered", paper_table(1), runs.ols.procedures()));
  report.print(beside("Table 2, IDIM-IV, filtered, started from IDIM-OLS", paper_table(2),
                      runs.good_start.procedures()));
  report.print(beside("Table 3, IDIM-IV, filtered, regular start", paper_table(3), regular.procedures()));
  report.print("  Tables 2 and 3 are at most " +
               number(std::max(largest_difference(runs.good_start.ours, regular.ours),
                               largest_difference(runs.good_start.papers, regular.papers)),
                      2) +
               " σ apart in any log.\n");
  report.print(beside("As Table 3, without slow rows, torques moved by half a sample", paper_table(3),
                      {{"clean rows", runs.clean_rows}}));
  report.print(essential_parameters(runs));
  report.print(cost_of_cancelling(scara, seeds));
  report.print(by_iteration(regular.papers.front()));
  report.print(motion_errors("Figs 8 and 9", regular.ours));
  report.print(
      beside("Table 5, IDIM-OLS, nothing filtered", paper_table(5), {{"all samples", runs.raw_ols}}));
  report.print(
      beside("Table 6, IDIM-IV, nothing filtered, regular start", paper_table(6), runs.raw_iv.procedures()));
  report.print("  σ of ZZ1R by the classical formula: " +
               number(mean(runs.raw_iv_classical, [](const auto& run) { return sigma(run, 0); }), 2) + '\n');
  report.print(beside("Table 7, IDIM-IV, filtered, regular start, half the bandwidth", paper_table(7),
                      {{"all samples", runs.half.ours}}));
  report.print(outcomes("The same by section 3.4, which drops 10 of 20 s", runs.half.papers));
  report.print(motion_errors("Figs 12 and 13", runs.half.ours));
  report.print(outcomes("Section 4.5, S1, 0.40 of the bandwidth", runs.enough));
  report.print(outcomes("Section 4.5, S1, 0.28 of the bandwidth", runs.too_little));

  const Log first = scara.log(S2, 1);
  figure_torques(scara, first, runs.good_start.ours.front(), report);
  figure_motion_errors("Figs 8 and 9, regular start", regular.ours.front(), report);
  figure_parameters(regular.ours.front(), report);
  figure_torque_errors(scara, first, regular.ours.front(), report);
  figure_motion_errors("Figs 12 and 13, half the bandwidth", runs.half.ours.front(), report);
  check(runs, report);
}

}  // namespace rivid::study
