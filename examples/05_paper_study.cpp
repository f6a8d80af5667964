#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <iterator>

#include "rivid/rivid.hpp"
#include "svg_plot.hpp"

// The case study of [RIV], sections 4.2 to 4.5: its SCARA in simulation, identified by IDIM-OLS and IDIM-IV, beside the
// numbers that the paper prints.
//
//   example_05_paper_study [FOLDER [SEEDS]]
//
// Tables go to the screen, figures as SVG into FOLDER (paper_study). Tables are over SEEDS logs (20), which differ in
// their noise; figures show the first of them. The exit code is 1 where a claim of the paper that holds in simulation
// does not hold any more.

namespace {

using rivid::Identification;
using rivid::Index;
using rivid::Iv;
using rivid::Log;
using rivid::Matrix;
using rivid::Status;
using rivid::Vector;

constexpr double L = 0.5;  // length of the first link [m]
constexpr double f_m = 200.0;
constexpr std::size_t b = 8;
constexpr std::array<const char*, b> names = {"ZZ1R", "Fv1", "Fc1", "ZZ2", "LMX2", "LMY2", "Fv2", "Fc2"};
constexpr std::array<const char*, b> units = {"kg·m²", "N·m·s/rad", "N·m",       "kg·m²",
                                              "kg·m²", "kg·m²",     "N·m·s/rad", "N·m"};
// Where rivid has MX2 and MY2, the paper has L MX2 and L MY2.
constexpr std::array<double, b> in_paper = {1, 1, 1, 1, L, L, 1, 1};
constexpr std::array<double, b> truth = {3.44, 0.03, 0.82, 0.062, 0.121, 0.007, 0.013, 0.137};

// A table of the paper: estimate and 2 σ as printed, and its relative error ‖Y − Wχ̂‖ / ‖Y‖, zero where it has none.
struct PaperTable {
  std::array<double, b> chi;
  std::array<double, b> two_sigma;
  double relative_error;
};
constexpr PaperTable table_1 = {.chi = {3.44, 0.03, 0.82, 0.062, 0.121, 0.007, 0.013, 0.137},
                                .two_sigma = {0.034, 0.031, 0.1, 0.0006, 0.0014, 0.0007, 0.006, 0.006},
                                .relative_error = 0.024};
constexpr PaperTable table_2 = {.chi = {3.45, 0.04, 0.82, 0.061, 0.124, 0.007, 0.013, 0.137},
                                .two_sigma = {0.036, 0.032, 0.05, 0.0006, 0.0013, 0.0005, 0.0084, 0.008},
                                .relative_error = 0.021};
constexpr PaperTable table_3 = {.chi = table_2.chi, .two_sigma = table_2.two_sigma, .relative_error = 0.0};
constexpr std::array<std::array<double, b>, 4> table_4 = {
    {{1, 0, 0, 1, 0, 0, 0, 0},
     {3.46, 0.04, 0.82, 0.06, 0.122, 0.05, 0.005, 0.130},
     {3.45, 0.02, 0.85, 0.061, 0.124, 0.07, 0.01, 0.132},
     {3.45, 0.02, 0.85, 0.061, 0.124, 0.07, 0.01, 0.132}}};
constexpr PaperTable table_5 = {.chi = {1.5, 0.095, 0.55, 0.14, 0.63, 0.1, 0.001, 0.19},
                                .two_sigma = {0.05, 0.15, 0.26, 0.018, 0.035, 0.023, 0.143, 0.244},
                                .relative_error = 0.8};
constexpr PaperTable table_6 = {.chi = {3.45, 0.05, 0.81, 0.061, 0.124, 0.008, 0.023, 0.13},
                                .two_sigma = {0.007, 0.023, 0.004, 0.0004, 0.0015, 0.0009, 0.0022, 0.0038},
                                .relative_error = 0.08};
constexpr PaperTable table_7 = {.chi = {3.44, 0.02, 0.86, 0.060, 0.124, 0.007, 0.01, 0.13},
                                .two_sigma = {0.014, 0.012, 0.016, 0.0001, 0.0002, 0.0003, 0.003, 0.0008},
                                .relative_error = 0.0};

// Size of the moves: S1, and S2 with its via points doubled.
constexpr double S1 = 1.0;
constexpr double S2 = 2.0;

// The robot in its closed loop.
struct Scara {
  rivid::Robot robot;
  rivid::BaseParameters base;
  Vector chi = Vector(b);
  rivid::PdControl control{.omega_n = Eigen::Vector2d(1, 10), .zeta = Eigen::Vector2d(1, 1)};
  rivid::Sampling sampling{.period = 1.0 / f_m};

