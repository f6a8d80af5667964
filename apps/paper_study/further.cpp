#include <algorithm>
#include <array>
#include <cmath>

#include "paper_study/study.hpp"
#include "rivid/text.hpp"

namespace rivid::study {

void misprints(Report& report) {
  // What rounding of the printed digits could explain in most places.
  constexpr double rounding = 1.4;
  Table rows = {{"paper", "parameter", "printed", "from the other"}};
  for (const int table : {1, 2, 3, 5, 6, 7}) {
    const PaperTable& paper = paper_table(table);
    for (std::size_t i = 0; i < b; ++i) {
      const double from_two_sigma = 50.0 * paper.two_sigma[i] / paper.chi[i];
      if (std::abs(std::log(paper.percent_sigma[i] / from_two_sigma)) > std::log(rounding)) {
        rows.push_back({"Table " + std::to_string(table) + ", %σ from 2 σ", names[i],
                        number(paper.percent_sigma[i]) + " %", number(from_two_sigma, 3) + " %"});
      }
    }
  }
  for (std::size_t i = 0; i < b; ++i) {
    const double last = paper_iterates().back()[i];
    if (last != paper_table(3).chi[i]) {
      rows.push_back(
          {"Table 4, its last χ from Table 3", names[i], number(last), number(paper_table(3).chi[i])});
    }
  }
  report.print("\nTables of the paper that disagree\n\n" + aligned(rows));
  report.expect(rows.size() == 1 + 5 + 5, "five σ of the paper disagree, and five parameters of its Table 4");
}

void reference_regressor(const Scara& scara, std::uint64_t seeds, Report& report) {
  const Runs runs = over(seeds, [&](std::uint64_t seed) {
    Log log = scara.log(S2, seed);
    log.q = log.q_r;
    return identify(scara.robot, log, ols(filtered()));
  });
  report.print(beside("Section 4.3, IDIM-OLS, filtered, W from the reference trajectory (paper: Table 1)",
                      paper_table(1), {{"all samples", runs}}));
  report.expect(all(runs, [](const Identification& run) { return off(run, 0) > 0.5; }),
                "W from the reference trajectory misses ZZ1R by more than half");
}

void raw_least_squares(const Scara& scara, std::uint64_t seeds, Report& report) {
  constexpr std::size_t LMX2 = 4;  // its place in names
  const std::array<std::pair<std::string, PointToPointReference>, 5> motions = {
      {{"S1", Scara::moves(S1)},
       {"S2", Scara::moves(S2)},
       {"S2, moves of 1.5 s", Scara::moves(S2, 1, 1.5)},
       {"S2, moves of 5 s", Scara::moves(S2, 1, 5.0)},
       {"other points", Scara::unused_moves()}}};
  constexpr std::array<double, 4> noises = {0.1, 0.3, 1.0, 3.0};
  Table rows = {{"LMX2 over truth", "noise × 0.1", "× 0.3", "× 1", "× 3"}};
  double largest = 0.0;
  for (const auto& [name, motion] : motions) {
    auto& row = rows.emplace_back(std::vector<std::string>{name});
    for (const double noise : noises) {
      const Runs runs = over(seeds, [&](std::uint64_t seed) {
        return identify(scara.robot, scara.log(motion, seed, {.noise = noise}), ols(raw()));
      });
      row.push_back(number(mean_ratio(runs, LMX2), 3));
      for (const Identification& run : runs) {
        largest = std::max(largest, value(run, LMX2) / truth(LMX2));
      }
    }
  }
  report.print("\nSection 4.4, IDIM-OLS, nothing filtered, over noise and trajectories\n\n" + aligned(rows) +
               "  largest in any log: " + number(largest, 3) +
               "; paper: " + number(paper_table(5).chi[LMX2] / truth(LMX2), 3) + '\n');
  report.expect(largest < 1.05,
                "noise makes the LMX2 of least squares on raw data too small, never too large");
}

namespace {

// "1.001" for ZZ1R, ZZ2, LMX2 and Fc1.
void add_ratios(std::vector<std::string>& row, const Runs& runs, double scale = 1.0) {
  for (const std::size_t i : shown) {
    row.push_back(runs.empty() ? "–" : number(mean_ratio(runs, i) / scale, 4));
  }
}

// poles: of the loop that was recorded, in units of those that the simulation takes.
std::vector<std::string> design_row(const std::string& what, double ratio, double poles, double scale,
                                    const Runs& runs) {
  const Runs good = only_identified(runs);
  std::vector<std::string> out = {what, number(ratio, 3), number(poles, 3)};
  add_ratios(out, good, scale);
  out.push_back(good.empty() ? "–" : percent(mean(good, error_of_instruments)));
  out.push_back(how_many(runs));
  return out;
}

}  // namespace

void wrong_design(const Scara& scara, std::uint64_t seeds, Report& report) {
  // Of a-priori and true value; (47) takes the root of it, which the paper expects between 0.8 and 1.2.
  constexpr std::array<double, 5> ratios = {0.5, 0.64, 1.0, 1.44, 2.0};
  Table rows = {{"wrong", "ratio", "poles (47)", "ZZ1R", "ZZ2", "LMX2", "Fc1", "‖Y − Vχ‖", ""}};
  for (const double ratio : ratios) {
    // The controller was designed with the wrong inertias, so its poles are not those that the simulation
    // takes.
    const Runs runs = over(seeds, [&](std::uint64_t seed) {
      return identify(scara.robot, scara.log(Scara::moves(S2), seed, {.J_ratio = {ratio, ratio}}),
                      scara.iv(filtered()));
    });
    rows.push_back(design_row("inertia", ratio, std::sqrt(ratio), 1.0, runs));
    report.expect(
        std::abs(std::sqrt(ratio) - 1.0) > 0.21 ||
            all(runs, [](const Identification& run) { return identified(run) && off(run, 0) < 0.02; }),
        "poles that are 0.8 to 1.2 times what is assumed leave ZZ1R within 2 %");
  }
  for (const double ratio : ratios) {
    Robot believed = scara.robot;
    for (Joint& joint : believed.joints) {
      joint.drive_gain = ratio;
    }
    const Runs runs = over(seeds, [&](std::uint64_t seed) {
      return identify(believed, scara.log(S2, seed), scara.iv(filtered()));
    });
    // A wrong drive gain scales the inertias of the simulation with it, and its poles stay.
    rows.push_back(design_row("drive gain", ratio, 1.0, ratio, runs));
    report.expect(all(runs,
                      [ratio](const Identification& run) {
                        return std::abs(value(run, 0) / (ratio * truth(0)) - 1.0) < 0.02;
                      }),
                  "a wrong drive gain scales ZZ1R by itself");
  }
  report.print(
      "\nEq. (47), IDIM-IV, filtered, a-priori inertia of the controller's design or drive gain wrong;\n"
      "estimate over truth, or over truth times the ratio of the drive gain\n\n" +
      aligned(rows));
}

namespace {

// Of the Butterworth filter [Hz]; 0 is none. Nothing is decimated: the filter alone keeps noise away.
constexpr std::array<double, 11> cutoffs = {0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 40.0, 80.0, 0.0};

// Mean of χ̂ / χ over the cut-off; what is not filtered at all stands at half of the measuring rate.
detail::Series ratio_curve(const std::string& label, const std::vector<Runs>& by_cutoff, std::size_t i,
                           std::size_t color) {
  constexpr auto count = static_cast<Index>(cutoffs.size());
  detail::Series out = curve(label, color, Vector(count), Vector(count));
  for (std::size_t c = 0; c < cutoffs.size(); ++c) {
    out.x[static_cast<Index>(c)] = cutoffs[c] > 0.0 ? cutoffs[c] : 0.5 * Scara::f_m;
    out.y[static_cast<Index>(c)] = mean_ratio(by_cutoff[c], i);
  }
  return out;
}

}  // namespace

void cutoff(const Scara& scara, std::uint64_t seeds, Report& report) {
  std::vector<Runs> by_ols(cutoffs.size());
  std::vector<Runs> by_iv(cutoffs.size());
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Log log = scara.log(S2, seed);
    for (std::size_t c = 0; c < cutoffs.size(); ++c) {
      const SignalOptions signal = {.rows = RowScheme::paper, .cutoff_hz = cutoffs[c]};
      by_ols[c].push_back(identify(scara.robot, log, ols(signal)));
      by_iv[c].push_back(identify(scara.robot, log, scara.iv(signal)));
    }
  }
  Table rows = {
      {"cut-off", "cond W", "ols: ZZ1R", "ZZ2", "LMX2", "Fc1", "iv: ZZ1R", "ZZ2", "LMX2", "Fc1", ""}};
  for (std::size_t c = 0; c < cutoffs.size(); ++c) {
    auto& row = rows.emplace_back();
    row.push_back(cutoffs[c] > 0.0 ? number(cutoffs[c], 3) + " Hz" : "none");
    row.push_back(number(mean(by_ols[c], [](const Identification& run) { return run.condition; }), 3));
    add_ratios(row, by_ols[c]);
    const std::string count = how_many(by_iv[c]);
    by_iv[c] = only_identified(by_iv[c]);
    add_ratios(row, by_iv[c]);
    row.push_back(count);
    report.expect((cutoffs[c] > 0.0 && cutoffs[c] < 8.0) ||
                      (by_iv[c].size() == seeds && all(by_iv[c],
                                                       [](const Identification& run) {
                                                         return off(run, 0) < 0.02 && off(run, 3) < 0.02;
                                                       })),
                  "from 8 Hz on, and without a filter, IV finds the inertias within 2 %");
    report.expect(
        cutoffs[c] != 80.0 || all(by_ols[c], [](const Identification& run) { return off(run, 0) > 0.1; }),
        "with a cut-off of 80 Hz least squares misses ZZ1R by more than a tenth");
  }
  report.print("\nSection 5, estimate over truth by the cut-off of the filter, nothing decimated\n\n" +
               aligned(rows));

