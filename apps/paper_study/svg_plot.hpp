#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "rivid/report/ticks.hpp"

/// Line plots as SVG that needs nothing else: no script, no font file, no style sheet. The colours follow the reader's
/// choice of a light or a dark screen.
namespace svg {

struct Series {
  std::string label;
  std::vector<double> x;
  std::vector<double> y;
  bool dashed = false;
  bool markers = false;
  std::size_t color = 0;  ///< number of the colour, 0 to 5
};

struct Axis {
  std::string label;  ///< with the unit
  bool logarithmic = false;
  double least_step = 0.0;  ///< between ticks: 1 for what is counted
};

struct Panel {
  std::string title;
  Axis x;
  Axis y;
  std::vector<Series> series;
};

namespace detail {

inline std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  }
  return out;
}

inline std::string printed(const char* format, double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

inline std::string pixel(double value) { return printed("%.1f", value); }

// One axis of a panel: its range, its ticks, and the pixels that it is drawn on.
class Scale {
 public:
  Scale(const Axis& axis, const std::vector<Series>& series, std::vector<double> Series::* values,
        double from, double to)
      : logarithmic_(axis.logarithmic), from_(from), to_(to) {
    low_ = std::numeric_limits<double>::infinity();
    high_ = -low_;
    for (const Series& s : series) {
      for (const double value : s.*values) {
        if (shows(value)) {
          low_ = std::min(low_, number(value));
          high_ = std::max(high_, number(value));
        }
      }
    }
    if (!(low_ <= high_)) {
      low_ = 0.0;
      high_ = 1.0;
    }
    if (logarithmic_) {
      add_decades();
    } else {
      add_steps(axis.least_step);
    }
  }

  /// Whether a value has a place on the axis.
  [[nodiscard]] bool shows(double value) const {
    return std::isfinite(value) && (!logarithmic_ || value > 0.0);
  }
  [[nodiscard]] double at(double value) const {
    return from_ + (number(value) - low_) / (high_ - low_) * (to_ - from_);
  }
  [[nodiscard]] const std::vector<double>& ticks() const { return ticks_; }

 private:
  [[nodiscard]] double number(double value) const { return logarithmic_ ? std::log10(value) : value; }

  void add_steps(double least_step) {
    if (high_ - low_ <= 1e-12 * std::max(std::abs(low_), std::abs(high_))) {
      const double margin = low_ == 0.0 ? 1.0 : 0.1 * std::abs(low_);
      low_ -= margin;
      high_ += margin;
    }
    ticks_ = rivid::round_ticks(low_, high_, least_step);
    low_ = ticks_.front();
    high_ = ticks_.back();
  }

  void add_decades() {
    const double margin = 0.04 * std::max(high_ - low_, 0.3);
    low_ -= margin;
    high_ += margin;
    // The narrower the range, the more ticks a decade.
    const double range = high_ - low_;
    const std::vector<double> leads = range > 3.0   ? std::vector<double>{1.0}
                                      : range > 0.8 ? std::vector<double>{1.0, 2.0, 5.0}
                                                    : std::vector<double>{1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0};
    for (int decade = static_cast<int>(std::floor(low_)); decade <= high_; ++decade) {
      for (const double lead : leads) {
        const double tick = lead * std::pow(10.0, decade);
        if (number(tick) >= low_ && number(tick) <= high_) {
          ticks_.push_back(tick);
        }
      }
    }
  }

  bool logarithmic_;
  double from_;
  double to_;
  double low_ = 0.0;
  double high_ = 1.0;
  std::vector<double> ticks_;
};

inline std::string text(double x, double y, const char* anchor, const std::string& content,
                        const std::string& more = "") {
  return "<text x=\"" + pixel(x) + "\" y=\"" + pixel(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
         escaped(content) + "</text>\n";
}

inline std::string line(double x1, double y1, double x2, double y2, const std::string& kind) {
  return "<path class=\"" + kind + "\" d=\"M" + pixel(x1) + " " + pixel(y1) + "L" + pixel(x2) + " " +
         pixel(y2) + "\"/>\n";
}

inline std::string stroke(const Series& s) {
  return "c" + std::to_string(s.color % 6) + (s.dashed ? " dashed" : "");
}

inline std::string dot(double x, double y, const Series& s) {
  return "<circle class=\"d" + std::to_string(s.color % 6) + "\" cx=\"" + pixel(x) + "\" cy=\"" + pixel(y) +
         "\" r=\"3\"/>\n";
}

inline std::string curve(const Series& s, const Scale& x, const Scale& y) {
  std::string path;
  std::string dots;
  bool pen_down = false;
  for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i) {
    if (!x.shows(s.x[i]) || !y.shows(s.y[i])) {
      pen_down = false;
      continue;
    }
    path += (pen_down ? "L" : "M") + pixel(x.at(s.x[i])) + " " + pixel(y.at(s.y[i]));
    pen_down = true;
    if (s.markers) {
      dots += dot(x.at(s.x[i]), y.at(s.y[i]), s);
    }
  }
  return "<path class=\"" + stroke(s) + "\" d=\"" + path + "\"/>\n" + dots;
}

constexpr double margin_left = 66.0;
constexpr double margin_right = 18.0;
constexpr double margin_top = 30.0;
constexpr double margin_bottom = 46.0;
constexpr double legend_line = 17.0;
constexpr double legend_column = 190.0;

inline int legend_columns(double width) {
  return std::max(1, static_cast<int>((width - margin_left - margin_right) / legend_column));
}

inline double legend_height(const Panel& panel, double width) {
  const auto columns = static_cast<std::size_t>(legend_columns(width));
  const std::size_t lines = (panel.series.size() + columns - 1) / columns;
  return legend_line * static_cast<double>(lines);
}

inline std::string drawn(const Panel& panel, double left, double top, double width, double height,
                         double legend) {
  const double x_0 = left + margin_left;
  const double x_1 = left + width - margin_right;
  const double y_0 = top + height - margin_bottom;
  const double y_1 = top + margin_top + legend;
  const Scale x(panel.x, panel.series, &Series::x, x_0, x_1);
  const Scale y(panel.y, panel.series, &Series::y, y_0, y_1);
  std::string out = text(x_0, top + 16.0, "start", panel.title, " class=\"title\"");
  for (const double tick : x.ticks()) {
    out += line(x.at(tick), y_0, x.at(tick), y_1, "grid");
    out += text(x.at(tick), y_0 + 16.0, "middle", printed("%.6g", tick));
  }
  for (const double tick : y.ticks()) {
    out += line(x_0, y.at(tick), x_1, y.at(tick), "grid");
    // A sum of steps that should be zero may miss it by a rounding error.
    out += text(x_0 - 7.0, y.at(tick) + 4.0, "end", printed("%.6g", std::abs(tick) < 1e-14 ? 0.0 : tick));
  }
  out += line(x_0, y_0, x_1, y_0, "axis") + line(x_0, y_0, x_0, y_1, "axis");
  out += text(0.5 * (x_0 + x_1), y_0 + 36.0, "middle", panel.x.label);
  const double middle = 0.5 * (y_0 + y_1);
  out += text(left + 14.0, middle, "middle", panel.y.label,
              " transform=\"rotate(-90 " + pixel(left + 14.0) + " " + pixel(middle) + ")\"");
  for (const Series& s : panel.series) {
    out += curve(s, x, y);
  }
  const int columns = legend_columns(width);
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const int at = static_cast<int>(i);
    const int line_of_legend = at / columns;
    const double entry_x = x_0 + legend_column * (at % columns);
    const double entry_y = top + margin_top + legend_line * line_of_legend;
    out += line(entry_x, entry_y, entry_x + 24.0, entry_y, stroke(panel.series[i]));
    if (panel.series[i].markers) {
      out += dot(entry_x + 12.0, entry_y, panel.series[i]);
    }
    out += text(entry_x + 30.0, entry_y + 4.0, "start", panel.series[i].label);
  }
  return out;
}

}  // namespace detail

