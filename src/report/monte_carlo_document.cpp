#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "report/documents.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using enum Shown;
using Parameter = MonteCarloParameter;

std::string share(double fraction) { return shown({{}, format::percents(1)}, fraction); }

// The parameter with the largest value of a figure; nothing where no value is a number.
template <typename Figure>
const Parameter* worst(const MonteCarloSummary& summary, Figure figure) {
  const Parameter* out = nullptr;
  for (const Parameter& p : summary.parameters) {
    const double value = std::invoke(figure, p);
    if (std::isfinite(value) && (out == nullptr || value > std::invoke(figure, *out))) {
      out = &p;
    }
  }
  return out;
}

const Parameter* most_biased(const MonteCarloSummary& summary) {
  return worst(summary, [](const Parameter& p) { return std::abs(p.bias_in_spreads); });
}

const Parameter* least_covered(const MonteCarloSummary& summary) {
  return worst(summary, [](const Parameter& p) { return -p.coverage; });
}

const Parameter* least_precise(const MonteCarloSummary& summary) {
  return worst(summary, &Parameter::rmse_over_bound);
}

double mean_rmse(const MonteCarloSummary& summary) {
  double out = 0.0;
  for (const Parameter& p : summary.parameters) {
    out += p.rmse_over_bound / static_cast<double>(summary.parameters.size());
  }
  return out;
}

// Enough runs for their figures to say something.
bool judged(const MonteCarloSummary& summary) {
  return summary.identified >= 2 && most_biased(summary) != nullptr;
}

Mark trial_mark(const MonteCarloSummary& summary) {
  return summary.verdict.unbiased && summary.verdict.honest ? Mark::good : Mark::bad;
}

std::string trial_words(const MonteCarloSummary& s) {
  if (!judged(s)) {
    return "too few runs are identified to say anything";
  }
  const Parameter& bias = *most_biased(s);
  std::string out = std::string(s.verdict.unbiased ? "unbiased" : "biased") + " (at most " +
                    fixed(std::abs(bias.bias_in_spreads), 2) + " deviations, " + bias.name + "); ";
  const Parameter& coverage = *least_covered(s);
  out += "intervals are " + std::string(s.verdict.honest ? "honest" : "not honest") + " (" +
         share(s.mean_coverage) + " of the 95 % intervals hold the truth, of " + coverage.name + " " +
         share(coverage.coverage) + ")";
  if (s.verdict.efficient) {
    const Parameter& rmse = *least_precise(s);
    out += "; " + std::string(*s.verdict.efficient ? "efficient" : "not efficient") + " (errors are " +
           fixed(mean_rmse(s), 2) + " times their bound on average, of " + rmse.name + " " +
           fixed(rmse.rmse_over_bound, 2) + " times)";
  }
  return out;
}

std::string criteria() {
  using V = MonteCarloVerdict;
  return "Unbiased: no bias above " + number(V::largest_bias) +
         " standard deviations of the estimates. Honest: " + number(100.0 * V::mean_coverage[0]) + " to " +
         number(100.0 * V::mean_coverage[1]) + " % of the 95 % intervals hold the truth on average, and " +
         number(100.0 * V::least_coverage) +
         " % or more for each parameter. Efficient: no root mean square error above " +
         number(V::largest_rmse) +
         " times that of weighted least squares on regressors without noise. A figure counts only where the "
         "whole interval that so many runs leave open is beyond that";
}

// ---------------------------------------------------------------------------------------------- tables

Section comparison(std::span<const MonteCarloSummary> summaries) {
  using S = MonteCarloSummary;
  const auto if_judged = [](auto figure) {
    return [=](const S& s) { return judged(s) ? Cell(std::invoke(figure, s)) : Cell("-"); };
  };
  const auto if_bound = [](auto figure) {
    return [=](const S& s) { return s.verdict.efficient ? Cell(std::invoke(figure, s)) : Cell("-"); };
  };
  Section out{"ways", "Ways to identify", "Ways to identify"};
  out.blocks = {
      {table_of(
          summaries,
          {{{"", format::name}, &S::label},
           {{"identified"},
            [](const S& s) { return std::to_string(s.identified) + " of " + std::to_string(s.runs); }},
           {{"iterations", format::fixed(1)},
            [](const S& s) { return s.most_iterations > 0 ? Cell(s.mean_iterations) : Cell(""); }},
           {{"largest bias", format::fixed(2)},
            if_judged([](const S& s) { return std::abs(most_biased(s)->bias_in_spreads); })},
           {{"mean coverage", format::percents(1)}, if_judged(&S::mean_coverage)},
           {{"least", format::percents(1)}, if_judged([](const S& s) { return least_covered(s)->coverage; })},
           {{"mean RMSE / bound", format::fixed(2)}, if_bound(mean_rmse)},
           {{"largest", format::fixed(2)},
            if_bound([](const S& s) { return least_precise(s)->rmse_over_bound; })}})},
      {Sentence{criteria()}},
      {Legend{{{"dot", "a parameter, with the 95 % interval that so many runs leave open"},
               {"off", "beyond what is wanted, by more than that"},
               {"reference", "what it should be"},
               {"left-out", "what counts as good enough"}}}}};
  return out;
}

