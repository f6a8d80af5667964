#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "paper_study/study.hpp"
#include "paper_study/ticks.hpp"
#include "rivid/text.hpp"

namespace rivid::study {

namespace {

constexpr double margin_left = 66.0;
constexpr double margin_right = 18.0;
constexpr double margin_top = 30.0;
constexpr double margin_bottom = 46.0;
constexpr double head = 34.0;
constexpr double legend_line = 17.0;
constexpr double legend_column = 190.0;

constexpr const char* style = R"(<style>
text { font-family: sans-serif; font-size: 12px; fill: #222 }
.title { font-weight: bold }
.head { font-weight: bold; font-size: 15px }
.back { fill: #fff }
path { fill: none; stroke: currentColor; stroke-width: 1.5 }
circle { fill: currentColor }
.axis { stroke: #444; stroke-width: 1 }
.grid { stroke: #ddd; stroke-width: 1 }
.dashed { stroke-dasharray: 6 4 }
.c0 { color: #0068b4 } .c1 { color: #c85000 } .c2 { color: #00825c }
.c3 { color: #b0508c } .c4 { color: #8a6d00 } .c5 { color: #666 }
@media (prefers-color-scheme: dark) {
text { fill: #e4e4e4 }
.back { fill: #16181c }
.axis { stroke: #bbb }
.grid { stroke: #34383f }
.c0 { color: #5ab4f0 } .c1 { color: #f39a4a } .c2 { color: #3fc79a }
.c3 { color: #e391c3 } .c4 { color: #d9bd4a } .c5 { color: #aaa }
}
</style>
)";

std::string pixel(double value) { return fixed(value, 1); }

// Labels are this program's own: none has a character that XML wants escaped.
std::string text(double x, double y, const std::string& anchor, const std::string& content,
                 const std::string& more = "") {
  return "<text x=\"" + pixel(x) + "\" y=\"" + pixel(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
         content + "</text>\n";
}

std::string path(const std::string& kind, const std::string& d) {
  return "<path class=\"" + kind + "\" d=\"" + d + "\"/>\n";
}

std::string point(double x, double y) { return pixel(x) + " " + pixel(y); }

std::string line(double x1, double y1, double x2, double y2, const std::string& kind) {
  return path(kind, "M" + point(x1, y1) + "L" + point(x2, y2));
}

std::string color(const Series& s) { return "c" + std::to_string(s.color); }

std::string stroke(const Series& s) { return color(s) + (s.dashed ? " dashed" : ""); }

std::string dot(double x, double y, const Series& s) {
  return "<circle class=\"" + color(s) + "\" cx=\"" + pixel(x) + "\" cy=\"" + pixel(y) + "\" r=\"3\"/>\n";
}

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
          low_ = std::min(low_, measure(value));
          high_ = std::max(high_, measure(value));
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
    return from_ + (measure(value) - low_) / (high_ - low_) * (to_ - from_);
  }
  [[nodiscard]] const std::vector<double>& ticks() const { return ticks_; }

 private:
  [[nodiscard]] double measure(double value) const { return logarithmic_ ? std::log10(value) : value; }

  void add_steps(double least_step) {
    if (high_ - low_ <= 1e-12 * std::max(std::abs(low_), std::abs(high_))) {
      const double margin = low_ == 0.0 ? 1.0 : 0.1 * std::abs(low_);
      low_ -= margin;
      high_ += margin;
    }
    ticks_ = round_ticks(low_, high_, least_step);
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
        if (measure(tick) >= low_ && measure(tick) <= high_) {
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

std::string curve(const Series& s, const Scale& x, const Scale& y) {
  std::string d;
  std::string dots;
  bool pen_down = false;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    if (!x.shows(s.x[i]) || !y.shows(s.y[i])) {
      pen_down = false;
      continue;
    }
    d += (pen_down ? "L" : "M") + point(x.at(s.x[i]), y.at(s.y[i]));
    pen_down = true;
    if (s.markers) {
      dots += dot(x.at(s.x[i]), y.at(s.y[i]), s);
    }
  }
  return path(stroke(s), d) + dots;
}

int legend_columns(double width) {
  return std::max(1, static_cast<int>((width - margin_left - margin_right) / legend_column));
}

double legend_height(const Figure& figure) {
  std::size_t most = 0;
  for (const Panel& panel : figure.panels) {
    most = std::max(most, panel.series.size());
  }
  const auto columns = static_cast<std::size_t>(legend_columns(figure.width));
  const std::size_t lines = (most + columns - 1) / columns;
  return legend_line * static_cast<double>(lines);
}

std::string legend(const Panel& panel, double x_0, double y_0, int columns) {
  std::string out;
  int at = 0;
  for (const Series& s : panel.series) {
    const int line_of_legend = at / columns;
    const double x = x_0 + legend_column * (at % columns);
    const double y = y_0 + legend_line * line_of_legend;
    out += line(x, y, x + 24.0, y, stroke(s));
    if (s.markers) {
      out += dot(x + 12.0, y, s);
    }
    out += text(x + 30.0, y + 4.0, "start", s.label);
    ++at;
  }
  return out;
}

std::string drawn(const Panel& panel, double left, double top, double width, double height,
                  double legend_space) {
  const double x_0 = left + margin_left;
  const double x_1 = left + width - margin_right;
  const double y_0 = top + height - margin_bottom;
  const double y_1 = top + margin_top + legend_space;
  const Scale x(panel.x, panel.series, &Series::x, x_0, x_1);
  const Scale y(panel.y, panel.series, &Series::y, y_0, y_1);
  std::string out = text(x_0, top + 16.0, "start", panel.title, " class=\"title\"");
  for (const double tick : x.ticks()) {
    out += line(x.at(tick), y_0, x.at(tick), y_1, "grid");
    out += text(x.at(tick), y_0 + 16.0, "middle", number(tick, 6));
  }
  for (const double tick : y.ticks()) {
    out += line(x_0, y.at(tick), x_1, y.at(tick), "grid");
    out += text(x_0 - 7.0, y.at(tick) + 4.0, "end", number(tick, 6));
  }
  out += line(x_0, y_0, x_1, y_0, "axis") + line(x_0, y_0, x_0, y_1, "axis");
  out += text(0.5 * (x_0 + x_1), y_0 + 36.0, "middle", panel.x.label);
  const double middle = 0.5 * (y_0 + y_1);
  out += text(left + 14.0, middle, "middle", panel.y.label,
              " transform=\"rotate(-90 " + point(left + 14.0, middle) + ")\"");
  for (const Series& s : panel.series) {
    out += curve(s, x, y);
  }
  return out + legend(panel, x_0, top + margin_top, legend_columns(width));
}

}  // namespace

std::string svg(const Figure& figure) {
  const int rows = (static_cast<int>(figure.panels.size()) + figure.columns - 1) / figure.columns;
  const double legend_space = legend_height(figure);
  const double height = figure.height + legend_space;
  const std::string width_of_all = pixel(figure.width * figure.columns);
  const std::string height_of_all = pixel(height * rows + head);
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + width_of_all + " " +
                    height_of_all + "\" width=\"" + width_of_all + "\" height=\"" + height_of_all +
                    "\" role=\"img\">\n<title>" + figure.title + "</title>\n" + style +
                    "<rect class=\"back\" width=\"100%\" height=\"100%\"/>\n" +
                    text(14.0, 24.0, "start", figure.title, " class=\"head\"");
  int at = 0;
  for (const Panel& panel : figure.panels) {
    const int row = at / figure.columns;
    out += drawn(panel, figure.width * (at % figure.columns), head + height * row, figure.width, height,
                 legend_space);
    ++at;
  }
  return out + "</svg>\n";
}

}  // namespace rivid::study
