#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>
#include <string_view>

#include "normal_quantile.hpp"
#include "report/documents.hpp"
#include "rivid/report/comparison.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

Table error_table(const Comparison& comparison) {
  const std::size_t joints = comparison.joints.size();
  const auto error = [joints](const Comparison::Error& model, std::size_t j) {
    return j < joints ? model.joints[j] : model.relative_error;
  };
  double largest = 0.0;
  std::vector<ColumnOf<std::size_t>> columns = {{{"joint", format::name}, [&](std::size_t j) {
                                                   return Cell(j < joints ? comparison.joints[j] : "all");
                                                 }}};
  for (const Comparison::Error& model : comparison.models) {
    largest = std::max({largest, model.relative_error, std::ranges::max(model.joints)});
    columns.push_back(
        {{model.name, format::percents(2)}, [&](std::size_t j) { return Cell(error(model, j)); }});
    columns.push_back({{"", format::stack, "", Shown::page}, [&](std::size_t j) {
                         const double share = largest > 0.0 ? error(model, j) / largest : 0.0;
                         return Cell(Stack{{{"fit", share}}, percent(error(model, j))});
                       }});
  }
  std::vector<std::size_t> rows(joints + 1);
  std::iota(rows.begin(), rows.end(), 0U);
  return table_of(rows, columns, [=](std::size_t j) { return j < joints ? Mark::none : Mark::sum; });
}

std::string p_text(double p) {
  return std::isfinite(p) ? (p < 1e-4 ? "p < 0.0001" : "p = " + number(p, 2)) : "no p";
}

// "A predicts better than B (p = 0.001, 12 blocks): its squared error is 0.61 times that of B"
std::string test_sentence(const Comparison& comparison, const PairedTest& test) {
  const std::string& a = comparison.models[test.a].name;
  const std::string& b = comparison.models[test.b].name;
  if (!std::isfinite(test.p)) {
    return a + " and " + b + ": not decided, the logs are too short for six blocks of independent errors";
  }
  const std::string basis = " (" + p_text(test.p) + ", " + counted(test.blocks, "block") + ")";
  if (!test.better) {
    return a + " and " + b + ": no significant difference" + basis + ", the squared error of " + a + " is " +
           number(test.ratio, 3) + " times that of " + b;
  }
  const bool first = *test.better == test.a;
  return (first ? a : b) + " predicts better than " + (first ? b : a) + basis + ": its squared error is " +
         number(first ? test.ratio : 1.0 / test.ratio, 3) + " times that of " + (first ? b : a);
}

Section traces_section(const Comparison& comparison) {
  Section out{.id = "errors",
              .title = "Torque errors",
              .heading = "Torque error of " + comparison.traces.front().joint,
              .blocks = {{Sentence{"Measured less predicted torque, of the joint with the largest error of "
                                   "the first model. Gaps are rows near reversals and at rest"}}},
              .shown = Shown::page};
  std::vector<std::string> names;
  std::ranges::transform(comparison.models, std::back_inserter(names), &Comparison::Error::name);
  std::vector<Plot> plots;
  for (const Comparison::Trace& trace : comparison.traces) {
    plots.emplace_back(time_chart("errors-" + std::to_string(plots.size()), trace.log,
                                  "Torque errors of " + trace.joint + " over time", "torque error [N·m or N]",
                                  curves(trace.time, names, trace.errors)));
  }
  out.blocks.push_back(plots_block("", std::move(plots)));
  return out;
}

std::string seconds(std::span<const double> horizons) {
  std::vector<std::string> out;
  for (const double horizon : horizons) {
    out.push_back(number(horizon, 3) + " s");
  }
  return listed(out);
}

constexpr std::string_view loop_of(Drive drive) {
  return drive == Drive::torques ? "open loop" : "closed loop";
}

