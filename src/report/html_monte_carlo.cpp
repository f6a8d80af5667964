#include "report/html_monte_carlo.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "report/html_page.hpp"
#include "report/markup.hpp"
#include "report/words.hpp"
#include "rivid/report/monte_carlo.hpp"
#include "rivid/text.hpp"
#include "rivid/version.hpp"

namespace rivid {

namespace {

using detail::bullets;
using detail::element;
using detail::escaped;
using detail::HtmlTable;
using detail::key_figure;
using Align = HtmlTable::Align;

std::string share(double fraction) { return fixed(100.0 * fraction, 1) + " %"; }

// The parameter with the largest value of a figure; nothing where no value is a number.
template <typename Figure>
const MonteCarloParameter* worst(const MonteCarloSummary& summary, Figure figure) {
  const MonteCarloParameter* out = nullptr;
  for (const MonteCarloParameter& p : summary.parameters) {
    if (std::isfinite(figure(p)) && (out == nullptr || figure(p) > figure(*out))) {
      out = &p;
    }
  }
  return out;
}

const MonteCarloParameter* most_biased(const MonteCarloSummary& summary) {
  return worst(summary, [](const MonteCarloParameter& p) { return std::abs(p.bias_in_spreads); });
}

const MonteCarloParameter* least_covered(const MonteCarloSummary& summary) {
  return worst(summary, [](const MonteCarloParameter& p) { return -p.coverage; });
}

const MonteCarloParameter* least_precise(const MonteCarloSummary& summary) {
  return worst(summary, [](const MonteCarloParameter& p) { return p.rmse_over_bound; });
}

double mean_rmse(const MonteCarloSummary& summary) {
  double out = 0.0;
  for (const MonteCarloParameter& p : summary.parameters) {
    out += p.rmse_over_bound / static_cast<double>(summary.parameters.size());
  }
  return out;
}

// Enough runs for their figures to say something.
bool judged(const MonteCarloSummary& summary) {
  return summary.identified >= 2 && most_biased(summary) != nullptr;
}

bool good(const MonteCarloSummary& summary) { return summary.verdict.unbiased && summary.verdict.honest; }

std::string in_words(const MonteCarloSummary& s) {
  if (!judged(s)) {
    return "too few runs are identified to say anything";
  }
  const MonteCarloParameter& bias = *most_biased(s);
  std::string out = std::string(s.verdict.unbiased ? "unbiased" : "biased") + " (at most " +
                    fixed(std::abs(bias.bias_in_spreads), 2) + " deviations, " + bias.name + "); ";
  const MonteCarloParameter& coverage = *least_covered(s);
  out += "error bars are " + std::string(s.verdict.honest ? "honest" : "not honest") + " (" +
         share(s.mean_coverage) + " of the 95 % intervals hold the truth, of " + coverage.name + " " +
         share(coverage.coverage) + ")";
  if (s.verdict.efficient) {
    const MonteCarloParameter& rmse = *least_precise(s);
    out += "; " + std::string(*s.verdict.efficient ? "efficient" : "not efficient") + " (errors are " +
           fixed(mean_rmse(s), 2) + " times their bound on average, of " + rmse.name + " " +
           fixed(rmse.rmse_over_bound, 2) + " times)";
  }
  return out;
}

std::string sign(bool ok) {
  return element("span", ok ? "✓" : "✗",
                 "class=\"sign " + std::string(ok ? "pass" : "fail") + "\" aria-hidden=\"true\"");
}

std::string verdict_section(const MonteCarlo& plan, std::span<const MonteCarloSummary> summaries) {
  const std::ptrdiff_t passed = std::ranges::count_if(summaries, good);
  const auto trials = static_cast<std::ptrdiff_t>(summaries.size());
  std::string out = element(
      "h2", passed == trials
                ? "Unbiased, and error bars mean what they say"
                : std::to_string(passed) + " of " + counted(trials, "way") + " to identify can be trusted");
  std::string items;
  for (const MonteCarloSummary& s : summaries) {
    items +=
        element("li", sign(good(s)) + " " + element("b", escaped(s.label)) + ": " + escaped(in_words(s))) +
        "\n";
  }
  out += element("ul", items, "class=\"trials\"");
  out += element(
      "div",
      key_figure(std::to_string(plan.runs), "simulated experiments") +
          key_figure(std::to_string(trials), "ways to identify each") +
          key_figure(std::to_string(base_parameters(plan.experiment.robot).size()), "base parameters"),
      "class=\"figures\"");
  return element("section", out,
                 "class=\"verdict " +
                     std::string(passed == trials ? "good"
                                 : passed > 0     ? "mixed"
                                                  : "bad") +
                     "\"");
}

std::string criteria() {
  using V = MonteCarloVerdict;
  return element(
      "p", "Unbiased: no bias above " + number(V::largest_bias) +
               " standard deviations of the estimates. Honest: " + number(100.0 * V::mean_coverage[0]) +
               " to " + number(100.0 * V::mean_coverage[1]) +
               " % of the 95 % intervals hold the truth on average, and " +
               number(100.0 * V::least_coverage) +
               " % or more for each parameter. Efficient: no root mean square error above " +
               number(V::largest_rmse) +
               " times that of weighted least squares on regressors without noise. A figure counts only "
               "where the whole interval that so many runs leave open is beyond that.");
}

std::string comparison(std::span<const MonteCarloSummary> summaries) {
  HtmlTable table({{"", Align::text},
                   {"identified", Align::number},
                   {"iterations", Align::number},
                   {"largest bias", Align::number},
                   {"mean coverage", Align::number},
                   {"least", Align::number},
                   {"mean RMSE / bound", Align::number},
                   {"largest", Align::number}});
  for (const MonteCarloSummary& s : summaries) {
    const bool told = judged(s);
    const bool bound = s.verdict.efficient.has_value();
    table.add({element("b", escaped(s.label)), std::to_string(s.identified) + " of " + std::to_string(s.runs),
               s.most_iterations > 0 ? fixed(s.mean_iterations, 1) : "",
               told ? fixed(std::abs(most_biased(s)->bias_in_spreads), 2) : "-",
               told ? share(s.mean_coverage) : "-", told ? share(least_covered(s)->coverage) : "-",
               bound ? fixed(mean_rmse(s), 2) : "-",
               bound ? fixed(least_precise(s)->rmse_over_bound, 2) : "-"});
  }
  return element("section", element("h2", "Ways to identify", "id=\"ways\"") + table.markup() + criteria());
}

// Why runs are not identified, the most frequent reason first.
std::string other_outcomes(const MonteCarloSummary& summary) {
  std::vector<std::pair<std::string, int>> outcomes(summary.outcomes.begin(), summary.outcomes.end());
  std::ranges::stable_sort(outcomes, std::greater(), &std::pair<std::string, int>::second);
  std::vector<std::string> lines;
  for (const auto& [outcome, runs] : outcomes) {
    std::string why = outcome == "not_simulated" ? "the experiment itself could not be simulated"
                      : outcome == "refused"     ? "the log could not be used"
                                                 : "";
    for (int k = 0; k <= static_cast<int>(Status::not_simulable); ++k) {
      if (outcome == name(static_cast<Status>(k))) {
        why = detail::why_not(static_cast<Status>(k));
      }
    }
    if (outcome != name(Status::identified)) {
      lines.push_back(counted(runs, "run") + " " + outcome);
      lines.back().append(": ").append(why);
    }
  }
  return bullets(lines, "reasons");
}

std::string parameters_table(const MonteCarloSummary& summary) {
  HtmlTable table({{"parameter", Align::text},
                   {"truth", Align::number},
                   {"unit", Align::text},
                   {"bias", Align::number},
                   {"bias / spread", Align::number},
                   {"spread", Align::number},
                   {"RMSE / bound", Align::number},
                   {"mean σ / spread", Align::number},
                   {"coverage", Align::number},
                   {"its 95 % interval", Align::number}});
  constexpr int digits = 4;
  for (const MonteCarloParameter& p : summary.parameters) {
    table.add({element("b", escaped(p.name)), number(p.truth, digits), escaped(p.unit),
               number(p.bias, digits), fixed(p.bias_in_spreads, 2), number(p.spread, digits),
               fixed(p.rmse_over_bound, 2), fixed(p.sigma_over_spread, 2), share(p.coverage),
               "[" + share(p.coverage_95[0]) + ", " + share(p.coverage_95[1]) + "]"});
  }
  return element("details", element("summary", "All figures") + table.markup());
}

std::string trial_section(const MonteCarloSummary& summary, std::span<const MonteCarloRow> rows,
                          const std::string& id) {
  std::string out = element("h2", escaped(summary.label), "id=\"" + id + "\"");
  std::string line =
      std::to_string(summary.identified) + " of " + counted(summary.runs, "run") + " identified";
  if (summary.most_iterations > 0) {
    line += ", in " + fixed(summary.mean_iterations, 1) + " iterations on average, " +
            std::to_string(summary.most_iterations) + " at most";
  }
  out += element("p", line + ".") + other_outcomes(summary);
  if (!judged(summary)) {
    return element("section", out);
  }
  const auto errors = detail::standardised_errors(summary, rows);
  std::string plots = detail::bias_plot(summary) + detail::coverage_plot(summary);
  if (summary.verdict.efficient) {
    plots += detail::rmse_plot(summary);
  }
  out += element("div", plots, "class=\"panels\"");
  out += element("div", detail::error_histogram(errors) + detail::quantile_plot(errors), "class=\"panels\"");
  return element("section", out + parameters_table(summary));
}

std::string legend() {
  return element(
      "p",
      detail::legend_item("dot", "a parameter, with the 95 % interval that so many runs leave open") +
          detail::legend_item("off", "beyond what is wanted, by more than that") +
          detail::legend_item("reference", "what it should be") +
          detail::legend_item("left-out", "what counts as good enough"),
      "class=\"legend\"");
}

std::string provenance_section(const MonteCarlo& plan, const Provenance& provenance) {
  HtmlTable settings({{"", Align::text}, {"", Align::text}});
  const auto add = [&](const std::string& what, const std::string& value) {
    settings.add({escaped(what), escaped(value)});
  };
  add("Program", provenance.program + ", rivid " + version);
  add("Robot", plan.experiment.robot.name + ", " + counted(plan.experiment.robot.size(), "joint"));
  add("Runs", std::to_string(plan.runs) + "; run k, counted from 0, has the seed " +
                  std::to_string(plan.seed) + " + k");
  for (const auto& [flag, value] : provenance.overrides) {
    add("Flag --" + flag, value);
  }
  std::vector<HtmlTable::Column> columns = {{"", Align::text}, {"Method", Align::text}};
  for (const auto& [what, value] : detail::row_settings(plan.trials.front().experiment.estimation.signal)) {
    columns.push_back({what, Align::text});
  }
  HtmlTable trials(columns);
  for (const MonteCarlo::Trial& trial : plan.trials) {
    std::vector<std::string> cells = {element("b", escaped(trial.label)),
                                      std::string(name(trial.experiment.estimation.method))};
    for (const auto& [what, value] : detail::row_settings(trial.experiment.estimation.signal)) {
      cells.push_back(escaped(value));
    }
    trials.add(cells);
  }
  return element("section", element("h2", "Provenance", "id=\"provenance\"") + settings.markup() +
                                trials.markup() + detail::inputs_table(provenance));
}

}  // namespace

std::string html_report(const MonteCarlo& plan, std::span<const MonteCarloSummary> summaries,
                        std::span<const MonteCarloRow> rows, const Provenance& provenance) {
  const std::string& robot = plan.experiment.robot.name;
  std::string content = comparison(summaries) + legend();
  std::vector<detail::PageSection> sections = {{"ways", "Ways to identify"}};
  std::vector<std::string> ids;
  for (std::size_t k = 0; k < summaries.size(); ++k) {
    ids.push_back("way_" + std::to_string(k + 1));
    content += trial_section(summaries[k], rows, ids.back());
  }
  std::vector<std::string> titles;
  for (const MonteCarloSummary& s : summaries) {
    titles.push_back(escaped(s.label));
  }
  for (std::size_t k = 0; k < summaries.size(); ++k) {
    sections.push_back({ids[k], titles[k]});
  }
  sections.push_back({"provenance", "Provenance"});
  content += provenance_section(plan, provenance);
  std::string body = element(
      "header", element("h1", escaped(robot)) +
                    element("p", "Monte Carlo" + (provenance.inputs.empty()
                                                      ? std::string()
                                                      : " · " + escaped(provenance.inputs.front().path))));
  body += verdict_section(plan, summaries) + detail::navigation(sections, content) + content;
  return detail::html_page(escaped(robot + " · Monte Carlo"), "", body, "");
}

}  // namespace rivid
