#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "report/html_monte_carlo.hpp"
#include "report/markup.hpp"
#include "report/svg.hpp"
#include "rivid/report/ticks.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

constexpr double width = 350.0;
constexpr double right = width - 12.0;
constexpr double top = 8.0;
constexpr double below = 36.0;  // ticks and label of the abscissa

// An axis whose ends are ticks, along the pixels from … to.
class Axis {
 public:
  Axis(double low, double high, double from, double to)
      : ticks_(round_ticks(low, high > low ? high : low + 1.0)), from_(from), to_(to) {}

  [[nodiscard]] const std::vector<double>& ticks() const { return ticks_; }
  [[nodiscard]] double at(double value) const {
    const double inside = std::clamp(value, ticks_.front(), ticks_.back());
    return from_ + (inside - ticks_.front()) / (ticks_.back() - ticks_.front()) * (to_ - from_);
  }

 private:
  std::vector<double> ticks_;
  double from_;
  double to_;
};

// Grid, ticks and label of the abscissa.
std::string abscissa(const Axis& x, double bottom, const std::string& label) {
  std::string out;
  for (const double tick : x.ticks()) {
    out += svg_line("grid", x.at(tick), top, x.at(tick), bottom) +
           svg_text("middle", x.at(tick), bottom + 14.0, number(tick, 6));
  }
  const double middle = 0.5 * (x.at(x.ticks().front()) + x.at(x.ticks().back()));
  return out + svg_text("middle", middle, bottom + 30.0, label);
}

std::string ordinate(const Axis& y, double left) {
  std::string out;
  for (const double tick : y.ticks()) {
    out += svg_line("grid", left, y.at(tick), right, y.at(tick)) +
           svg_text("end", left - 5.0, y.at(tick) + 4.0, number(tick, 6));
  }
  return out;
}

std::string polyline(std::string_view kind, const std::vector<std::array<double, 2>>& points) {
  std::string list;
  for (const auto& [x, y] : points) {
    list += coordinate(x) + "," + coordinate(y) + " ";
  }
  return "<polyline class=\"" + std::string(kind) + "\" points=\"" + list + "\"/>";
}

std::string panel(const std::string& title, const std::string& what, double height,
                  const std::string& content) {
  return element("figure", element("figcaption", element("b", title) + " " + what) +
                               svg_picture(width, height, title, content));
}

// What a dot plot shows of a parameter.
struct Dot {
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
};

struct DotPlot {
  std::string title;
  std::string what;
  std::string label;
  double reference = 0.0;
  std::array<double, 2> wanted = {};  // values that speak for the trial
  std::function<Dot(const MonteCarloParameter&)> dot;
};

std::string dot_plot(const MonteCarloSummary& summary, const DotPlot& plot) {
  constexpr double left = 58.0;
  constexpr double row = 17.0;
  double least = plot.reference;
  double most = plot.reference;
  std::vector<Dot> dots;
  for (const MonteCarloParameter& p : summary.parameters) {
    const Dot& dot = dots.emplace_back(plot.dot(p));
    if (std::isfinite(dot.value)) {
      least = std::min(least, dot.low);
      most = std::max(most, dot.high);
    }
  }
  const double bottom = top + row * static_cast<double>(dots.size()) + 4.0;
  const Axis x(least, most, left, right);
  std::string out = abscissa(x, bottom, plot.label);
  const double low = x.at(std::max(plot.wanted[0], x.ticks().front()));
  out += svg_box("band", low, top, x.at(std::min(plot.wanted[1], x.ticks().back())) - low, bottom - top);
  out += svg_line("reference", x.at(plot.reference), top, x.at(plot.reference), bottom);
  for (std::size_t i = 0; i < dots.size(); ++i) {
    const double y = top + row * (static_cast<double>(i) + 0.5) + 2.0;
    const Dot& dot = dots[i];
    out += svg_text("end", left - 6.0, y + 4.0, summary.parameters[i].name);
    if (std::isfinite(dot.value)) {
      const bool off = dot.low > plot.wanted[1] || dot.high < plot.wanted[0];
      out += svg_line(off ? "whisker off" : "whisker", x.at(dot.low), y, x.at(dot.high), y) +
             svg_dot(off ? "dot off" : "dot", x.at(dot.value), y, 3.2);
    }
  }
  return panel(plot.title, plot.what, bottom + below, out);
}

double normal_density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi); }