// "closed loop: A moves more like the robot than B after 0.1 s and 1 s (p < 0.0001); no significant
// difference after 3 s"
std::string rollout_sentence(const Rollouts& all, Drive drive, std::size_t other) {
  std::vector<double> first_better;
  std::vector<double> other_better;
  std::vector<double> open;
  std::vector<double> few;
  double p = 0.0;
  for (const Rollout& one : all.found) {
    if (one.drive == drive) {
      const PairedTest& test = one.tests[other - 1];
      const bool decided = test.better.has_value();
      (std::isnan(test.p)       ? few
       : !decided               ? open
       : *test.better == test.a ? first_better
                                : other_better)
          .push_back(one.horizon);
      p = decided ? std::max(p, test.p) : p;
    }
  }
  const std::string& a = all.models.front();
  const std::string& b = all.models[other];
  std::string out;
  const auto add = [&](const std::string& text) { out += (out.empty() ? "" : "; ") + text; };
  const auto better = [&](const std::string& x, const std::string& y, const std::vector<double>& at) {
    add(x + " moves more like the robot than " + y + " after " + seconds(at) + " (" + p_text(p) + ")");
  };
  if (!first_better.empty()) {
    better(a, b, first_better);
  }
  if (!other_better.empty()) {
    better(b, a, other_better);
  }
  if (!open.empty()) {
    add((first_better.empty() ? a + " does not beat " + b + ": " : "") + "no significant difference after " +
        seconds(open));
  }
  if (!few.empty()) {
    add("too few windows to decide after " + seconds(few));
  }
  return std::string(loop_of(drive)) + ": " + out;
}

// Error over the horizon, a chart for each loop and joint.
Plots rollout_plots(const Rollouts& all, const std::vector<std::string>& joints) {
  Plots out{.layout = "panels"};
  for (const Drive drive : {Drive::torques, Drive::controller}) {
    std::vector<const Rollout*> found;
    for (const Rollout& one : all.found) {
      if (one.drive == drive) {
        found.push_back(&one);
      }
    }
    for (std::size_t j = 0; j < joints.size() && !found.empty(); ++j) {
      Vector horizons(std::ssize(found));
      Matrix errors(std::ssize(found), std::ssize(all.models));
      for (Index k = 0; k < horizons.size(); ++k) {
        const Rollout& one = *found[static_cast<std::size_t>(k)];
        horizons[k] = one.horizon;
        for (Index m = 0; m < errors.cols(); ++m) {
          const Vector& q = one.models[static_cast<std::size_t>(m)].q;
          errors(k, m) = q.size() > 0 ? q[static_cast<Index>(j)] : std::numeric_limits<double>::quiet_NaN();
        }
      }
      out.groups.resize(1);
      out.groups.front().plots.emplace_back(
          Chart{.id = "rollout-" + std::to_string(out.groups.front().plots.size()),
                .title = joints[j] + ", " + std::string(loop_of(drive)),
                .label = "Position error of " + joints[j] + " over the horizon",
                .x_label = "horizon [s]",
                .y_label = "rms error [rad | m]",
                .series = curves(horizons, all.models, errors),
                .logarithmic = true});
    }
  }
  return out;
}

Section rollouts_section(const Rollouts& all, const std::vector<std::string>& joints) {
  Section out{.id = "rollouts", .title = "Rollouts", .heading = "Which model moves like the robot"};
  for (const Drive drive : {Drive::torques, Drive::controller}) {
    const bool any = std::ranges::any_of(all.found, [&](const Rollout& one) { return one.drive == drive; });
    for (std::size_t m = 1; m < all.models.size() && any; ++m) {
      out.blocks.push_back({Sentence{rollout_sentence(all, drive, m)}});
    }
  }
  for (const std::string& note : all.notes) {
    out.blocks.push_back({Sentence{note}});
  }
  out.blocks.push_back({Sentence{"rms position errors of all joints together, in rad or m"}});
  std::vector<ColumnOf<Rollout>> columns = {
      {{"loop", format::name}, [](const Rollout& one) { return Cell(std::string(loop_of(one.drive))); }},
      {{"after", format::significant(3), "s"}, &Rollout::horizon},
      {{"windows", format::count}, [](const Rollout& one) { return Cell(one.windows); }}};
  for (std::size_t m = 0; m < all.models.size(); ++m) {
    columns.push_back({{all.models[m], format::significant(3)},
                       [m](const Rollout& one) { return Cell(one.models[m].q.norm()); }});
    if (std::ranges::any_of(all.found, [&](const Rollout& one) { return one.models[m].lost > 0; })) {
      columns.push_back(
          {{"lost", format::count}, [m](const Rollout& one) { return Cell(one.models[m].lost); }});
    }
  }
  out.blocks.push_back({table_of(all.found, columns)});
  out.blocks.push_back({rollout_plots(all, joints), Shown::page});
  return out;
}