// One line a column.
Table all_figures(const MonteCarloSummary& summary) {
  Table out = table_of(summary.parameters,
                       {{{"parameter", format::name}, &Parameter::name},
                        {{"truth", format::significant(4)}, &Parameter::truth},
                        {{"unit"}, &Parameter::unit},
                        {{"bias", format::significant(4)}, &Parameter::bias},
                        {{"bias/spread", format::fixed(2)}, &Parameter::bias_in_spreads},
                        {{"spread", format::significant(4), "", page}, &Parameter::spread},
                        {{"RMSE/bound", format::fixed(2)}, &Parameter::rmse_over_bound},
                        {{"sigma/spread", format::fixed(2)}, &Parameter::sigma_over_spread},
                        {{"coverage", format::percents(1)}, &Parameter::coverage},
                        {{"its 95 % interval", format::text, "", page}, [](const Parameter& p) {
                           return "[" + share(p.coverage_95[0]) + ", " + share(p.coverage_95[1]) + "]";
                         }}});
  out.rows.push_back({{"mean", "", "", "", "", "", "", "", summary.mean_coverage, ""}, Mark::sum});
  out.fold = {"All figures"};
  return out;
}

// Why runs are not identified, the most frequent reason first.
List other_outcomes(const MonteCarloSummary& summary) {
  std::vector<std::pair<std::string, int>> outcomes(summary.outcomes.begin(), summary.outcomes.end());
  std::ranges::stable_sort(outcomes, std::greater(), &std::pair<std::string, int>::second);
  List out{"reasons"};
  for (const auto& [outcome, runs] : outcomes) {
    std::string why = outcome == "not_simulated" ? "the experiment itself could not be simulated"
                      : outcome == "refused"     ? "the log could not be used"
                                                 : "";
    for (int k = 0; k <= static_cast<int>(Status::gave_up); ++k) {
      if (outcome == name(static_cast<Status>(k))) {
        why = why_not(static_cast<Status>(k));
      }
    }
    if (outcome != name(Status::identified)) {
      out.items.push_back({.text = counted(runs, "run") + " " + outcome + ": " + why});
    }
  }
  return out;
}

// ---------------------------------------------------------------------------------------------- plots

double normal_density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi); }