double normal_distribution(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

std::vector<double> together(const std::vector<std::vector<double>>& errors) {
  std::vector<double> out;
  for (const std::vector<double>& list : errors) {
    out.insert(out.end(), list.begin(), list.end());
  }
  return out;
}

// Quantiles of a sample at the probabilities of normal ones, as far as it reaches.
std::vector<std::array<double, 2>> quantiles(std::vector<double> sample) {
  constexpr int steps = 14;  // to either side
  constexpr double step = 0.25;
  std::ranges::sort(sample);
  std::vector<std::array<double, 2>> out;
  for (int k = -steps; k <= steps; ++k) {
    const double x = step * k;
    const double at = normal_distribution(x) * static_cast<double>(sample.size()) - 0.5;
    const double below_it = std::floor(at);
    if (below_it >= 0.0 && below_it + 1.0 < static_cast<double>(sample.size())) {
      const auto i = static_cast<std::size_t>(below_it);
      out.push_back({x, sample[i] + (at - below_it) * (sample[i + 1] - sample[i])});
    }
  }
  return out;
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

std::string bias_plot(const MonteCarloSummary& summary) {
  constexpr double limit = MonteCarloVerdict::largest_bias;
  return dot_plot(summary, {.title = "Bias",
                            .what = "mean error in deviations of the estimate; should be 0",
                            .label = "bias / spread",
                            .reference = 0.0,
                            .wanted = {-limit, limit},
                            .dot = [](const MonteCarloParameter& p) {
                              return Dot{p.bias_in_spreads, p.bias_in_spreads_95[0], p.bias_in_spreads_95[1]};
                            }});
}

std::string coverage_plot(const MonteCarloSummary& summary) {
  return dot_plot(summary, {.title = "Coverage",
                            .what = "share of 95 % intervals that hold the truth; should be 95 %",
                            .label = "coverage [%]",
                            .reference = 95.0,
                            .wanted = {100.0 * MonteCarloVerdict::least_coverage, 100.0},
                            .dot = [](const MonteCarloParameter& p) {
                              return Dot{100.0 * p.coverage, 100.0 * p.coverage_95[0],
                                         100.0 * p.coverage_95[1]};
                            }});
}

std::string rmse_plot(const MonteCarloSummary& summary) {
  return dot_plot(
      summary, {.title = "Precision",
                .what = "root mean square error over the bound that no method can beat by much; should be 1",
                .label = "RMSE / bound",
                .reference = 1.0,
                .wanted = {0.0, MonteCarloVerdict::largest_rmse},
                .dot = [](const MonteCarloParameter& p) {
                  return Dot{p.rmse_over_bound, p.rmse_over_bound_95[0], p.rmse_over_bound_95[1]};
                }});
}

std::string error_histogram(const std::vector<std::vector<double>>& errors) {
  constexpr double reach = 4.0;
  constexpr double bin = 0.25;
  constexpr auto bins = static_cast<std::size_t>(2.0 * reach / bin);
  constexpr double left = 44.0;
  constexpr double height = 250.0;
  constexpr double bottom = height - below;
  const std::vector<double> all = together(errors);
  std::vector<double> density(bins);
  std::ptrdiff_t outside = 0;
  for (const double error : all) {
    const double at = std::floor((error + reach) / bin);
    if (at >= 0.0 && at < static_cast<double>(bins)) {
      density[static_cast<std::size_t>(at)] += 1.0 / (bin * static_cast<double>(all.size()));
    } else {
      ++outside;
    }
  }
  const Axis x(-reach, reach, left, right);
  const Axis y(0.0, std::max(std::ranges::max(density), normal_density(0.0)), bottom, top);
  std::string out = abscissa(x, bottom, "(estimate − truth) / σ") + ordinate(y, left);
  for (std::size_t k = 0; k < bins; ++k) {
    const double from = -reach + bin * static_cast<double>(k);
    out += svg_box("bar", x.at(from), y.at(density[k]), x.at(from + bin) - x.at(from) - 0.5,
                   bottom - y.at(density[k]));
  }
  std::vector<std::array<double, 2>> curve;
  for (std::size_t k = 0; k <= 2 * bins; ++k) {
    const double at = -reach + 0.5 * bin * static_cast<double>(k);
    curve.push_back({x.at(at), y.at(normal_density(at))});
  }
  out += polyline("curve", curve);
  return panel("Distribution",
               "of the errors of all parameters, beside the standard normal one" +
                   (outside > 0 ? "; " + counted(outside, "error") + " beyond four σ" : std::string()),
               height, out);
}

std::string quantile_plot(const std::vector<std::vector<double>>& errors) {
  constexpr double left = 44.0;
  constexpr double height = 250.0;
  constexpr double bottom = height - below;
  constexpr double ends = 4.0;
  std::vector<std::vector<std::array<double, 2>>> lines;
  lines.reserve(errors.size() + 1);
  for (const std::vector<double>& list : errors) {
    lines.push_back(quantiles(list));
  }
  lines.push_back(quantiles(together(errors)));
  double reach = ends;
  for (const auto& line : lines) {
    for (const auto& [x, y] : line) {
      reach = std::max(reach, std::abs(y));
    }
  }
  const Axis x(-ends, ends, left, right);
  const Axis y(-reach, reach, bottom, top);
  std::string out = abscissa(x, bottom, "quantile of the normal distribution") + ordinate(y, left);
  out += svg_line("reference", x.at(-ends), y.at(-ends), x.at(ends), y.at(ends));
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (auto& [at, value] : lines[i]) {
      at = x.at(at);
      value = y.at(value);
    }
    out += polyline(i + 1 == lines.size() ? "all" : "one", lines[i]);
  }
  return panel("Quantiles", "of the errors in σ: a thin line for each parameter, a thick one for all", height,
               out);
}

}  // namespace rivid::detail