  std::vector<detail::Chart> charts;
  for (const std::size_t i : shown) {
    charts.push_back({.title = names[i],
                      .x_label = "cut-off [Hz], the last without a filter",
                      .y_label = "estimate / truth",
                      .series = {ratio_curve("IDIM-OLS", by_ols, i, 1), ratio_curve("IDIM-IV", by_iv, i, 0)},
                      .x_logarithmic = true});
  }
  report.figure("Section 5: estimates by the cut-off of the filter", std::move(charts));
}

namespace {

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
  return std::sqrt(mean(runs, [](const Identification& run) {
    return (std::pow(off(run, 0), 2) + std::pow(off(run, 3), 2) + std::pow(off(run, 4), 2)) / 3.0;
  }));
}

}  // namespace

void length_of_the_log(const Scara& scara, std::uint64_t seeds, Report& report) {
  constexpr std::array<double, 6> lengths = {5.0, 10.0, 20.0, 40.0, 80.0, 160.0};  // s
  constexpr std::array<const char*, 4> methods = {"OLS, filtered", "OLS, not filtered", "IV, filtered",
                                                  "IV, not filtered"};
  const PointToPointReference reference = Scara::moves(S2, 8);
  std::vector<Log> logs;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    logs.push_back(scara.log(reference, seed, {}));
  }
  Table rows = {{"length", methods[0], methods[1], methods[2], methods[3]}};
  constexpr auto count = static_cast<Index>(lengths.size());
  detail::Chart chart{.title = "ZZ1R, ZZ2 and LMX2, root mean square",
                      .x_label = "length of the log [s]",
                      .y_label = "relative error [%]",
                      .logarithmic = true,
                      .x_logarithmic = true};
  for (std::size_t m = 0; m < methods.size(); ++m) {
    chart.series.push_back(
        curve(methods[m], m, Eigen::Map<const Vector>(lengths.data(), count), Vector(count)));
  }
  for (Index l = 0; l < count; ++l) {
    const double length = lengths[static_cast<std::size_t>(l)];
    auto& row = rows.emplace_back(std::vector<std::string>{number(length) + " s"});
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const SignalOptions signal = m % 2 == 0 ? filtered() : raw();
      const Runs runs = over(seeds, [&](std::uint64_t seed) {
        const Log log = beginning(logs[seed - 1], length);
        return m < 2 ? identify(scara.robot, log, ols(signal)) : identify(scara.robot, log, scara.iv(signal));
      });
      const Runs good = only_identified(runs);
      const double error = inertia_error(good);
      chart.series[m].y[l] = 100.0 * error;
      row.push_back(percent(error) + (good.size() == runs.size() ? "" : " (" + how_many(runs) + ")"));
    }
  }
  report.print(
      "\nEqs. (24–33), root mean square of the relative errors of ZZ1R, ZZ2 and LMX2 by the length of the "
      "log\n\n" +
      aligned(rows));
  report.expect(chart.series[1].y[count - 1] > 30.0,
                "least squares on raw data stays wrong, however long the log");
  report.expect(chart.series[3].y[count - 1] < 0.5 * chart.series[3].y[0],
                "IV on raw data gets better with the length of the log");
  report.figure("Eqs. (24–33): the error by the length of the log", {std::move(chart)});
}

