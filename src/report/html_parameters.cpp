#include <algorithm>
#include <cmath>
#include <limits>

#include "report/html_parts.hpp"
#include "report/markup.hpp"
#include "report/svg.hpp"
#include "report/words.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

using Align = HtmlTable::Align;

// The smallest range that holds all values it is shown, and how it lies along a width.
class Range {
 public:
  void show(double value) {
    if (std::isfinite(value)) {
      least_ = std::min(least_, value);
      most_ = std::max(most_, value);
    }
  }
  [[nodiscard]] bool empty() const { return least_ > most_; }
  // Along a width, with some room at either end.
  [[nodiscard]] double at(double value, double width) const {
    constexpr double margin = 6.0;
    const double span = most_ > least_ ? most_ - least_ : 1.0;
    return margin + (value - least_) / span * (width - 2.0 * margin);
  }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  double most_ = -std::numeric_limits<double>::infinity();
};

std::string interval(const ParameterEstimate& p) {
  return "[" + with_decimals_of(p.interval_95[0], p.sigma) + ", " +
         with_decimals_of(p.interval_95[1], p.sigma) + "]";
}

// The interval as a bar on an axis of its own, with what the robot description says, and zero where it is in sight.
std::string interval_bar(const ParameterEstimate& p) {
  constexpr double width = 140.0;
  constexpr double height = 18.0;
  constexpr double middle = 0.5 * height;
  if (!std::isfinite(p.sigma)) {
    return {};
  }
  Range range;
  for (const double value : {p.interval_95[0], p.interval_95[1], p.a_priori}) {
    range.show(value);
  }
  const auto x = [&](double value) { return range.at(value, width); };
  std::string content = svg_line("axis", 0.0, middle, width, middle);
  if (x(0.0) >= 0.0 && x(0.0) <= width) {
    content += svg_line("zero", x(0.0), 1.0, x(0.0), height - 1.0);
  }
  if (std::isfinite(p.a_priori)) {
    content += svg_line("apriori", x(p.a_priori), 3.0, x(p.a_priori), height - 3.0);
  }
  content += svg_line("interval", x(p.interval_95[0]), middle, x(p.interval_95[1]), middle) +
             svg_dot("value", x(p.value), middle, 2.6);
  return svg_picture(width, height, p.name + ": " + interval(p) + ", a priori " + number(p.a_priori, 4),
                     content);
}

// The path of one parameter over the iterations, fig. 10 of [RIV], towards its interval.
std::string path_of(const std::vector<IvIteration>& iterations, Index i, const ParameterEstimate& p) {
  constexpr double width = 170.0;
  constexpr double height = 64.0;
  Range range;
  for (const IvIteration& k : iterations) {
    range.show(k.chi[i]);
  }
  const bool known = std::isfinite(p.sigma);
  if (known) {
    range.show(p.interval_95[0]);
    range.show(p.interval_95[1]);
  }
  if (range.empty()) {
    return {};
  }
  const auto y = [&](double value) { return height - range.at(value, height); };
  std::string content;
  if (known) {
    content += "<rect class=\"band\" x=\"0\" width=\"" + number(width) + "\" y=\"" +
               coordinate(y(p.interval_95[1])) + "\" height=\"" +
               coordinate(std::max(y(p.interval_95[0]) - y(p.interval_95[1]), 1.0)) + "\"/>";
  }
  std::string points;
  std::string dots;
  Range steps;
  steps.show(0.0);
  steps.show(static_cast<double>(iterations.size() - 1));
  for (std::size_t k = 0; k < iterations.size(); ++k) {
    const double value = iterations[k].chi[i];
    if (std::isfinite(value)) {
      const double x = steps.at(static_cast<double>(k), width);
      points += coordinate(x) + "," + coordinate(y(value)) + " ";
      dots += svg_dot("value", x, y(value), 2.0);
    }
  }
  content += "<polyline class=\"path\" points=\"" + points + "\"/>" + dots;
  const std::string last = with_decimals_of(p.value, p.sigma) + " " + p.unit;
  return element("figure", element("figcaption", element("b", escaped(p.name)) + " " + escaped(last)) +
                               svg_picture(width, height,
                                           p.name + " from " + number(iterations.front().chi[i], 4) + " to " +
                                               number(iterations.back().chi[i], 4) + " " + p.unit,
                                           content));
}

