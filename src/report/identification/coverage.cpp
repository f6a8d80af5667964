#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "identify/figures/friction_curves.hpp"
#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// One gap, at rest.
Vector with_gap(const Vector& values, double middle) {
  const Index half = values.size() / 2;
  Vector out(values.size() + 1);
  out << values.head(half), middle, values.tail(half);
  return out;
}

Chart friction_chart(const Evidence& evidence, std::size_t joint, const StackedRows& rows) {
  const Joint& of = evidence.robot.joints[joint];
  const JointFit& fit = evidence.result.fit.joints[joint];
  const FrictionCurve curve = friction_curve(evidence.robot, evidence.result, joint, rows);
  Chart out{.id = chart_id("friction", joint),
            .title = fit.name,
            .remark = "law " + std::string(name(of.friction)),
            .label = "Friction of " + fit.name + " over its speed, measured and model",
            .x_label = "q̇ [" + speed_unit(of) + "]",
            .y_label = "τ_f [" + fit.unit + "]"};
  const Vector speed = with_gap(curve.velocity, 0.0);
  const Vector torque = with_gap(curve.torque, no_value);
  const Vector width = with_gap(curve.half_width, no_value);
  out.series = {
      cloud("measured", "measured", rows.velocity, rows.friction),
      {"95 % confidence band", "predicted", Series::Kind::band, speed, torque - width, torque + width},
      {"model", "predicted", Series::Kind::line, speed, torque}};
  if (!curve.a_priori.isZero(0.0)) {
    out.series.push_back(
        {"robot description", "apriori", Series::Kind::line, speed, with_gap(curve.a_priori, no_value)});
  }
  return out;
}

Chart coverage_chart(const Evidence& evidence, std::size_t joint) {
  const Joint& of = evidence.robot.joints[joint];
  const std::string& joint_name = evidence.result.fit.joints[joint].name;
  Chart out{.id = chart_id("coverage", joint),
            .title = joint_name,
            .label = "Speed over position of " + joint_name,
            .x_label = "q [" + position_unit(of) + "]",
            .y_label = "q̇ [" + speed_unit(of) + "]"};
  if (!evidence.validation().empty()) {
    const StackedRows others = stacked_rows(evidence.validation(), joint);
    out.series.push_back(cloud("validation", "validation", others.position, others.velocity));
  }
  const StackedRows rows = stacked_rows(evidence.fitted(), joint);
  out.series.push_back(cloud("fit", "measured", rows.position, rows.velocity));
  return out;
}

// The parameter that is excited most comes first.
Table excitation_table(const Evidence& evidence) {
  constexpr std::size_t few = 16;        // rows of a table that is not folded; a choice
  constexpr double decades_below = 3.0;  // the residual, where bars begin
  const Vector shown = excitation(evidence.result, evidence.logs);
  const auto of = [&](std::size_t i) { return at(shown, i); };
  std::vector<std::size_t> order(static_cast<std::size_t>(shown.size()));
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater<>(), of);
  const double largest = std::max(shown.size() > 0 ? shown.maxCoeff() : 1.0, 1.0);
  const double decades = std::log10(largest) + decades_below;
  const auto bar = [&](std::size_t i) {
    return of(i) > 0.0 ? std::clamp((std::log10(of(i)) + decades_below) / decades, 0.0, 1.0) : 0.0;
  };
  Table out = table_of(order, {{{"parameter", format::name},
                                [&](std::size_t i) { return evidence.result.parameters[i].name; }},
                               {{"torque / residual", format::significant(3)}, of},
                               {{"", format::share}, bar}});
  out.fold = {"Excitation of the " + counted(std::ssize(order), "parameter"), order.size() <= few};
  return out;
}

}  // namespace

Section friction_section(const Evidence& evidence) {
  Section out{"friction", "Friction", "Friction", {}, Shown::page};
  std::vector<Plot> plots;
  for (std::size_t j = 0; j < evidence.joints() && predicted(evidence.result); ++j) {
    const StackedRows rows = stacked_rows(evidence.fitted(), j);
    if (!parameters(evidence.robot.joints[j].friction).empty() && rows.velocity.size() > 0) {
      plots.emplace_back(friction_chart(evidence, j, rows));
    }
  }
  if (plots.empty()) {
    return out;
  }
  out.blocks = {
      {Sentence{"Friction torque over joint speed. Points are rows of the fit: measured torque less the "
                "gravity, inertia and Coriolis torques of the model. The line is the friction law with its "
                "95 % confidence band. Points off the line indicate another friction law; two clouds at one "
                "speed indicate friction that depends on load, temperature or position. Friction of the "
                "robot "
                "description is drawn where there is any"}},
      plots_block("panels", std::move(plots))};
  return out;
}

Section coverage_section(const Evidence& evidence) {
  Section out{"coverage", "Coverage", "Range and speed of the motion", {}, Shown::page};
  std::vector<Plot> plots;
  for (std::size_t j = 0; j < evidence.joints(); ++j) {
    plots.emplace_back(coverage_chart(evidence, j));
  }
  out.blocks = {{Sentence{"Rows over position and speed. The model is validated only where there are rows; "
                          "elsewhere it extrapolates. Record motions in empty corners next"}},
                plots_block("panels", std::move(plots))};
  if (predicted(evidence.result)) {
    out.blocks.push_back(
        {Sentence{"Excitation of each parameter: rms of its torque, in the joint that shows it best, over "
                  "the standard deviation of the residual of that joint, on a logarithmic scale. Below 1 a "
                  "parameter is identified by averaging alone"}});
    out.blocks.push_back({excitation_table(evidence)});
  }
  return out;
}

}  // namespace rivid::detail