  Scara() {
    // Both axes are vertical: gravity has no effect.
    robot = rivid::robot_from(std::vector<rivid::MdhRow>{{}, {.a = L}});
    for (rivid::Joint& joint : robot.joints) {
      joint.friction = rivid::Friction::coulomb;
    }
    robot.joints[1].rotor_inertia = false;  // ZZ2R = ZZ2 + Ia2 is one parameter in the paper
    base = rivid::base_parameters(robot);
    for (std::size_t i = 0; i < b; ++i) {
      chi[static_cast<Index>(i)] = truth[i] / in_paper[i];
    }
  }

  [[nodiscard]] static rivid::PointToPointReference moves(double size) {
    Matrix via(9, 2);
    via << 0, 0, 1.5, 2, -1, -1, 1, 1.5, -1.5, -2, 1, -.5, -.5, 2, 1.2, -1.5, 0, 0;
    return rivid::PointToPointReference({.via = size * via, .durations = Vector::Constant(1, 2.5)});
  }

  // What the computer of the controller records: encoder noise goes through the control law, disturbances act on the
  // joints.
  [[nodiscard]] Log log(double size, std::uint64_t seed) const {
    const double encoder_noise = 4.5e-5;                   // rad
    const Eigen::Vector2d disturbance_sigma(0.06, 0.015);  // N·m
    const rivid::PointToPointReference reference = moves(size);
    const auto rows = static_cast<Index>(std::lround(reference.duration() * f_m)) + 1;
    rivid::SimulationOptions options{.f_m = f_m, .sampling = sampling};
    options.sampling.position_noise = rivid::white_noise(seed, 1, rows, Vector::Constant(2, encoder_noise));
    options.disturbance = rivid::white_noise(seed, 2, rows, disturbance_sigma);
    const double J_2 = truth[3];
    const double J_1 = truth[0] + J_2 + 2.0 * truth[4];
    const rivid::Simulation run =
        rivid::simulate(robot, base, chi, control, Eigen::Vector2d(J_1, J_2), reference, options);
    Log out;
    out.source = "seed " + std::to_string(seed);
    out.t = run.t;
    out.f_m = f_m;
    out.q = run.q_measured;
    out.v_tau = run.v_tau;
    out.q_r = run.q_r;
    return out;
  }

