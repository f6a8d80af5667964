#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using enum Shown;
using Parameters = std::vector<ParameterEstimate>;

Table iteration_table(const std::vector<IvIteration>& all) {
  return table_of(
      places(all.size()),
      {{{"k", format::count}, [](std::size_t k) { return static_cast<double>(k); }},
       // The residual of Y against the simulated regressor shows whether the assumed loop is the actual one.
       {{"|Y - V chi| / |Y|", format::percent}, [&](std::size_t k) { return all[k].relative_error; }},
       {{"largest step", format::significant(3), "sigma"},
        [&](std::size_t k) {
          return k == 0                            ? Cell("")
                 : all[k].largest_step > most_said ? Cell("> 10⁶ sigma")
                                                   : Cell(all[k].largest_step);
        }},
       {{"sim. to measured q", format::percent},
        [&](std::size_t k) {
          const Vector& q = all[k].to_measured.q;
          return q.size() > 0 ? q.maxCoeff() : std::numeric_limits<double>::quiet_NaN();
        }},
       {{"condition V", format::significant(4)}, [&](std::size_t k) { return all[k].condition_V; }},
       {{"of Q'W", format::significant(4), "", page}, [&](std::size_t k) { return all[k].condition_VW; }},
       {{"remark"}, [&](std::size_t k) { return all[k].safeguard; }}});
}

// The path of each parameter over the iterations, fig. 10 of [RIV], towards its interval.
std::vector<Plot> parameter_paths(const Parameters& parameters, const std::vector<IvIteration>& iterations) {
  std::vector<Plot> out;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ParameterEstimate& p = parameters[i];
    PathPlot path{
        "path-" + std::to_string(i + 1), p.name, with_decimals_of(p.value, p.sigma) + " " + p.unit, "", {}};
    for (const IvIteration& k : iterations) {
      path.steps.push_back(at(k.chi, i));
    }
    if (std::isfinite(p.sigma)) {
      path.interval = p.interval_95;
    }
    path.label = p.name + " from " + number(path.steps.front(), 4) + " to " + number(path.steps.back(), 4) +
                 " " + p.unit;
    out.emplace_back(std::move(path));
  }
  return out;
}

// The loop as it was simulated last, and how far it is from the recorded one.
Table loop_table(const IvHistory& history, const std::vector<JointFit>& joints) {
  const IvIteration& last = history.iterations.back();
  std::vector<Indexed> fields = {
      {{"joint"}, [&](std::size_t j) { return joints[j].name; }},
      {{"design inertia", format::significant(4)}, [&](std::size_t j) { return at(last.J, j); }}};
  for (const Gain& gain : last.gains) {
    fields.push_back(
        {{gain.name, format::significant(4)}, [&](std::size_t j) { return at(gain.values, j); }});
  }
  fields.push_back({{"control signal", format::percent},
                    [&](std::size_t j) { return at(history.loop.control_error, j); }});
  fields.push_back({{"tracking ratio", format::significant(3)},
                    [&](std::size_t j) { return at(history.loop.tracking_ratio, j); }});
  return table_of(places(joints.size()), fields);
}

Chart iteration_chart(const std::string& id, const std::string& title, std::size_t iterations) {
  Chart out{.id = id,
            .title = title,
            .label = title + " by iteration",
            .x_label = "iteration",
            .y_label = "error [%]"};
  out.logarithmic = true;
  out.x_shown = {0.0, static_cast<double>(std::max<std::size_t>(iterations, 2) - 1)};
  return out;
}

template <typename Of>
Vector over_iterations(const std::vector<IvIteration>& all, const Of& of) {
  Vector out(std::ssize(all));
  for (Index k = 0; k < out.size(); ++k) {
    const double value = 100.0 * std::invoke(of, all[static_cast<std::size_t>(k)]);
    out[k] = value > 0.0 ? value : no_value;
  }
  return out;
}

Vector counting(std::size_t count) {
  return Vector::LinSpaced(static_cast<Index>(count), 0.0, static_cast<double>(count) - 1.0);
}

Chart torque_error_chart(const Identification& result, const std::vector<IvIteration>& all) {
  Chart out = iteration_chart("torque-error", "Torque error", all.size());
  out.size = Chart::Size::wide;
  const Vector k = counting(all.size());
  out.series.push_back(
      {"all joints", "all", Series::Kind::line, k, over_iterations(all, &IvIteration::relative_error)});
  for (std::size_t j = 0; j < result.fit.joints.size(); ++j) {
    out.series.push_back({result.fit.joints[j].name, "series-" + std::to_string(j % 8), Series::Kind::line, k,
                          over_iterations(all, [&](const IvIteration& i) {
                            return at(i.joint_error_norm, j) * (i.relative_error / i.error_norm);
                          })});
  }
  return out;
}

std::vector<Plot> motion_error_charts(const Identification& result, const std::vector<IvIteration>& all) {
  struct Order {
    const char* name;
    Vector MotionError::* member;
  };
  constexpr std::array<Order, 3> orders = {
      {{"q", &MotionError::q}, {"q̇", &MotionError::qd}, {"q̈", &MotionError::qdd}}};
  std::vector<Plot> out;
  for (std::size_t j = 0; j < result.fit.joints.size(); ++j) {
    Chart chart = iteration_chart(chart_id("motion-error", j), result.fit.joints[j].name, all.size());
    for (std::size_t o = 0; o < orders.size(); ++o) {
      const std::string style = "series-" + std::to_string(o);
      const auto series = [&](MotionError IvIteration::* from, const std::string& name,
                              const std::string& dashes) {
        chart.series.push_back({name, style + dashes, Series::Kind::line, counting(all.size()),
                                over_iterations(all, [&](const IvIteration& i) {
                                  return at((i.*from).*(orders[o].member), j);
                                })});
      };
      series(&IvIteration::to_measured, orders[o].name, "");
      series(&IvIteration::to_reference, std::string(orders[o].name) + " to reference", " dashed");
    }
    out.emplace_back(std::move(chart));
  }
  return out;
}

}  // namespace

Section iterations_section(const Identification& result, const IvHistory& history) {
  Section out{"iterations", "Iterations", "Iterations"};
  out.blocks = {
      {iteration_table(history.iterations)},
      {Heading{"Torque error"}, page},
      {Sentence{
           "Of the model along the simulated motion, relative to the norm of all torques; the squares of "
           "the joints' shares add up to the square of the whole"},
       page},
      plots_block("", {torque_error_chart(result, history.iterations)}, page),
      {Heading{"Parameters over the iterations"}, page},
      {Sentence{"With the 95 % interval of the result as a band"}, page},
      plots_block("paths", parameter_paths(result.parameters, history.iterations), page),
      {Heading{"Motion errors"}, page},
      {Sentence{"Distance of the simulated motion from the measured one (solid) and from the reference "
                "(dashed), relative to the norm of the latter two"},
       page},
      plots_block("panels", motion_error_charts(result, history.iterations), page),
      {Heading{"The assumed controller"}, page},
      {Sentence{"Design inertias and gains of the last simulation, SI units. Then how far the control signal "
                "of the assumed law is from the recorded one, and how far the simulated positions are from "
                "the measured ones, compared with the reference. Both are small where the assumed loop is "
                "the actual one"},
       page},
      {loop_table(history, result.fit.joints), page}};
  return out;
}

}  // namespace rivid::detail
