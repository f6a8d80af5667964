#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "report/analysis.hpp"
#include "report/identification/sections.hpp"
#include "report/lists.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

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
  constexpr std::size_t few = 16;
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

Section coverage_section(const Evidence& evidence) {
  Section out{"coverage", "Coverage", "Coverage and excitation", {}, Shown::page};
  Plots plots{"panels"};
  Plots::Group& all = plots.groups.emplace_back();
  for (std::size_t j = 0; j < evidence.joints(); ++j) {
    all.plots.emplace_back(coverage_chart(evidence, j));
  }
  out.blocks = {
      {Sentence{
          "Rows in the plane of position and speed. The model is known where the dots are: a validation or a "
          "task that leaves the cloud is extrapolation. Empty corners are motions to record next"}},
      {std::move(plots)}};
  if (predicted(evidence.result)) {
    out.blocks.push_back(
        {Sentence{"Excitation of each parameter: root mean square of the torque that it causes in the joint "
                  "that shows it best, divided by the deviation of that joint's residual, on a "
                  "logarithmic scale. Below 1 a parameter is seen by averaging alone"}});
    out.blocks.push_back({excitation_table(evidence)});
  }
  return out;
}

}  // namespace rivid::detail