double normal_distribution(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// @param way  begin of the plots' identifiers
std::vector<Plot> figure_plots(const MonteCarloSummary& summary, const std::string& way) {
  using V = MonteCarloVerdict;
  // With a dot for each parameter, which is bad where all of its interval is beyond what is wanted.
  const auto filled = [&](DotPlot plot, double unit, double Parameter::* value,
                          std::array<double, 2> Parameter::* interval_95) -> Plot {
    plot.id = way + plot.id;
    plot.label = plot.title;
    for (const Parameter& p : summary.parameters) {
      const auto& [low, high] = p.*interval_95;
      const Interval interval{unit * low, unit * high, unit * p.*value};
      const bool off = interval.low > plot.wanted[1] || interval.high < plot.wanted[0];
      plot.dots.push_back({p.name, interval, off ? Mark::bad : Mark::none});
    }
    return plot;
  };
  std::vector<Plot> out = {filled({"-bias",
                                   "Bias",
                                   "mean error in deviations of the estimate; should be 0",
                                   "",
                                   "bias / spread",
                                   0.0,
                                   {-V::largest_bias, V::largest_bias}},
                                  1.0, &Parameter::bias_in_spreads, &Parameter::bias_in_spreads_95),
                           filled({"-coverage",
                                   "Coverage",
                                   "share of 95 % intervals that hold the truth; should be 95 %",
                                   "",
                                   "coverage [%]",
                                   95.0,
                                   {100.0 * V::least_coverage, 100.0}},
                                  100.0, &Parameter::coverage, &Parameter::coverage_95)};
  if (summary.verdict.efficient) {
    out.push_back(
        filled({"-precision",
                "Precision",
                "root mean square error over the bound that no method can beat by much; should be 1",
                "",
                "RMSE / bound",
                1.0,
                {0.0, V::largest_rmse}},
               1.0, &Parameter::rmse_over_bound, &Parameter::rmse_over_bound_95));
  }
  return out;
}

std::vector<double> together(const std::vector<std::vector<double>>& errors) {
  std::vector<double> out;
  for (const std::vector<double>& list : errors) {
    out.insert(out.end(), list.begin(), list.end());
  }
  return out;
}

// All errors together beside the standard normal distribution.
Chart error_histogram(const std::vector<double>& errors, const std::string& way) {
  constexpr double reach = 4.0;  // σ to either side; a normal error goes beyond once in 16 000
  constexpr double bin = 0.25;   // σ; a choice of drawing
  constexpr auto bins = static_cast<Index>(2.0 * reach / bin);
  Chart out{.id = way + "-errors",
            .title = "Distribution",
            .remark = "of the errors of all parameters, beside the standard normal one",
            .label = "Histogram of the errors of all parameters",
            .x_label = "(estimate − truth) / σ",
            .y_label = "density"};
  out.x_shown = {-reach, reach};
  Vector density = Vector::Zero(bins);
  std::ptrdiff_t outside = 0;
  for (const double error : errors) {
    const double place = std::floor((error + reach) / bin);
    if (place >= 0.0 && place < static_cast<double>(bins)) {
      density[static_cast<Index>(place)] += 1.0 / (bin * static_cast<double>(errors.size()));
    } else {
      ++outside;
    }
  }
  const Vector x = Vector::LinSpaced(2 * bins + 1, -reach, reach);
  out.series = {{"errors", "measured", Series::Kind::bars,
                 Vector::LinSpaced(bins, -reach + 0.5 * bin, reach - 0.5 * bin), std::move(density)},
                {"normal distribution", "predicted", Series::Kind::line, x, x.unaryExpr(&normal_density)}};
  out.remark += outside > 0 ? "; " + counted(outside, "error") + " beyond four σ" : "";
  return out;
}

// Quantiles of a sample at the probabilities of normal ones, as far as it reaches.
Series quantiles(const std::string& name, const std::string& style, std::vector<double> sample) {
  constexpr Index steps = 14;    // to either side
  constexpr double step = 0.25;  // σ from point to point: they reach to 3.5
  std::ranges::sort(sample);
  Series out{
      .name = name, .style = style, .x = Vector::LinSpaced(2 * steps + 1, -step * steps, step * steps)};
  out.y = out.x.unaryExpr([&](double x) {
    const double at = normal_distribution(x) * static_cast<double>(sample.size()) - 0.5;
    const double below = std::floor(at);
    if (!(below >= 0.0 && below + 1.0 < static_cast<double>(sample.size()))) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    const auto i = static_cast<std::size_t>(below);
    return sample[i] + (at - below) * (sample[i + 1] - sample[i]);
  });
  return out;
}

// Quantiles of the errors over those of the normal distribution, a line for each parameter and one for all.
Chart quantile_plot(const MonteCarloSummary& summary, const std::vector<std::vector<double>>& errors,
                    const std::string& way) {
  Chart out{.id = way + "-quantiles",
            .title = "Quantiles",
            .remark = "of the errors in σ: a thin line for each parameter, a thick one for all",
            .label = "Quantiles of the errors over those of the normal distribution",
            .x_label = "quantile of the normal distribution",
            .y_label = "quantile of the errors"};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    out.series.push_back(quantiles(summary.parameters[i].name, "one", errors[i]));
    out.series.back().in_legend = false;
  }
  out.series.push_back(quantiles("all", "all", together(errors)));
  const Vector& x = out.series.back().x;
  out.series.push_back({"normal distribution", "reference", Series::Kind::line, x, x});
  return out;
}

// ---------------------------------------------------------------------------------------------- sections

std::string run_words(const MonteCarloSummary& summary) {
  std::string out =
      std::to_string(summary.identified) + " of " + counted(summary.runs, "run") + " identified";
  if (summary.most_iterations > 0) {
    out += ", in " + fixed(summary.mean_iterations, 1) + " iterations on average, " +
           std::to_string(summary.most_iterations) + " at most";
  }
  return out;
}