// What the data do not tell well, and the motion that would help; folded where it is long.
std::string advice(const std::vector<ParameterEstimate>& parameters) {
  constexpr std::ptrdiff_t few = 10;
  std::string list;
  std::ptrdiff_t weak = 0;
  std::ptrdiff_t unseen = 0;
  for (const ParameterEstimate& p : parameters) {
    if (p.verdict == Verdict::identified) {
      continue;
    }
    ++(p.verdict == Verdict::weak ? weak : unseen);
    list +=
        element("li", element("b", escaped(p.name)) +
                          (p.verdict == Verdict::weak ? " weak: " : " not excited: ") + escaped(p.advice));
  }
  if (list.empty()) {
    return {};
  }
  const std::string title = std::to_string(weak) + " weak, " + std::to_string(unseen) + " not excited, of " +
                            counted(std::ssize(parameters), "parameter") +
                            ": why, and the motion that would help";
  return element("details", element("summary", title) + element("ul", list, "class=\"advice\""),
                 weak + unseen <= few ? "open" : "");
}

}  // namespace

std::string parameters_section(const Identification& result) {
  HtmlTable table({{"parameter", Align::text},
                   {"value", Align::number},
                   {"unit", Align::text},
                   {"σ", Align::number},
                   {"%σ", Align::number},
                   {"95 % interval", Align::text},
                   {"", Align::text},
                   {"a priori", Align::number},
                   {"grouped from", Align::text}});
  for (const ParameterEstimate& p : result.parameters) {
    const bool known = std::isfinite(p.sigma);
    const bool holds_zero = known && p.interval_95[0] <= 0.0 && p.interval_95[1] >= 0.0;
    table.add({element("b", escaped(p.name)), with_decimals_of(p.value, p.sigma), escaped(p.unit),
               known ? with_decimals_of(p.sigma, p.sigma) : "-",
               known ? number(p.relative_sigma_percent, 3) : "-", known ? interval(p) : "not determined",
               interval_bar(p), number(p.a_priori, 4), p.regrouped == p.name ? "" : escaped(p.regrouped)},
              !known       ? "undetermined"
              : holds_zero ? "weak"
                           : "");
  }
  std::string out = element("h2", "Parameters", "id=\"parameters\"");
  if (result.covariance.quantile_975 != 0.0) {
    out += element("p", "Standard deviations σ are taken " + escaped(in_words(result.covariance)) +
                            "; intervals are value ± " + number(result.covariance.quantile_975, 4) + " σ.");
  }
  if (result.robust) {
    out += element("p", escaped(in_words(*result.robust)) + ".");
  }
  out += element("p",
                 legend_item("bar", "interval and value") +
                     legend_item("apriori", "a priori, from the robot description") +
                     legend_item("zero", "zero") +
                     "Each bar has a scale of its own; it is red where the interval holds zero.",
                 "class=\"legend\"");
  return element("section", out + table.markup() + advice(result.parameters));
}

std::string parameter_paths(const std::vector<ParameterEstimate>& parameters,
                            const std::vector<IvIteration>& iterations) {
  std::string out;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    out += path_of(iterations, static_cast<Index>(i), parameters[i]);
  }
  return element("div", out, "class=\"paths\"");
}

std::string conditioning_section(const Identification& result) {
  std::string out = element("h2", "Conditioning", "id=\"conditioning\"");
  out += element("p",
                 "The condition number of the problem is " + number(result.condition, 4) +
                     ". A parameter is hard to tell from the others where its pivot |R<sub>ii</sub>| of the "
                     "factored observation matrix is small" +
                     (result.iv ? ", or where the simulated motion, F below 10, hardly shows it" : "") + ".");
  const bool weighted = result.iv && result.iv->first_stage_F.size() == result.base.size();
  std::vector<HtmlTable::Column> columns = {
      {"parameter", Align::text}, {"|R<sub>ii</sub>|", Align::number}, {"", Align::text}};
  if (weighted) {
    columns.push_back({"strength of the instruments, F", Align::number});
  }
  HtmlTable table(columns);
  constexpr double width = 220.0;
  const double largest = result.R_diagonal.size() > 0 ? result.R_diagonal.maxCoeff() : 0.0;
  // A logarithmic bar: full for the largest, nothing for one that rounding can not tell from zero.
  const auto length = [&](double pivot) {
    const double decades = -std::log10(std::numeric_limits<double>::epsilon());
    return pivot > 0.0 ? std::max(width * (1.0 + std::log10(pivot / largest) / decades), 0.0) : 0.0;
  };
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const auto at = static_cast<Index>(i);
    if (at >= result.R_diagonal.size()) {
      break;
    }
    const double pivot = result.R_diagonal[at];
    std::vector<std::string> cells = {
        element("b", escaped(result.parameters[i].name)), number(pivot, 4),
        element("span", "", "class=\"pivot\" style=\"width:" + coordinate(length(pivot)) + "px\"")};
    if (weighted) {
      cells.push_back(number(result.iv->first_stage_F[at], 4));
    }
    table.add(cells);
  }
  out += element("details",
                 element("summary", "Pivots of all parameters, on a logarithmic scale") + table.markup(),
                 result.parameters.size() <= 16 ? "open" : "");
  return element("section", out);
}

}  // namespace rivid::detail