  // IDIM-IV that knows the control law, its bandwidth scaled.
  [[nodiscard]] Iv iv(const rivid::SignalOptions& signal, double bandwidth = 1.0) const {
    Iv out;
    out.signal = signal;
    out.control = rivid::PdControl{.omega_n = bandwidth * control.omega_n, .zeta = control.zeta};
    out.sampling = sampling;
    return out;
  }
};

double value(const Identification& found, std::size_t i) {
  return in_paper[i] * found.chi[static_cast<Index>(i)];
}

double sigma(const Identification& found, std::size_t i) { return in_paper[i] * found.parameters[i].sigma; }

std::size_t iterations(const Identification& found) { return found.iv->iterations.size() - 1; }

bool identified(const Identification& found) { return found.status == Status::identified; }

double off(const Identification& found, std::size_t i) { return std::abs(value(found, i) / truth[i] - 1.0); }

using Runs = std::vector<Identification>;

double mean(const Runs& runs, const std::function<double(const Identification&)>& of) {
  double sum = 0.0;
  for (const Identification& run : runs) {
    sum += of(run);
  }
  return sum / static_cast<double>(runs.size());
}

std::string cell(const std::string& text, std::size_t width) {
  return text + std::string(width - std::min(width, rivid::display_width(text)), ' ');
}

std::string with_sigma(double chi, double sigma_chi) {
  return rivid::number(chi, 4) + " ± " + rivid::number(sigma_chi, 2);
}

void print(const std::string& title, const PaperTable& paper, const Runs& all) {
  Runs runs;
  std::ranges::copy_if(all, std::back_inserter(runs), identified);
  std::cout << '\n' << title << ": " << runs.size() << " of " << all.size() << " identified";
  if (runs.empty()) {
    std::cout << '\n';
    return;
  }
  if (runs[0].iv) {
    const auto [least, most] = std::ranges::minmax(runs, {}, iterations);
    std::cout << ", in " << iterations(least);
    if (iterations(most) > iterations(least)) {
      std::cout << " to " << iterations(most);
    }
    std::cout << " iterations";
  }
  std::cout << "\n\n  " << cell("parameter", 11) << cell("unit", 11) << cell("truth", 8)
            << cell("paper ± σ", 20) << cell("rivid ± σ", 24) << "scatter\n";
  for (std::size_t i = 0; i < b; ++i) {
    const double average = mean(runs, [i](const Identification& run) { return value(run, i); });
    const double squares =
        mean(runs, [&](const Identification& run) { return std::pow(value(run, i) - average, 2); });
    const auto count = static_cast<double>(runs.size());
    const double scatter = std::sqrt(squares * count / std::max(count - 1.0, 1.0));
    std::cout << "  " << cell(names[i], 11) << cell(units[i], 11) << cell(rivid::number(truth[i], 4), 8)
              << cell(with_sigma(paper.chi[i], 0.5 * paper.two_sigma[i]), 20)
              << cell(with_sigma(average,
                                 mean(runs, [i](const Identification& run) { return sigma(run, i); })),
                      24)
              << rivid::number(scatter, 2) << '\n';
  }
  const auto percent = [](double x) { return rivid::number(100.0 * x, 3) + " %"; };
  std::cout << "  ‖Y − Wχ‖ / ‖Y‖: "
            << percent(mean(runs, [](const Identification& run) { return run.fit.relative_error; }));
  if (runs[0].iv) {
    std::cout << ", ‖Y − Vχ‖ / ‖Y‖: " << percent(mean(runs, [](const Identification& run) {
      return run.iv->iterations.back().relative_error;
    }));
  }
  if (paper.relative_error > 0.0) {
    std::cout << "; paper: " << percent(paper.relative_error);
  }
  std::cout << '\n';
}

void print_table_4(const Identification& found) {
  const auto& iterates = found.iv->iterations;
  const auto row = [&](const std::string& name, const auto& of_paper, const auto& of_rivid) {
    std::string line = "  " + cell(name, 11);
    for (std::size_t k = 0; k < table_4.size(); ++k) {
      line += cell(of_paper(k), k == 0 ? 10 : 8);
    }
    for (std::size_t k = 0; k < iterates.size(); ++k) {
      line += cell(of_rivid(k), 10);
    }
    std::cout << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
  };
  std::cout << "\nTable 4, IDIM-IV, filtered, regular start, parameters by iteration (seed 1)\n\n";
  row(
      "parameter", [](std::size_t k) { return (k == 0 ? "paper: " : "") + std::to_string(k); },
      [](std::size_t k) { return (k == 0 ? "rivid: " : "") + std::to_string(k); });
  for (std::size_t i = 0; i < b; ++i) {
    row(
        names[i], [i](std::size_t k) { return rivid::number(table_4[k][i], 4); },
        [&](std::size_t k) {
          return rivid::number(in_paper[i] * iterates[k].chi[static_cast<Index>(i)], 4);
        });
  }
}

// How the runs ended, and for each way the reasons of the first run that ended so.
void print_outcomes(const std::string& title, const Runs& runs) {
  std::cout << '\n' << title << '\n';
  std::vector<Status> seen;
  for (const Identification& run : runs) {
    if (std::ranges::count(seen, run.status) > 0) {
      continue;
    }
    seen.push_back(run.status);
    std::cout << "  " << rivid::name(run.status) << ": "
              << std::ranges::count(runs, run.status, &Identification::status) << " of " << runs.size();
    if (identified(run)) {
      Runs good;
      std::ranges::copy_if(runs, std::back_inserter(good), identified);
      const auto [least, most] =
          std::ranges::minmax(good, {}, [](const Identification& found) { return value(found, 0); });
      std::cout << ", ZZ1R from " << rivid::number(value(least, 0), 4) << " to "
                << rivid::number(value(most, 0), 4) << " kg·m²";
    }
    std::cout << '\n';
    for (const std::string& reason : run.reasons) {
      std::cout << "    " << reason << '\n';
    }
  }
}

// Errors of the simulated motion of the last iteration, as figs 8, 9, 12 and 13 end.
void print_motion_errors(const std::string& title, const Runs& all) {
  Runs runs;
  std::ranges::copy_if(all, std::back_inserter(runs), identified);
  if (runs.empty()) {
    return;
  }
  const auto errors = [&](rivid::MotionError rivid::IvIteration::* from, Index j) {
    std::string out;
    for (const auto quantity : {&rivid::MotionError::q, &rivid::MotionError::qd, &rivid::MotionError::qdd}) {
      const double error = mean(
          runs, [&](const Identification& run) { return (run.iv->iterations.back().*from.*quantity)[j]; });
      out += (out.empty() ? "" : ", ") + rivid::number(100.0 * error, 3);
    }
    return out + " %";
  };
  std::cout << '\n' << title << ", relative errors of q, q̇, q̈ of the simulated motion\n\n";
  std::cout << "           " << cell("against measured", 24) << "against reference\n";
  // Section 4.3 has one number for both joints, and 4.5 says "close to" the same.
  std::cout << "  paper    " << cell("0.5, 5, 10 %", 24) << "1.5, 15, 30 %\n";
  for (Index j = 0; j < 2; ++j) {
    std::cout << "  joint " << j + 1 << "  " << cell(errors(&rivid::IvIteration::to_measured, j), 24)
              << errors(&rivid::IvIteration::to_reference, j) << '\n';
  }
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

std::vector<double> numbers(const Eigen::Ref<const Vector>& x) { return {x.begin(), x.end()}; }

// One number an iteration.
svg::Series by_iteration(const std::string& label, const Identification& found,
                         const std::function<double(const rivid::IvIteration&)>& of, std::size_t color,
                         bool dashed = false) {
  svg::Series out{.label = label, .x = {}, .y = {}, .dashed = dashed, .markers = true, .color = color};
  for (const rivid::IvIteration& iteration : found.iv->iterations) {
    out.x.push_back(static_cast<double>(out.x.size()));
    out.y.push_back(of(iteration));
  }
  return out;
}

// A panel over the iterations, without its series yet.
svg::Panel over_iterations(const std::string& title, const std::string& y_label, bool logarithmic) {
  svg::Panel out;
  out.title = title;
  out.x.label = "iteration";
  out.x.least_step = 1.0;
  out.y.label = y_label;
  out.y.logarithmic = logarithmic;
  return out;
}

class Figures {
 public:
  explicit Figures(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // Fig. 7: torques measured, and those of the model along the simulated motion.
  void torques(const Scara& scara, const Log& log, const Identification& found) const {
    const rivid::Simulation run =
        rivid::simulate(scara.robot, scara.base, found.chi, scara.control, found.iv->iterations.back().J,
                        Scara::moves(S2), {.f_m = f_m, .sampling = scara.sampling});
    const Vector Y_e = rivid::observation(scara.robot, scara.base, run.motion).dense() * found.chi;
    std::vector<svg::Panel> panels;
    for (Index j = 0; j < 2; ++j) {
      const Vector predicted = Y_e.segment(j * run.t.size(), run.t.size());
      svg::Panel& panel = panels.emplace_back();
      panel.title = joint(j);
      panel.x.label = "t [s]";
      panel.y.label = "τ [N·m]";
      const auto add = [&](const char* label, const Vector& tau, std::size_t color) {
        panel.series.push_back({.label = label, .x = numbers(log.t), .y = numbers(tau), .color = color});
      };
      add("measured", log.v_tau.col(j), 5);
      add("predicted", predicted, 1);
      add("measured − predicted", log.v_tau.col(j) - predicted, 0);
    }
    write("fig_07_torques.svg", "Fig. 7: torques measured at 200 Hz and predicted along the simulated motion",
          panels, 1, 900.0, 300.0);
  }

  // Figs 8, 9, 12, 13: distance of the simulated motion from the filtered measured one and from the reference.
  void motion_errors(int figure, const std::string& what, const Identification& found) const {
    for (Index j = 0; j < 2; ++j) {
      svg::Panel panel = over_iterations(joint(j) + ", " + what, "relative error [%]", true);
      const std::array<std::pair<const char*, Vector rivid::MotionError::*>, 3> quantities = {
          {{"q", &rivid::MotionError::q}, {"q̇", &rivid::MotionError::qd}, {"q̈", &rivid::MotionError::qdd}}};
      for (std::size_t i = 0; i < quantities.size(); ++i) {
        const auto& [symbol, member] = quantities[i];
        panel.series.push_back(by_iteration(
            std::string(symbol) + " against measured", found,
            [&](const rivid::IvIteration& k) { return 100.0 * (k.to_measured.*member)[j]; }, i));
        panel.series.push_back(by_iteration(
            std::string(symbol) + " against reference", found,
            [&](const rivid::IvIteration& k) { return 100.0 * (k.to_reference.*member)[j]; }, i, true));
      }
      const std::string number = std::to_string(figure + static_cast<int>(j));
      write("fig_" + std::string(number.size() < 2 ? "0" : "") + number + "_motion_errors.svg",
            "Fig. " + number + ": simulated motion, relative errors", {panel}, 1, 560.0, 380.0);
    }
  }

  // Fig. 10.
  void parameters(const Identification& found) const {
    std::vector<svg::Panel> panels;
    for (std::size_t i = 0; i < b; ++i) {
      svg::Series estimate = by_iteration(
          "estimate", found,
          [i](const rivid::IvIteration& k) { return in_paper[i] * k.chi[static_cast<Index>(i)]; }, 0);
      svg::Series true_value =
          by_iteration("truth", found, [i](const rivid::IvIteration&) { return truth[i]; }, 1, true);
      true_value.markers = false;
      svg::Panel& panel = panels.emplace_back(
          over_iterations(names[i], std::string(names[i]) + " [" + units[i] + "]", false));
      panel.series.push_back(true_value);
      panel.series.push_back(estimate);
    }
    write("fig_10_parameters.svg", "Fig. 10: parameters by iteration, regular start", panels, 4, 300.0,
          220.0);
  }

  // Fig. 11; beside the error against W that of the stop rule, against the simulated V.
  void torque_errors(const Scara& scara, const Log& log, const Identification& found) const {
    const rivid::Rows rows = rivid::rows(scara.robot, scara.base, log, found.signal);
    std::vector<svg::Panel> panels;
    for (Index j = 0; j < 2; ++j) {
      const auto at = static_cast<std::size_t>(j);
      const rivid::JointRows& W = rows.W.joints[at];
      const Vector& Y = rows.Y[at];
      svg::Panel& panel = panels.emplace_back(over_iterations(joint(j), "relative torque error [%]", true));
      panel.series.push_back(by_iteration(
          "‖Y − Wχ‖ / ‖Y‖", found,
          [&](const rivid::IvIteration& k) { return 100.0 * (Y - W.W * k.chi(W.columns)).norm() / Y.norm(); },
          0));
      panel.series.push_back(by_iteration(
          "‖Y − Vχ‖ / ‖Y‖", found,
          [&](const rivid::IvIteration& k) { return 100.0 * k.joint_error_norm[j] / Y.norm(); }, 1, true));
    }
    write("fig_11_torque_errors.svg", "Fig. 11: torque error by iteration, regular start", panels, 2, 480.0,
          320.0);
  }

 private:
  [[nodiscard]] static std::string joint(Index j) { return "joint " + std::to_string(j + 1); }

  void write(const std::string& file, const std::string& title, const std::vector<svg::Panel>& panels,
             int columns, double width, double height) const {
    rivid::write_file(folder_ / file, svg::figure(title, panels, columns, width, height));
    std::cout << "wrote " << (folder_ / file).string() << '\n';
  }

  std::filesystem::path folder_;
};

class Claims {
 public:
  void expect(bool holds, const std::string& claim) {
    if (!holds) {
      std::cout << "does not hold: " << claim << '\n';
      hold_ = false;
    }
  }
  [[nodiscard]] bool hold() const { return hold_; }

 private:
  bool hold_ = true;
};

int study(const std::filesystem::path& folder, std::uint64_t seeds) {
  const Scara scara;
  const rivid::SignalOptions filtered = {.cutoff_hz = 20.0, .decimation = {20}};
  // Beyond the paper: without the rows where a joint hardly moves, for a joint that sticks does not obey the model.
  const rivid::SignalOptions moving = {
      .cutoff_hz = 20.0, .decimation = {20}, .velocity_threshold = {0.1, 0.1}};
  const rivid::SignalOptions raw = {};

  Runs ols;
  Runs good_start;
  Runs regular_start;
  Runs clean_rows;
  Runs raw_ols;
  Runs raw_iv;
  Runs half;
  Runs enough;
  Runs too_little;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Log s2 = scara.log(S2, seed);
    ols.push_back(rivid::identify(scara.robot, s2, rivid::Ols{.signal = filtered}));
    Iv from_ols = scara.iv(filtered);
    from_ols.chi_0 = ols.back().chi;
    good_start.push_back(rivid::identify(scara.robot, s2, from_ols));
    regular_start.push_back(rivid::identify(scara.robot, s2, scara.iv(filtered)));
    // A torque that is held for a sample acts half a sample late.
    clean_rows.push_back(rivid::identify(scara.robot, rivid::shift_torque(s2, -0.5), scara.iv(moving)));
    raw_ols.push_back(rivid::identify(scara.robot, s2, rivid::Ols{.signal = raw}));
    raw_iv.push_back(rivid::identify(scara.robot, s2, scara.iv(raw)));
    half.push_back(rivid::identify(scara.robot, s2, scara.iv(filtered, 0.5)));
    const Log s1 = scara.log(S1, seed);
    enough.push_back(rivid::identify(scara.robot, s1, scara.iv(filtered, 0.40)));
    too_little.push_back(rivid::identify(scara.robot, s1, scara.iv(filtered, 0.28)));
  }

  std::cout << "SCARA of [RIV], section 4, in simulation: means over "
            << rivid::counted(static_cast<std::ptrdiff_t>(seeds), "log")
            << ". σ is the classical standard\ndeviation, scatter that of the estimates from log to log.\n";
  print("Table 1, IDIM-OLS, filtered", table_1, ols);
  print("Table 2, IDIM-IV, filtered, started from IDIM-OLS", table_2, good_start);
  print("Table 3, IDIM-IV, filtered, regular start", table_3, regular_start);
  std::cout << "  Tables 2 and 3 are at most "
            << rivid::number(largest_difference(good_start, regular_start), 2) << " σ apart in any log.\n";
  print("As Table 3, without slow rows, torques moved by half a sample", table_3, clean_rows);
  print_table_4(regular_start.front());
  print_motion_errors("Figs 8 and 9", regular_start);
  print("Table 5, IDIM-OLS, nothing filtered", table_5, raw_ols);
  print("Table 6, IDIM-IV, nothing filtered, regular start", table_6, raw_iv);
  print("Table 7, IDIM-IV, filtered, regular start, half the bandwidth", table_7, half);
  print_motion_errors("Figs 12 and 13", half);
  print_outcomes("Section 4.5, S1, 0.40 of the bandwidth", enough);
  print_outcomes("Section 4.5, S1, 0.28 of the bandwidth", too_little);
  std::cout << '\n';

  const Log first = scara.log(S2, 1);
  const Figures figures(folder);
  figures.torques(scara, first, good_start.front());
  figures.motion_errors(8, "regular start", regular_start.front());
  figures.parameters(regular_start.front());
  figures.torque_errors(scara, first, regular_start.front());
  figures.motion_errors(12, "half the bandwidth", half.front());

  Claims claims;
  const auto all = [](const Runs& runs, const std::function<bool(const Identification&)>& of) {
    return std::ranges::all_of(runs, of);
  };
  const auto inertias_within = [](double part) {
    return [part](const Identification& run) {
      return identified(run) && off(run, 0) < part && off(run, 3) < part;
    };
  };
  claims.expect(all(good_start, inertias_within(0.02)) && all(regular_start, inertias_within(0.02)),
                "IV on filtered data finds the inertias within 2 % from either start");
  claims.expect(all(raw_iv, inertias_within(0.01)), "IV on raw data finds the inertias within 1 %");
  claims.expect(all(raw_ols, [](const Identification& run) { return off(run, 0) > 0.5; }),
                "least squares on raw data misses ZZ1R by more than half");
  bool same = true;
  for (std::size_t i = 0; i < half.size(); ++i) {
    same =
        same && identified(half[i]) && std::abs(value(half[i], 0) / value(regular_start[i], 0) - 1.0) < 0.002;
  }
  claims.expect(same, "half the bandwidth gives the same ZZ1R within 0.2 %");
  claims.expect(all(enough, identified), "on S1, 0.40 of the bandwidth is enough");
  claims.expect(std::ranges::none_of(too_little, identified), "on S1, 0.28 of the bandwidth is refused");
  return claims.hold() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path folder = argc > 1 ? argv[1] : "paper_study";
  const std::uint64_t seeds = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 20;
  if (argc > 3 || seeds < 1 || seeds > 1000) {
    std::cerr << "usage: " << argv[0] << " [FOLDER [SEEDS, 1 to 1000]]\n";
    return 2;
  }
  return study(folder, seeds);
}