Section trial_section(const MonteCarloSummary& summary, std::span<const MonteCarloRow> rows, std::size_t k) {
  const std::string way = "way-" + std::to_string(k + 1);
  Section out{way, summary.label, summary.label};
  out.blocks = {{Sentence{run_words(summary)}}, {other_outcomes(summary)}};
  if (judged(summary)) {
    const auto errors = standardised_errors(summary, rows);
    out.blocks.push_back(plots_block("panels", figure_plots(summary, way)));
    out.blocks.push_back(
        plots_block("panels", {error_histogram(together(errors), way), quantile_plot(summary, errors, way)}));
    out.blocks.push_back({all_figures(summary)});
  }
  return out;
}

Section plan_section(const MonteCarlo& plan, const Provenance& provenance) {
  const Robot& robot = plan.experiment.robot;
  const Settings settings = {{"Robot", robot.name + ", " + counted(robot.size(), "joint")},
                             {"Runs", std::to_string(plan.runs) + "; run k, counted from 0, has the seed " +
                                          std::to_string(plan.seed) + " + k"}};
  Table trials{{{"", format::name}, {"Method"}}};
  for (const MonteCarlo::Trial& trial : plan.trials) {
    const Estimation& estimation = trial.experiment.estimation;
    Row& row = trials.rows.emplace_back(Row{{trial.label, std::string(name(estimation.method))}});
    for (const auto& [what, value] : row_settings(estimation.signal)) {
      if (trials.rows.size() == 1) {
        trials.columns.push_back({what});
      }
      row.cells.emplace_back(value);
    }
  }
  return {"provenance",
          "Provenance",
          "Provenance",
          {{run_table(provenance, settings)}, {std::move(trials)}, {inputs_table(provenance)}}};
}

}  // namespace

std::vector<std::vector<double>> standardised_errors(const MonteCarloSummary& summary,
                                                     std::span<const MonteCarloRow> rows) {
  std::vector<std::vector<double>> out(summary.parameters.size());
  for (const MonteCarloRow& row : rows) {
    if (row.label == summary.label && row.status == name(Status::identified)) {
      for (std::size_t i = 0; i < out.size(); ++i) {
        const auto at = static_cast<Index>(i);
        out[i].push_back((row.value[at] - summary.parameters[i].truth) / row.sigma[at]);
      }
    }
  }
  return out;
}

Document document_of(const MonteCarloSummary& summary) {
  Document out;
  out.line = summary.label + ": " + run_words(summary) + ", " + number(summary.mean_seconds, 2) + " s each";
  out.sections = {{"", "", summary.label, {{all_figures(summary)}}}};
  return out;
}

Document document_of(const MonteCarlo& plan, std::span<const MonteCarloSummary> summaries,
                     std::span<const MonteCarloRow> rows, const Provenance& provenance) {
  const std::ptrdiff_t passed = std::ranges::count(summaries, Mark::good, trial_mark);
  const auto trials = std::ssize(summaries);
  Document out;
  out.heading = plan.experiment.robot.name;
  out.title = out.heading + " · Monte Carlo";
  out.subtitle = "Monte Carlo" + (provenance.inputs.empty() ? "" : " · " + provenance.inputs.front().path);
  out.verdict = passed == trials ? Mark::good : passed > 0 ? Mark::mixed : Mark::bad;
  out.headline = passed == trials ? "Unbiased, and intervals mean what they say"
                                  : std::to_string(passed) + " of " + counted(trials, "way") +
                                        " to identify can be trusted";
  List verdicts{"trials"};
  out.sections.push_back(comparison(summaries));
  for (std::size_t k = 0; k < summaries.size(); ++k) {
    const MonteCarloSummary& s = summaries[k];
    verdicts.items.push_back({s.label, ": " + trial_words(s), trial_mark(s)});
    out.sections.push_back(trial_section(s, rows, k));
  }
  out.sections.push_back(plan_section(plan, provenance));
  out.opening = {
      {std::move(verdicts)},
      {KeyFigures{{{std::to_string(plan.runs), "simulated experiments"},
                   {std::to_string(trials), "ways to identify each"},
                   {std::to_string(base_parameters(plan.experiment.robot).size()), "base parameters"}}}}};
  return out;
}

}  // namespace rivid::detail
