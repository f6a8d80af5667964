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

std::string svg_figure(const std::string& name, const std::string& what, const std::string& content) {
  return element("figure",
                 element("figcaption", element("b", escaped(name)) + " " + escaped(what)) + content);
}

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