// Two results side by side: every parameter by its difference.
DotPlot changes_plot(const ResultChanges& pair, std::size_t number, double level) {
  DotPlot out{.id = "differences-" + std::to_string(number),
              .title = "Differences",
              .remark = pair.b + " less " + pair.a + ", with 95 % confidence intervals",
              .label = "Difference of each parameter in standard deviations",
              .x_label = "difference / σ",
              .wanted = {-normal_quantile_975, normal_quantile_975}};
  for (const ParameterChange& change : pair.parameters) {
    out.dots.push_back({change.name,
                        {change.z - normal_quantile_975, change.z + normal_quantile_975, change.z},
                        change.p < level ? Mark::bad : Mark::none});
  }
  return out;
}

Section changes_section(const ResultChanges& pair, std::size_t number, double level) {
  Section out{.id = "changes-" + std::to_string(number),
              .title = "Changes",
              .heading = "From " + pair.a + " to " + pair.b};
  using C = ParameterChange;
  const Table all = table_of(pair.parameters,
                             {{{"parameter", format::name}, &C::name},
                              {{pair.a, format::deviation}, [](const C& c) { return Cell(c.a, c.sigma); }},
                              {{pair.b, format::deviation}, [](const C& c) { return Cell(c.b, c.sigma); }},
                              {{"unit"}, &C::unit},
                              {{"difference/σ", format::fixed(1)}, &C::z},
                              {{"p", format::significant(2)}, &C::p}},
                             [=](const C& c) { return c.p < level ? Mark::apart : Mark::none; });
  Table changed = all;
  std::erase_if(changed.rows, [](const Row& row) { return row.mark == Mark::none; });
  const auto count = std::ssize(changed.rows);
  out.blocks.push_back(
      {Sentence{(count > 0 ? counted(count, "parameter") + " of " + std::to_string(all.rows.size())
                           : "none of " + counted(std::ssize(all.rows), "parameter")) +
                " changed by more than the standard deviations of both results explain"}});
  if (count > 0) {
    out.blocks.push_back({std::move(changed), Shown::screen});
  }
  out.blocks.push_back({all, Shown::page});
  out.blocks.push_back(plots_block("panels", {changes_plot(pair, number, level)}, Shown::page));
  return out;
}

Document comparison_document(const Comparison& comparison, std::span<const ResultChanges> changes,
                             std::span<const Finding> warnings, double level) {
  Document out;
  const std::string logs = quoted_list(comparison.logs);
  out.title = "Comparison of models";
  out.heading = out.title;
  out.subtitle = "on " + logs + ", " + counted(comparison.rows, "row");
  out.headline = "Relative torque error";
  out.line = out.headline + " " + out.subtitle;
  out.opening.push_back({FindingList{{warnings.begin(), warnings.end()}}});
  out.opening.push_back({error_table(comparison)});
  if (!comparison.tests.empty()) {
    Section tests{.id = "tests", .title = "Tests", .heading = "Which model predicts better"};
    for (const PairedTest& test : comparison.tests) {
      tests.blocks.push_back({Sentence{test_sentence(comparison, test)}});
    }
    out.sections.push_back(std::move(tests));
  }
  if (comparison.rollouts) {
    out.sections.push_back(rollouts_section(*comparison.rollouts, comparison.joints));
  }
  out.sections.push_back(traces_section(comparison));
  for (std::size_t k = 0; k < changes.size(); ++k) {
    out.sections.push_back(changes_section(changes[k], k + 1, level));
  }
  return out;
}

}  // namespace

}  // namespace rivid::detail

namespace rivid {

std::string in_words(const Comparison& comparison, std::span<const ResultChanges> changes,
                     std::span<const Finding> warnings, double level, std::size_t screen) {
  return detail::text_of(detail::comparison_document(comparison, changes, warnings, level), screen);
}

std::string html_report(const Comparison& comparison, std::span<const ResultChanges> changes,
                        std::span<const Finding> warnings, double level, const Provenance& provenance) {
  detail::Document document = detail::comparison_document(comparison, changes, warnings, level);
  document.sections.push_back({.id = "origin",
                               .title = "Origin",
                               .heading = "Files",
                               .blocks = {{detail::inputs_table(provenance)}}});
  return detail::html_of(document);
}

}  // namespace rivid