namespace {

// No feedback: what moves the robot is added to this.
class Silent final : public ControlLaw {
 public:
  void control(const ControlInput& /*input*/, const Eigen::Ref<const Vector>& /*x*/, Eigen::Ref<Vector> v_tau,
               Eigen::Ref<Vector> /*xd*/) const override {
    v_tau.setZero();
  }
};

Motion replayed(const Scara& scara, const Vector& chi, const PointToPointReference& reference,
                const Log& log) {
  const DynamicModel model(scara.robot, scara.base, chi);
  SimulationOptions options{.f_m = Scara::f_m, .samples = log.samples(), .sampling = scara.sampling};
  options.added_control = log.v_tau;
  return simulate(scara.robot, model, Silent{}, reference, options).motion;
}

struct Model {
  std::string name;
  Vector chi;
};

std::vector<Model> models(const Scara& scara, const Log& log) {
  const auto by = [&](const auto& method) { return identify(scara.robot, log, method).chi; };
  return {{"the true parameters", scara.chi},
          {"IDIM-OLS, filtered", by(ols(filtered()))},
          {"IDIM-IV, filtered", by(scara.iv(filtered()))},
          {"the same, section 3.4", by(scara.iv_of_section_3_4(filtered()))},
          {"IDIM-OLS, not filtered", by(ols(raw()))},
          {"IDIM-IV, not filtered", by(scara.iv(raw()))}};
}

}  // namespace

