#include "report/analysis.hpp"
#include "report/identification/sections.hpp"

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

}  // namespace

Section friction_section(const Evidence& evidence) {
  Section out{"friction", "Friction", "Friction", {}, Shown::page};
  Plots plots{"panels"};
  Plots::Group& all = plots.groups.emplace_back();
  for (std::size_t j = 0; j < evidence.joints() && predicted(evidence.result); ++j) {
    const StackedRows rows = stacked_rows(evidence.fitted(), j);
    if (!parameters(evidence.robot.joints[j].friction).empty() && rows.velocity.size() > 0) {
      all.plots.emplace_back(friction_chart(evidence, j, rows));
    }
  }
  if (all.plots.empty()) {
    return out;
  }
  out.blocks = {
      {Sentence{
          "Friction torque over joint speed. A point is a row of the fit: the measured torque less the "
          "modelled gravity, inertia and Coriolis torques. The line is the friction law with the 95 % "
          "confidence band of its parameters. Points that bend away from the line ask for another law; two "
          "clouds at one speed are friction that depends on load, temperature or position. Friction of the "
          "robot "
          "description is drawn where there is any"}},
      {std::move(plots)}};
  return out;
}

}  // namespace rivid::detail
