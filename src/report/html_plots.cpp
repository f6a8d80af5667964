#include <array>

#include "report/html_parts.hpp"
#include "report/markup.hpp"
#include "report/words.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using Align = HtmlTable::Align;

// A place where report.js draws.
std::string plot(std::string_view kind, std::size_t joint, const std::string& label, std::size_t log = 0) {
  return element("div", "",
                 "class=\"plot " + std::string(kind) + "\" data-kind=\"" + std::string(kind) +
                     "\" data-joint=\"" + std::to_string(joint) + "\" data-log=\"" + std::to_string(log) +
                     "\" role=\"img\" aria-label=\"" + escaped(label) + "\"") +
         "\n";
}

std::string fit_table(const Fit& fit) {
  HtmlTable table({{"joint", Align::text},
                   {"rows", Align::number},
                   {"left out", Align::number},
                   {"relative error", Align::number},
                   {"centred", Align::number},
                   {"σ of the residual", Align::number},
                   {"unit", Align::text}});
  for (const JointFit& joint : fit.joints) {
    table.add({escaped(joint.name), std::to_string(joint.rows), std::to_string(joint.left_out),
               percent(joint.relative_error), percent(joint.centred_relative_error),
               number(joint.sigma_rho, 4), escaped(joint.unit)});
  }
  table.add({"all", std::to_string(fit.rows), "", percent(fit.relative_error),
             percent(fit.centred_relative_error), "", ""},
            "sum");
  return table.markup();
}

std::string toolbar(std::size_t log) {
  struct Button {
    const char* move;
    const char* sign;
    const char* label;
  };
  constexpr std::array<Button, 5> buttons = {{{"in", "+", "Zoom in"},
                                              {"out", "−", "Zoom out"},
                                              {"back", "‹", "Earlier"},
                                              {"forward", "›", "Later"},
                                              {"all", "all", "The whole log"}}};
  std::string out;
  for (const Button& b : buttons) {
    out += element("button", b.sign,
                   "type=\"button\" data-move=\"" + std::string(b.move) + "\" aria-label=\"" + b.label +
                       "\" title=\"" + b.label + "\"");
  }
  return element("div", out + element("span", "Drag over a plot to zoom, double-click to see all."),
                 "class=\"toolbar\" data-log=\"" + std::to_string(log) + "\"");
}

std::string log_plots(const Identification& result, const Prediction& log, std::size_t at) {
  std::string out = toolbar(at);
  for (std::size_t j = 0; j < log.joints.size(); ++j) {
    const JointFit& joint = result.fit.joints[j];
    out += element("h4", escaped(joint.name));
    out += plot("torque", j, "Torque of " + joint.name + ", measured and predicted", at);
    if (predicted(result)) {
      out += plot("residual", j, "Residual of " + joint.name, at);
    }
  }
  return out;
}

// Fits stand before the plots of the first log that they are about: one fit of all logs together, one a validation.
std::string log_fit(const Identification& result, const Prediction& log, bool first_of_fit) {
  if (!log.validation) {
    return first_of_fit && predicted(result) ? fit_table(result.fit) : "";
  }
  for (const Validation& validation : result.validation) {
    if (validation.file == log.source) {
      return fit_table(validation.fit);
    }
  }
  return "";
}

std::string p_value(const TestResult& test) { return number(test.p, 2); }

std::string residual_tests(const Diagnostics& diagnostics) {
  HtmlTable table({{"joint", Align::text},
                   {"autocorrelation", Align::number},
                   {"p (Ljung-Box)", Align::number},
                   {"skewness", Align::number},
                   {"excess kurtosis", Align::number},
                   {"p (Jarque-Bera)", Align::number}});
  for (const ResidualTests& r : diagnostics.residuals) {
    table.add({escaped(r.joint), fixed(r.autocorrelation, 2), p_value(r.whiteness), fixed(r.skewness, 2),
               fixed(r.excess_kurtosis, 2), p_value(r.normality)});
  }
  std::string out = table.markup();
  if (diagnostics.hausman) {
    out += element("p", escaped(in_words(*diagnostics.hausman)) + ".");
  }
  if (diagnostics.torque_lag) {
    out += element("p", escaped(in_words(*diagnostics.torque_lag)) + ".");
  }
  return out;
}

std::string iteration_table(const IvHistory& history) {
  HtmlTable table({{"k", Align::number},
                   {"‖Y − Vχ‖ / ‖Y‖", Align::number},
                   {"largest step", Align::number},
                   {"simulated to measured q", Align::number},
                   {"condition of V", Align::number},
                   {"of QᵀW", Align::number},
                   {"remark", Align::text}});
  for (std::size_t k = 0; k < history.iterations.size(); ++k) {
    const IvIteration& i = history.iterations[k];
    table.add({std::to_string(k), percent(i.relative_error), k == 0 ? "" : number(i.largest_step, 3) + " σ",
               i.to_measured.q.size() > 0 ? percent(i.to_measured.q.maxCoeff()) : "-",
               number(i.condition_V, 4), number(i.condition_VW, 4), escaped(i.safeguard)});
  }
  return table.markup();
}

// One number a joint; "-" where there is none.
std::string of_joint(const Vector& values, Index joint) {
  return joint < values.size() ? number(values[joint], 4) : "-";
}

