#include <algorithm>
#include <cmath>
#include <limits>

#include "report/identification/sections.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// Of many rows those with the least and the largest value of each bucket, so that no peak is lost.
std::vector<Index> extremes(const Vector& values, Index most) {
  const Index rows = values.size();
  if (rows <= most) {
    return every_few(rows, rows);
  }
  std::vector<Index> out;
  const Index buckets = most / 2;
  for (Index b = 0; b < buckets; ++b) {
    const Index first = rows * b / buckets;
    const Index size = rows * (b + 1) / buckets - first;
    Index least = 0;
    Index largest = 0;
    values.segment(first, size).minCoeff(&least);
    values.segment(first, size).maxCoeff(&largest);
    out.push_back(first + std::min(least, largest));
    if (least != largest) {
      out.push_back(first + std::max(least, largest));
    }
  }
  return out;
}

// Rows over time, with a gap in front of each stretch but the first.
struct TimeRows {
  std::vector<Index> rows;  // −1: a gap
  Vector time;

  TimeRows(const StackedRows& from, const std::vector<Index>& wanted) {
    std::vector<double> instants;
    auto begin = from.begins.begin();
    for (const Index row : wanted) {
      bool begins = false;
      while (begin != from.begins.end() && *begin <= row) {
        begins = true;
        ++begin;
      }
      if (begins && !rows.empty()) {
        rows.push_back(-1);
        instants.push_back(0.5 * (instants.back() + from.time[row]));
      }
      rows.push_back(row);
      instants.push_back(from.time[row]);
    }
    time = Eigen::Map<const Vector>(instants.data(), std::ssize(instants));
  }

  [[nodiscard]] Vector of(const Vector& values) const {
    Vector out(time.size());
    for (Index k = 0; k < out.size(); ++k) {
      const Index row = rows[static_cast<std::size_t>(k)];
      out[k] = row < 0 ? no_value : values[row];
    }
    return out;
  }
};

// Torque of one joint over time. Few rows are all there, in double precision.
Chart torque_chart(const Evidence& evidence, std::size_t joint, const StackedRows& rows, Index most,
                   bool exact) {
  const JointFit& fit = evidence.result.fit.joints[joint];
  const TimeRows at(rows, extremes(rows.measured, most));
  using enum Series::Kind;
  Chart out = time_chart(
      "", "Torque of " + fit.name, "Torque of " + fit.name + " over time, measured and predicted",
      "τ [" + fit.unit + "]", {{"measured", "measured", line, at.time, at.of(rows.measured), {}, exact}});
  if (predicted(evidence.result)) {
    out.series.push_back({"predicted", "predicted", line, at.time, at.of(rows.predicted), {}, exact});
  }
  out.series.push_back(
      {"robot description", "apriori", line, at.time, at.of(rows.a_priori), {}, false, true});
  return out;
}

std::string shown_rows(Index rows, Index most) {
  return counted(rows, "row") + " of the fit" +
         (rows > most ? ", of which the least and largest of each of " + std::to_string(most / 2) +
                            " stretches are drawn"
                      : "");
}

// ---------------------------------------------------------------------------------------------- at a glance

// What the first screen says of a joint.
struct JointGlance {
  std::string name;
  double fit = no_value;
  double validation = no_value;
  TorqueShares shares = {};
};

std::vector<JointGlance> glances(const Evidence& evidence) {
  std::vector<JointGlance> out;
  for (std::size_t j = 0; j < evidence.joints(); ++j) {
    const JointFit& fit = evidence.result.fit.joints[j];
    out.push_back({fit.name, fit.relative_error, no_value, torque_shares(evidence.logs, j)});
    if (!evidence.validation().empty() && predicted(evidence.result)) {
      out.back().validation = relative_error(stacked_rows(evidence.validation(), j));
    }
  }
  return out;
}

Cell cause_bar(const JointGlance& joint) {
  const TorqueShares& s = joint.shares;
  if (!std::isfinite(s.gravity)) {
    return "";
  }
  const auto part = [](const std::string& cause, double share) {
    return cause + " " + fixed(100.0 * share, 0) + " %";
  };
  return Stack{
      {{"gravity", s.gravity}, {"inertia", s.inertia}, {"coriolis", s.coriolis}, {"friction", s.friction}},
      part("gravity", s.gravity) + ", " + part("inertia", s.inertia) + ", " + part("Coriolis", s.coriolis) +
          ", " + part("friction", s.friction)};
}

Table glance_table(const Evidence& evidence) {
  const std::vector<JointGlance> joints = glances(evidence);
  double largest = 0.0;
  for (const JointGlance& joint : joints) {
    for (const double error : {joint.fit, joint.validation}) {
      largest = std::isfinite(error) ? std::max(largest, error) : largest;
    }
  }
  const auto bar = [=](double error, const std::string& style, const std::string& words) -> Cell {
    return std::isfinite(error) && largest > 0.0
               ? Cell(Stack{{{style, error / largest}}, words + " " + percent(error)})
               : Cell("");
  };
  using J = JointGlance;
  std::vector<ColumnOf<J>> columns = {
      {{"joint", format::name}, &J::name},
      {{"fit error", format::percents(2)}, &J::fit},
      {{"", format::stack}, [=](const J& j) { return bar(j.fit, "fit", "error of the fit"); }}};
  if (!evidence.validation().empty()) {
    columns.push_back({{"validation", format::percents(2)}, &J::validation});
    columns.push_back({{"", format::stack}, [=](const J& j) {
                         return bar(j.validation, "validation", "error of the validation");
                       }});
  }
  columns.push_back({{"torque by cause", format::stack}, cause_bar});
  return table_of(joints, columns);
}