/// A figure of panels, filled row by row.
///
/// @param columns  panels in a row
/// @param width    of a panel, with its labels [px]
/// @param height   of a panel, without its legend [px]
inline std::string figure(const std::string& title, const std::vector<Panel>& panels, int columns,
                          double width, double height) {
  const int rows = (static_cast<int>(panels.size()) + columns - 1) / columns;
  double legend = 0.0;
  for (const Panel& panel : panels) {
    legend = std::max(legend, detail::legend_height(panel, width));
  }
  height += legend;
  constexpr double head = 34.0;
  const std::string whole_width = detail::pixel(width * columns);
  const std::string whole_height = detail::pixel(height * rows + head);
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + whole_width + " " +
                    whole_height + "\" width=\"" + whole_width + "\" height=\"" + whole_height +
                    "\" role=\"img\">\n<title>" + detail::escaped(title) + "</title>\n";
  out += R"(<style>
text { font-family: sans-serif; font-size: 12px; fill: #222 }
.title { font-weight: bold }
.head { font-weight: bold; font-size: 15px }
.back { fill: #fff }
path { fill: none; stroke-width: 1.5 }
.axis { stroke: #444; stroke-width: 1 }
.grid { stroke: #ddd; stroke-width: 1 }
.dashed { stroke-dasharray: 6 4 }
.c0 { stroke: #0068b4 } .c1 { stroke: #c85000 } .c2 { stroke: #00825c }
.c3 { stroke: #b0508c } .c4 { stroke: #8a6d00 } .c5 { stroke: #666 }
.d0 { fill: #0068b4 } .d1 { fill: #c85000 } .d2 { fill: #00825c }
.d3 { fill: #b0508c } .d4 { fill: #8a6d00 } .d5 { fill: #666 }
@media (prefers-color-scheme: dark) {
text { fill: #e4e4e4 }
.back { fill: #16181c }
.axis { stroke: #bbb }
.grid { stroke: #34383f }
.c0 { stroke: #5ab4f0 } .c1 { stroke: #f39a4a } .c2 { stroke: #3fc79a }
.c3 { stroke: #e391c3 } .c4 { stroke: #d9bd4a } .c5 { stroke: #aaa }
.d0 { fill: #5ab4f0 } .d1 { fill: #f39a4a } .d2 { fill: #3fc79a }
.d3 { fill: #e391c3 } .d4 { fill: #d9bd4a } .d5 { fill: #aaa }
}
</style>
)";
  out += "<rect class=\"back\" width=\"100%\" height=\"100%\"/>\n";
  out += detail::text(14.0, 24.0, "start", title, " class=\"head\"");
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const int at = static_cast<int>(i);
    const int line = at / columns;
    out += detail::drawn(panels[i], width * (at % columns), head + height * line, width, height, legend);
  }
  return out + "</svg>\n";
}

}  // namespace svg
