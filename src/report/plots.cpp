#include <algorithm>
#include <cmath>

#include "report/charts.hpp"
#include "report/document.hpp"
#include "report/markup.hpp"
#include "report/svg.hpp"
#include "rivid/report/ticks.hpp"
#include "rivid/text.hpp"

namespace rivid {

std::vector<double> round_ticks(double low, double high, double least_step) {
  const double wanted = (high - low) / 5.0;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  const double lead = wanted / decade;
  const double step = std::max(least_step, decade * (lead < 1.5   ? 1.0
                                                     : lead < 3.5 ? 2.0
                                                     : lead < 7.5 ? 5.0
                                                                  : 10.0));
  // A multiple that is missed by rounding alone counts as met.
  constexpr double rounding = 1e-9;
  const auto first = std::llround(std::floor(low / step + rounding));
  const auto last = std::llround(std::ceil(high / step - rounding));
  std::vector<double> out;
  for (auto i = first; i <= last; ++i) {
    out.push_back(static_cast<double>(i) * step);
  }
  return out;
}

namespace detail {

namespace {

constexpr double plot_width = 350.0;
constexpr double plot_right = plot_width - 12.0;
constexpr double plot_top = 8.0;
constexpr double under_plot = 36.0;  // ticks and label of the abscissa

std::string svg_figure(const std::string& name, const std::string& what, const std::string& content) {
  return element("figure",
                 element("figcaption", element("b", escaped(name)) + " " + escaped(what)) + content);
}

// ---------------------------------------------------------------------------------------------- axes

// The smallest range that holds all values it is shown, and how it lies along a length.
class ValueRange {
 public:
  void show(double value) {
    if (std::isfinite(value)) {
      least_ = std::min(least_, value);
      most_ = std::max(most_, value);
    }
  }
  [[nodiscard]] bool empty() const { return least_ > most_; }
  // Along a length, with some room at either end.
  [[nodiscard]] double at(double value, double length) const {
    constexpr double margin = 6.0;
    const double span = most_ > least_ ? most_ - least_ : 1.0;
    return margin + (value - least_) / span * (length - 2.0 * margin);
  }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  double most_ = -std::numeric_limits<double>::infinity();
};

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
    out += svg_line("grid", {x.at(tick), plot_top}, {x.at(tick), bottom}) +
           svg_text("middle", {x.at(tick), bottom + 14.0}, number(tick, 6));
  }
  const double middle = 0.5 * (x.at(x.ticks().front()) + x.at(x.ticks().back()));
  return out + svg_text("middle", {middle, bottom + 30.0}, label);
}

std::string ordinate(const Axis& y, double left) {
  std::string out;
  for (const double tick : y.ticks()) {
    out += svg_line("grid", {left, y.at(tick)}, {plot_right, y.at(tick)}) +
           svg_text("end", {left - 5.0, y.at(tick) + 4.0}, number(tick, 6));
  }
  return out;
}

// ---------------------------------------------------------------------------------------------- plots

std::string drawn(const DotPlot& plot) {
  constexpr double left = 58.0;
  constexpr double row = 17.0;
  double least = plot.reference;
  double most = plot.reference;
  for (const DotPlot::Dot& each : plot.dots) {
    if (std::isfinite(each.interval.value)) {
      least = std::min(least, each.interval.low);
      most = std::max(most, each.interval.high);
    }
  }
  const double bottom = plot_top + row * static_cast<double>(plot.dots.size()) + 4.0;
  const Axis x(least, most, left, plot_right);
  std::string out = abscissa(x, bottom, plot.label);
  out += svg_box("band", {x.at(plot.wanted[0]), plot_top}, {x.at(plot.wanted[1]), bottom});
  out += svg_line("reference", {x.at(plot.reference), plot_top}, {x.at(plot.reference), bottom});
  for (std::size_t i = 0; i < plot.dots.size(); ++i) {
    const double y = plot_top + row * (static_cast<double>(i) + 0.5) + 2.0;
    const auto& [name, interval, mark] = plot.dots[i];
    out += svg_text("end", {left - 6.0, y + 4.0}, name);
    if (std::isfinite(interval.value)) {
      const std::string off = mark == Mark::bad ? " off" : "";
      out += svg_line("whisker" + off, {x.at(interval.low), y}, {x.at(interval.high), y}) +
             svg_dot("dot" + off, {x.at(interval.value), y}, 3.2);
    }
  }
  return svg_figure(plot.title, plot.what, svg_picture({plot_width, bottom + under_plot}, plot.title, out));
}

std::string drawn(const LinePlot& plot) {
  constexpr double left = 44.0;
  constexpr double height = 250.0;
  constexpr double bottom = height - under_plot;
  constexpr double between = 0.5;  // bars
  const Axis x(plot.x[0], plot.x[1], left, plot_right);
  const Axis y(plot.y[0], plot.y[1], bottom, plot_top);
  std::string out = abscissa(x, bottom, plot.label) + ordinate(y, left);
  for (const auto& [from, value] : plot.bars) {
    out += svg_box("bar", {x.at(from), y.at(value)}, {x.at(from + plot.bar) - between, bottom});
  }
  for (const Line& each : plot.lines) {
    std::vector<Point> points;
    for (const auto& [at, value] : each.points) {
      points.push_back({x.at(at), y.at(value)});
    }
    out += polyline(each.kind, points);
  }
  return svg_figure(plot.title, plot.what, svg_picture({plot_width, height}, plot.title, out));
}

std::string drawn(const PathPlot& plot) {
  constexpr double wide = 170.0;
  constexpr double height = 64.0;
  ValueRange range;
  for (const double value : plot.steps) {
    range.show(value);
  }
  if (plot.interval) {
    range.show((*plot.interval)[0]);
    range.show((*plot.interval)[1]);
  }
  if (range.empty()) {
    return {};
  }
  const auto y = [&](double value) { return height - range.at(value, height); };
  std::string content;
  if (plot.interval) {
    const double high = y((*plot.interval)[1]);
    content += svg_box("band", {0.0, high}, {wide, std::max(y((*plot.interval)[0]), high + 1.0)});
  }
  ValueRange steps;
  steps.show(0.0);
  steps.show(static_cast<double>(plot.steps.size() - 1));
  std::vector<Point> points;
  std::string dots;
  for (std::size_t k = 0; k < plot.steps.size(); ++k) {
    if (std::isfinite(plot.steps[k])) {
      points.push_back({steps.at(static_cast<double>(k), wide), y(plot.steps[k])});
      dots += svg_dot("value", points.back(), 2.0);
    }
  }
  content += polyline("path", points) + dots;
  return svg_figure(plot.name, plot.value, svg_picture({wide, height}, plot.label, content));
}

}  // namespace

std::string markup_of(const Plot& plot) {
  return std::visit([](const auto& each) { return drawn(each); }, plot);
}

std::string markup_of(const Interval& interval) {
  constexpr double wide = 140.0;
  constexpr double height = 18.0;
  constexpr double middle = 0.5 * height;
  ValueRange range;
  for (const double value : {interval.low, interval.high, interval.reference}) {
    range.show(value);
  }
  const auto x = [&](double value) { return range.at(value, wide); };
  std::string content = svg_line("axis", {0.0, middle}, {wide, middle});
  if (x(0.0) >= 0.0 && x(0.0) <= wide) {
    content += svg_line("zero", {x(0.0), 1.0}, {x(0.0), height - 1.0});
  }
  if (std::isfinite(interval.reference)) {
    content += svg_line("apriori", {x(interval.reference), 3.0}, {x(interval.reference), height - 3.0});
  }
  content += svg_line("interval", {x(interval.low), middle}, {x(interval.high), middle}) +
             svg_dot("value", {x(interval.value), middle}, 2.6);
  return svg_picture({wide, height}, interval.label, content);
}

}  // namespace detail

}  // namespace rivid