// ---------------------------------------------------------------------------------------------- log by log

Chart residual_chart(const JointFit& fit, const StackedRows& rows, Index most) {
  const TimeRows at(rows, extremes(rows.residual, most));
  Chart out = time_chart("", "Residual of " + fit.name, "Residual of " + fit.name + " over time",
                         "[" + fit.unit + "]",
                         {{"residual", "residual", Series::Kind::line, at.time, at.of(rows.residual)}});
  out.height = 150.0;
  return out;
}

// Torque and residual of each joint that has rows in a log.
Plots torque_plots(const Evidence& evidence, std::size_t log, Index most_rows) {
  const std::size_t zoom = log + 1;  // 0 is that of the first look
  Plots out;
  for (std::size_t j = 0; j < evidence.joints(); ++j) {
    const JointFit& fit = evidence.result.fit.joints[j];
    const StackedRows rows = stacked_rows(evidence.logs.subspan(log, 1), j);
    if (rows.measured.size() == 0) {
      continue;
    }
    Plots::Group& group =
        out.groups.emplace_back(Plots::Group{fit.name, shown_rows(rows.measured.size(), most_rows)});
    const auto add = [&](Chart chart, const std::string& kind) {
      chart.id = chart_id(kind, j, log);
      chart.log = zoom;
      group.plots.emplace_back(std::move(chart));
    };
    add(torque_chart(evidence, j, rows, most_rows, false), "torque");
    if (predicted(evidence.result)) {
      add(residual_chart(fit, rows, most_rows), "residual");
    }
  }
  return out;
}

}  // namespace

std::size_t worst_joint(const Fit& fit) {
  const auto error = [](const JointFit& joint) {
    return std::isfinite(joint.relative_error) && joint.rows > 0 ? joint.relative_error : -1.0;
  };
  return static_cast<std::size_t>(std::ranges::max_element(fit.joints, {}, error) - fit.joints.begin());
}

std::vector<Block> first_look(const Evidence& evidence) {
  // Of so many rows all are there, and in double precision: the error of what is drawn is that of the table.
  constexpr Index most_rows = 12'000;
  const std::size_t worst = worst_joint(evidence.result.answer_fit());
  const JointFit& fit = evidence.result.answer_fit().joints[worst];
  const StackedRows rows = stacked_rows(evidence.fitted(), worst);
  Chart chart = torque_chart(evidence, worst, rows, most_rows, true);
  chart.id = "worst-joint";
  chart.height = 300.0;
  chart.log = 0;
  chart.remark = predicted(evidence.result)
                     ? "the joint with the largest error, " + percent(fit.relative_error) + ", on the " +
                           shown_rows(rows.measured.size(), most_rows)
                     : shown_rows(rows.measured.size(), most_rows);
  std::vector<std::pair<std::string, std::string>> keys = {{"fit", "rows of the fit"},
                                                           {"gravity", "gravity"},
                                                           {"inertia", "inertia"},
                                                           {"coriolis", "Coriolis"},
                                                           {"friction", "friction"}};
  if (!evidence.validation().empty()) {
    keys.insert(keys.begin() + 1, {"validation", "validation"});
  }
  return {plots_block("hero", {std::move(chart)}, Shown::page),
          {glance_table(evidence), Shown::page},
          {Legend{std::move(keys),
                  "Errors: rms of measured less predicted torque over rms of the measured torque. Causes: "
                  "shares of the mean absolute torque."},
           Shown::page}};
}

Section torques_section(const Evidence& evidence) {
  Section out{"torques", "Torques", "Torques", {}, Shown::page};
  out.blocks.push_back(
      {Sentence{"Measured and predicted torque of the rows of the fit, and the residual below. A residual "
                "with the rhythm of the motion means that the model is incomplete. Gaps are rows that the "
                "fit leaves out: too slow, or near a reversal. Drag to zoom, double-click to see all; all "
                "plots of a log show the same time"}});
  const auto logs = static_cast<Index>(evidence.logs.size());
  const Index most_rows = std::max<Index>(2400 / std::max<Index>(logs, 1), 800);
  for (std::size_t k = 0; k < evidence.logs.size(); ++k) {
    const Prediction& log = evidence.logs[k];
    Plots plots = torque_plots(evidence, k, most_rows);
    plots.fold.title = (log.validation ? "Validation: " : "Identification: ") + log.source;
    out.blocks.push_back({std::move(plots)});
  }
  return out;
}

}  // namespace rivid::detail
