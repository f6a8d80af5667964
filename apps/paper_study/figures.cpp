#include "paper_study/figures.hpp"

#include <array>
#include <functional>
#include <utility>
#include <vector>

#include "paper_study/runs.hpp"

namespace rivid::study {

namespace {

std::vector<double> numbers(const Eigen::Ref<const Vector>& x) { return {x.begin(), x.end()}; }

std::string joint(Index j) { return "joint " + std::to_string(j + 1); }

// One number an iteration.
svg::Series by_iteration(const std::string& label, const Identification& found,
                         const std::function<double(const IvIteration&)>& of, std::size_t color,
                         bool dashed = false) {
  svg::Series out{.label = label, .x = {}, .y = {}, .dashed = dashed, .markers = true, .color = color};
  for (const IvIteration& iteration : history(found).iterations) {
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

}  // namespace

void figure_torques(const Scara& scara, const Log& log, const Identification& found, Report& report) {
  const Simulation run =
      simulate(scara.robot, scara.base, found.chi, scara.control, history(found).iterations.back().J,
               Scara::moves(S2), {.f_m = Scara::f_m, .sampling = scara.sampling});
  const Vector Y_e = observation(scara.robot, scara.base, run.motion).dense() * found.chi;
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
  report.figure("fig_07_torques.svg",
                "Fig. 7: torques measured at 200 Hz and predicted along the simulated motion", panels, 1,
                900.0, 300.0);
}

void figure_motion_errors(int number, const std::string& what, const Identification& found, Report& report) {
  for (Index j = 0; j < 2; ++j) {
    svg::Panel panel = over_iterations(joint(j) + ", " + what, "relative error [%]", true);
    const std::array<std::pair<const char*, Vector MotionError::*>, 3> quantities = {
        {{"q", &MotionError::q}, {"q̇", &MotionError::qd}, {"q̈", &MotionError::qdd}}};
    for (std::size_t i = 0; i < quantities.size(); ++i) {
      const auto& [symbol, member] = quantities[i];
      panel.series.push_back(by_iteration(
          std::string(symbol) + " against measured", found,
          [&](const IvIteration& k) { return 100.0 * (k.to_measured.*member)[j]; }, i));
      panel.series.push_back(by_iteration(
          std::string(symbol) + " against reference", found,
          [&](const IvIteration& k) { return 100.0 * (k.to_reference.*member)[j]; }, i, true));
    }
    const std::string digits = std::to_string(number + static_cast<int>(j));
    report.figure("fig_" + std::string(digits.size() < 2 ? "0" : "") + digits + "_motion_errors.svg",
                  "Fig. " + digits + ": simulated motion, relative errors", {panel}, 1, 560.0, 380.0);
  }
}

void figure_parameters(const Identification& found, Report& report) {
  std::vector<svg::Panel> panels;
  for (std::size_t i = 0; i < b; ++i) {
    const svg::Series estimate = by_iteration(
        "estimate", found, [i](const IvIteration& k) { return in_paper[i] * k.chi[static_cast<Index>(i)]; },
        0);
    svg::Series true_value =
        by_iteration("truth", found, [i](const IvIteration&) { return truth[i]; }, 1, true);
    true_value.markers = false;
    svg::Panel& panel =
        panels.emplace_back(over_iterations(names[i], std::string(names[i]) + " [" + units[i] + "]", false));
    panel.series.push_back(true_value);
    panel.series.push_back(estimate);
  }
  report.figure("fig_10_parameters.svg", "Fig. 10: parameters by iteration, regular start", panels, 4, 300.0,
                220.0);
}

void figure_torque_errors(const Scara& scara, const Log& log, const Identification& found, Report& report) {
  const Rows rows = rivid::rows(scara.robot, scara.base, log, found.estimation.signal);
  std::vector<svg::Panel> panels;
  for (Index j = 0; j < 2; ++j) {
    const auto at = static_cast<std::size_t>(j);
    const JointRows& W = rows.W.joints[at];
    const Vector& Y = rows.Y[at];
    svg::Panel& panel = panels.emplace_back(over_iterations(joint(j), "relative torque error [%]", true));
    panel.series.push_back(by_iteration(
        "‖Y − Wχ‖ / ‖Y‖", found,
        [&](const IvIteration& k) { return 100.0 * (Y - W.W * k.chi(W.columns)).norm() / Y.norm(); }, 0));
    panel.series.push_back(by_iteration(
        "‖Y − Vχ‖ / ‖Y‖", found,
        [&](const IvIteration& k) { return 100.0 * k.joint_error_norm[j] / Y.norm(); }, 1, true));
  }
  report.figure("fig_11_torque_errors.svg", "Fig. 11: torque error by iteration, regular start", panels, 2,
                480.0, 320.0);
}

}  // namespace rivid::study