// The loop as it was simulated last, and how far it is from the recorded one.
std::string loop_words(const IvHistory& history, const std::vector<JointFit>& joints) {
  const LoopDiagnosis& loop = history.loop;
  const IvIteration& last = history.iterations.back();
  std::vector<HtmlTable::Column> columns = {{"joint", Align::text}, {"design inertia", Align::number}};
  for (const Gain& gain : last.gains) {
    columns.push_back({escaped(gain.name), Align::number});
  }
  columns.push_back({"control signal", Align::number});
  columns.push_back({"tracking ratio", Align::number});
  HtmlTable table(columns);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto at = static_cast<Index>(j);
    std::vector<std::string> cells = {escaped(joints[j].name), of_joint(last.J, at)};
    for (const Gain& gain : last.gains) {
      cells.push_back(of_joint(gain.values, at));
    }
    cells.push_back(at < loop.control_error.size() ? percent(loop.control_error[at]) : "-");
    cells.push_back(at < loop.tracking_ratio.size() ? number(loop.tracking_ratio[at], 3) : "-");
    table.add(cells);
  }
  return element("h3", "The assumed controller") +
         element(
             "p",
             "Design inertias and gains of the last simulation, SI units. Then how far the control signal of "
             "the assumed law is from the recorded one, and how far the simulated positions are from the "
             "measured ones, compared with the reference. Both are small where the assumed loop is the "
             "actual one.") +
         table.markup();
}

}  // namespace

std::string torques_section(const Identification& result, std::span<const Prediction> predictions) {
  if (predictions.empty()) {
    return {};
  }
  std::string out = element("h2", "Torques", "id=\"torques\"");
  out += element("p",
                 legend_item("measured", "measured") + legend_item("predicted", "predicted by the model") +
                     legend_item("residual", "residual") +
                     legend_item("left-out", "samples that are left out: too slow, or near a reversal") +
                     "Torques are those of the rows before they are decimated.",
                 "class=\"legend\"");
  if (const Index stride = thinning(predictions); stride > 1) {
    out += element("p", "The logs are long: one sample in " + std::to_string(stride) + " is shown.");
  }
  bool first_of_fit = true;
  for (std::size_t k = 0; k < predictions.size(); ++k) {
    const Prediction& log = predictions[k];
    out += element("h3", (log.validation ? "Validation: " : "Identification: ") + escaped(log.source));
    out += log_fit(result, log, first_of_fit) + log_plots(result, log, k);
    first_of_fit = first_of_fit && log.validation;
  }
  return element("section", out);
}

std::string residuals_section(const Identification& result, std::span<const Prediction> predictions) {
  std::string plots;
  for (std::size_t j = 0; j < result.fit.joints.size() && predicted(result); ++j) {
    const std::string& name = result.fit.joints[j].name;
    const ResidualShape shape = residual_shape(predictions, j);
    if (!shape.counts.empty()) {
      const std::string beyond =
          shape.outside > 0 ? ", " + counted(shape.outside, "row") + " beyond five deviations" : "";
      plots += element("div",
                       element("h4", escaped(name) + element("small", counted(shape.rows, "row") + beyond)) +
                           plot("histogram", j, "Histogram of the residual of " + name) +
                           plot("autocorrelation", j, "Autocorrelation of the residual of " + name));
    }
  }
  if (plots.empty() && !result.diagnostics) {
    return {};
  }
  std::string out = element("h2", "Residual", "id=\"residual\"");
  if (result.diagnostics) {
    out +=
        element(
            "p",
            "Of the rows of the fit. Small p-values mean that the residual is not white, or not normal; with "
            "many rows they come with effects too small to matter.") +
        residual_tests(*result.diagnostics);
  }
  if (!plots.empty()) {
    out +=
        element(
            "p",
            "Histograms with the normal distribution of the same deviation; autocorrelation over the lag in "
            "rows, with the bounds that white noise would keep in 95 % of the lags.") +
        element("div", plots, "class=\"pairs\"");
  }
  return element("section", out);
}

std::string iterations_section(const Identification& result) {
  if (!result.iv || result.iv->iterations.empty()) {
    return {};
  }
  std::string out = element("h2", "Iterations", "id=\"iterations\"") + iteration_table(*result.iv);
  out +=
      element("h3", "Torque error") +
      element(
          "p",
          "Of the model along the simulated motion, relative to the norm of all torques; the squares of the "
          "joints' shares add up to the square of the whole.") +
      plot("torque-error", 0, "Torque error by iteration");
  out += element("h3", "Parameters") +
         element("p", "Over the iterations, with the 95 % interval of the result as a band.") +
         parameter_paths(result.parameters, result.iv->iterations);
  out +=
      element("h3", "Motion errors") +
      element(
          "p",
          "Distance of the simulated motion from the measured one (solid) and from the reference (dashed), "
          "relative to the norm of the latter two.");
  std::string motions;
  for (std::size_t j = 0; j < result.fit.joints.size(); ++j) {
    const std::string& name = result.fit.joints[j].name;
    motions +=
        element("div", element("h4", escaped(name)) + plot("motion-error", j, "Motion errors of " + name));
  }
  out += element("div", motions, "class=\"pairs\"") + loop_words(*result.iv, result.fit.joints);
  return element("section", out);
}

}  // namespace rivid::detail