void replay(const Scara& scara, std::uint64_t seeds, Report& report) {
  const PointToPointReference reference = Scara::unused_moves();
  std::vector<detail::Chart> charts;
  Table rows = {{"model", "joint 1: q", "q̇", "joint 2: q", "q̇"}};
  Matrix errors;  // of q and q̇ of both joints, summed over the logs
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Log unused = scara.log(reference, seeds + seed, {});
    const Matrix qd = differentiate(zero_phase(unused.q, unused.f_m, 20.0), unused.f_m).qd;
    const std::vector<Model> found = models(scara, scara.log(S2, seed));
    if (seed == 1) {
      errors = Matrix::Zero(static_cast<Index>(found.size()), 4);
      for (Index j = 0; j < 2; ++j) {
        charts.push_back({.title = "joint " + std::to_string(j + 1),
                          .x_label = "t [s]",
                          .y_label = "q [rad]",
                          .series = {curve("measured", 7, unused.t, unused.q.col(j))},
                          .size = detail::Chart::Size::wide});
      }
    }
    for (std::size_t m = 0; m < found.size(); ++m) {
      const Motion motion = replayed(scara, found[m].chi, reference, unused);
      for (Index j = 0; j < 2; ++j) {
        const auto row = static_cast<Index>(m);
        const auto q = motion.q.col(j);
        errors(row, 2 * j) += (q - unused.q.col(j)).norm() / unused.q.col(j).norm();
        errors(row, 2 * j + 1) += (motion.qd.col(j) - qd.col(j)).norm() / qd.col(j).norm();
        if (seed == 1) {
          charts[static_cast<std::size_t>(j)].series.push_back(curve(found[m].name, m, unused.t, q));
        }
      }
      if (seed == seeds) {
        auto& row = rows.emplace_back(std::vector<std::string>{found[m].name});
        for (Index c = 0; c < errors.cols(); ++c) {
          row.push_back(percent(errors(static_cast<Index>(m), c) / static_cast<double>(seeds)));
        }
      }
    }
  }
  report.print(
      "\nEq. (21), the direct dynamic model driven by the torques of a trajectory that was not used, 10 s\n"
      "without feedback; errors against the measured motion\n\n" +
      aligned(rows));
  report.figure("Eq. (21): positions from the same torques, without feedback (first log)", std::move(charts));
  report.expect(
      errors(5, 0) < 0.2 * errors(4, 0),
      "replayed without feedback, IV on raw data is five times nearer than least squares on raw data");
}

}  // namespace rivid::study
