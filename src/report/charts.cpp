#include "report/charts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "dense.hpp"
#include "report/markup.hpp"
#include "report/scale.hpp"
#include "report/svg.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// ---------------------------------------------------------------------------------------------- scales

Scale abscissa_of(const Chart& chart) {
  std::vector<const Vector*> values;
  for (const Series& series : chart.series) {
    values.push_back(&series.x);
  }
  return {range_of(values, chart.x_shown, false), false, Scale::Ends::data};
}

Scale ordinate_of(const Chart& chart) {
  std::vector<const Vector*> values;
  for (const Series& series : chart.series) {
    if (!series.on_demand) {
      values.push_back(&series.y);
      values.push_back(&series.upper);
    }
  }
  return {range_of(values, chart.y_shown, chart.logarithmic), chart.logarithmic, Scale::Ends::ticks};
}

constexpr double panel_width = 360.0;
constexpr double wide_width = 1120.0;
constexpr double digit_width = 6.5;
constexpr double under_plot = 38.0;  // ticks and label of the abscissa

struct PlotArea {
  double left = 0.0;
  double top = 0.0;
  double right = 0.0;
  double bottom = 0.0;
};

// ---------------------------------------------------------------------------------------------- series

// Pieces of a curve between its gaps, in pixels; of many points in one column of pixels the lowest and the highest.
std::vector<std::vector<Point>> pieces(const Series& series, const Scale& x, const Scale& y) {
  constexpr double column = 2.0;
  std::vector<std::vector<Point>> out;
  bool open = false;
  for (Index k = 0; k < series.x.size(); ++k) {
    if (!std::isfinite(series.y[k])) {
      open = false;
      continue;
    }
    const Point at = {x.at(series.x[k]), y.at(series.y[k])};
    if (!open) {
      out.emplace_back();
      open = true;
    }
    std::vector<Point>& piece = out.back();
    const auto same = [&](const Point& p) { return std::floor(p[0] / column) == std::floor(at[0] / column); };
    if (piece.size() >= 2 && same(piece.back()) && same(piece[piece.size() - 2])) {
      Point& first = piece[piece.size() - 2];
      Point& second = piece.back();
      const double least = std::min({first[1], second[1], at[1]});
      const double most = std::max({first[1], second[1], at[1]});
      const bool falling = first[1] > second[1];
      first[1] = falling ? most : least;
      second[1] = falling ? least : most;
    } else {
      piece.push_back(at);
    }
  }
  return out;
}

std::string path(std::string_view kind, const std::string& d) {
  return "<path class=\"" + std::string(kind) + "\" d=\"" + d + "\"/>";
}

std::string curve_picture(const Series& series, const Scale& x, const Scale& y) {
  std::string d;
  for (const std::vector<Point>& piece : pieces(series, x, y)) {
    for (std::size_t k = 0; k < piece.size(); ++k) {
      d += (k == 0 ? "M" : k == 1 ? "L" : " ") + coordinate(piece[k][0]) + " " + coordinate(piece[k][1]);
    }
    if (piece.size() == 1) {
      d += "h.1";
    }
  }
  return path("curve " + series.style, d);
}

std::string cloud_picture(const Series& series, const Scale& x, const Scale& y) {
  std::string d;
  for (Index k = 0; k < series.x.size(); ++k) {
    if (std::isfinite(series.y[k])) {
      d += "M" + coordinate(x.at(series.x[k])) + " " + coordinate(y.at(series.y[k])) + "h0";
    }
  }
  return path("cloud " + series.style, d);
}

std::string band_picture(const Series& series, const Scale& x, const Scale& y) {
  std::string d;
  Index first = 0;
  const Index size = series.x.size();
  while (first < size) {
    Index end = first;
    while (end < size && std::isfinite(series.y[end])) {
      ++end;
    }
    for (Index k = first; k < end; ++k) {
      d += (k == first ? "M" : " ") + coordinate(x.at(series.x[k])) + " " + coordinate(y.at(series.y[k]));
    }
    for (Index k = end - 1; k >= first; --k) {
      d += " " + coordinate(x.at(series.x[k])) + " " + coordinate(y.at(series.upper[k]));
    }
    d += end > first ? "Z" : "";
    first = end + 1;
  }
  return path("area " + series.style, d);
}

std::string bars_picture(const Series& series, const Scale& x, const Scale& y) {
  if (series.x.size() == 0) {
    return {};
  }
  const double step = series.x.size() > 1 ? series.x[1] - series.x[0] : 1.0;
  const double half = std::max(0.45 * std::abs(x.at(series.x[0] + step) - x.at(series.x[0])), 0.5);
  std::string out;
  for (Index k = 0; k < series.x.size(); ++k) {
    if (std::isfinite(series.y[k])) {
      const double middle = x.at(series.x[k]);
      out += svg_box("bar " + series.style, {middle - half, y.at(0.0)}, {middle + half, y.at(series.y[k])});
    }
  }
  return out;
}

std::string picture_of(const Series& series, const Scale& x, const Scale& y) {
  switch (series.kind) {
    case Series::Kind::points:
      return cloud_picture(series, x, y);
    case Series::Kind::band:
      return band_picture(series, x, y);
    case Series::Kind::bars:
      return bars_picture(series, x, y);
    case Series::Kind::line:
      break;
  }
  return curve_picture(series, x, y);
}

std::string legend_of(const Chart& chart) {
  std::string out;
  for (const Series& series : chart.series) {
    if (series.in_legend && !series.name.empty() && !series.on_demand) {
      const std::string kind = series.kind == Series::Kind::points ? "key dot "
                               : series.kind == Series::Kind::line ? "key "
                                                                   : "key area ";
      out += element(
          "span",
          element("span", "", "class=\"" + kind + escaped(series.style) + "\"") + escaped(series.name),
          "class=\"item\"");
    }
  }
  return chart.series.size() > 1 ? element("p", out, "class=\"legend\"") : std::string();
}

std::string caption(const std::string& title, const std::string& remark) {
  return element("figcaption", element("b", escaped(title)) + (remark.empty() ? "" : " " + escaped(remark)));
}

std::string chart_figure(const std::string& kind, const std::string& id, const std::string& more,
                         const std::string& content) {
  return element("figure", content, "class=\"chart " + kind + "\" id=\"" + escaped(id) + "\"" + more) + "\n";
}

// Grid, ticks and label; a tick without room has no number.
std::string abscissa(const Scale& x, const std::string& label, const PlotArea& frame) {
  std::string out;
  double last = -std::numeric_limits<double>::infinity();
  for (const double tick : x.ticks()) {
    const double at = x.at(tick);
    out += svg_line("grid", {at, frame.top}, {at, frame.bottom});
    const std::string words = number(tick, 6);
    const double width = digit_width * static_cast<double>(words.size()) + 6.0;
    if (at - last >= width) {
      out += svg_text("middle", {at, frame.bottom + 15.0}, words);
      last = at;
    }
  }
  return out + svg_text("middle", {0.5 * (frame.left + frame.right), frame.bottom + 32.0}, label);
}

std::string ordinate(const Scale& y, const std::string& label, const PlotArea& frame) {
  std::string out;
  for (const double tick : y.ticks()) {
    out +=
        svg_line(tick == 0.0 ? "grid origin" : "grid", {frame.left, y.at(tick)}, {frame.right, y.at(tick)});
    out += svg_text("end", {frame.left - 5.0, y.at(tick) + 4.0}, number(tick, 6));
  }
  return out + element("text", escaped(label),
                       "text-anchor=\"middle\" transform=\"translate(11 " +
                           coordinate(0.5 * (frame.top + frame.bottom)) + ") rotate(-90)\"");
}

std::string in_figure(const std::string& kind, const std::string& id, const std::string& title,
                      const std::string& remark, const std::string& picture) {
  return chart_figure(kind, id, "", caption(title, remark) + element("div", picture, "class=\"picture\""));
}

// ---------------------------------------------------------------------------------------------- in space

// Directions of the picture's right and down, from the side and from above.
Eigen::Matrix<double, 2, 3> view() {
  const double yaw = -0.9;
  const double pitch = 0.42;
  Eigen::Matrix<double, 2, 3> out;
  out << std::cos(yaw), std::sin(yaw), 0.0,  //
      std::sin(pitch) * std::sin(yaw), -std::sin(pitch) * std::cos(yaw), -std::cos(pitch);
  return out;
}

std::string ellipse_picture(const Skeleton::Ellipsoid& body, const Eigen::Matrix<double, 2, 3>& P,
                            const Eigen::Vector2d& middle, double pixels) {
  const Eigen::Matrix<double, 2, 3> A = P * body.axes;
  const SymmetricEigen outline = symmetric_eigen(A * A.transpose());
  const Eigen::Vector2d radius = pixels * outline.values.cwiseMax(0.0).cwiseSqrt();
  const Eigen::Vector2d major = outline.vectors.col(1);
  const Eigen::Vector2d at = middle + pixels * (P * body.centre);
  return "<ellipse class=\"" + escaped(body.style) + "\" rx=\"" + coordinate(radius[1]) + "\" ry=\"" +
         coordinate(radius[0]) + "\" transform=\"translate(" + coordinate(at[0]) + " " + coordinate(at[1]) +
         ") rotate(" + coordinate(std::atan2(major[1], major[0]) * 180.0 / std::numbers::pi) + ")\">" +
         element("title", escaped(body.name)) + "</ellipse>";
}

}  // namespace

std::string drawn(const Chart& chart) {
  Scale x = abscissa_of(chart);
  Scale y = ordinate_of(chart);
  std::size_t longest = 1;
  for (const double tick : y.ticks()) {
    longest = std::max(longest, number(tick, 6).size());
  }
  const double width = chart.size == Chart::Size::wide ? wide_width : panel_width;
  const PlotArea frame{26.0 + digit_width * static_cast<double>(longest), 6.0, width - 10.0,
                       chart.height - under_plot};
  x.lay(frame.left, frame.right);
  y.lay(frame.bottom, frame.top);
  std::string content = abscissa(x, chart.x_label, frame) + ordinate(y, chart.y_label, frame);
  for (const Series& series : chart.series) {
    content += series.on_demand ? std::string() : picture_of(series, x, y);
  }
  for (const Rule& rule : chart.rules) {
    content +=
        rule.upright
            ? svg_line("rule " + rule.style, {x.at(rule.at), frame.top}, {x.at(rule.at), frame.bottom})
            : svg_line("rule " + rule.style, {frame.left, y.at(rule.at)}, {frame.right, y.at(rule.at)});
  }
  const std::string place = "data-frame=\"" + coordinate(frame.left) + " " + coordinate(frame.top) + " " +
                            coordinate(frame.right) + " " + coordinate(frame.bottom) + "\" data-x=\"" +
                            x.words() + "\" data-y=\"" + y.words() + "\"";
  const std::string log = chart.log ? " data-log=\"" + std::to_string(*chart.log) + "\"" : std::string();
  return chart_figure(chart.size == Chart::Size::wide ? "wide" : "panel", chart.id, log,
                      caption(chart.title, chart.remark) + legend_of(chart) +
                          element("div", svg_picture({width, chart.height}, chart.label, content, place),
                                  "class=\"picture\""));
}

std::string drawn(const HeatMap& map) {
  constexpr double name_width = 62.0;
  constexpr double top = 26.0;  // of the first name that stands above its column
  const auto count = static_cast<Index>(map.names.size());
  const double cell = std::clamp(620.0 / static_cast<double>(count), 8.0, 30.0);
  const double size = cell * static_cast<double>(count);
  constexpr int levels = 10;
  std::array<std::array<std::string, levels + 1>, 2> cells;
  std::string content;
  const auto column = [&](Index j) { return name_width + cell * static_cast<double>(j); };
  const auto row = [&](Index i) { return top + cell * static_cast<double>(i); };
  for (Index i = 0; i < count; ++i) {
    for (Index j = 0; j < i; ++j) {
      const double r = map.values(i, j);
      if (std::isfinite(r)) {
        cells[r < 0.0 ? 1 : 0][static_cast<std::size_t>(std::lround(std::min(std::abs(r), 1.0) * levels))] +=
            "M" + coordinate(column(j)) + " " + coordinate(row(i)) + "h" + coordinate(cell - 0.6) + "v" +
            coordinate(cell - 0.6) + "h-" + coordinate(cell - 0.6) + "z";
      }
    }
    const std::string& name = map.names[static_cast<std::size_t>(i)];
    content += svg_text("end", {name_width - 4.0, row(i) + 0.5 * cell + 4.0}, name);
    content += element("text", escaped(name),
                       "transform=\"translate(" + coordinate(column(i) + 0.5 * cell + 3.0) + " " +
                           coordinate(row(i) + cell - 1.0) + ") rotate(-50)\"");
  }
  for (std::size_t side = 0; side < cells.size(); ++side) {
    for (std::size_t level = 1; level < cells[side].size(); ++level) {
      if (!cells[side][level].empty()) {
        content += "<path class=\"" + std::string(side == 0 ? "together" : "against") + "\" opacity=\"" +
                   coordinate(static_cast<double>(level) / levels) + "\" d=\"" + cells[side][level] + "\"/>";
      }
    }
  }
  const std::string place =
      "data-heat=\"" + coordinate(name_width) + " " + coordinate(top) + " " + coordinate(cell) + "\"";
  return in_figure("heat", map.id, map.title, "",
                   svg_picture({name_width + size + 40.0, top + size + 4.0}, map.label, content, place));
}

std::string drawn(const Skeleton& skeleton) {
  constexpr double width = 620.0;
  constexpr double height = 440.0;
  constexpr double margin = 30.0;
  const Eigen::Matrix<double, 2, 3> P = view();
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3d& joint : skeleton.joints) {
    box.extend(Eigen::Vector2d(P * joint));
  }
  for (const Skeleton::Ellipsoid& body : skeleton.ellipsoids) {
    const Eigen::Vector2d reach = (P * body.axes).rowwise().norm();
    box.extend(Eigen::Vector2d(P * body.centre + reach));
    box.extend(Eigen::Vector2d(P * body.centre - reach));
  }
  for (const Skeleton::Trace& trace : skeleton.traces) {
    for (const Eigen::Vector3d& point : trace.points) {
      box.extend(Eigen::Vector2d(P * point));
    }
  }
  const Eigen::Vector2d span = box.sizes().cwiseMax(1e-3);
  const double pixels = std::min((width - 2.0 * margin) / span[0], (height - 2.0 * margin) / span[1]);
  const Eigen::Vector2d middle = Eigen::Vector2d(0.5 * width, 0.5 * height) - pixels * box.center();
  std::string content;
  for (const Skeleton::Trace& trace : skeleton.traces) {
    std::vector<Point> points;
    for (const Eigen::Vector3d& point : trace.points) {
      const Eigen::Vector2d at = middle + pixels * (P * point);
      points.push_back({at[0], at[1]});
    }
    content += polyline("trace " + trace.style, points);
  }
  for (const Skeleton::Ellipsoid& body : skeleton.ellipsoids) {
    content += ellipse_picture(body, P, middle, pixels);
  }
  std::vector<Point> line;
  std::string dots;
  for (const Eigen::Vector3d& joint : skeleton.joints) {
    const Eigen::Vector2d at = middle + pixels * (P * joint);
    line.push_back({at[0], at[1]});
    dots += svg_dot("joint", line.back(), 3.0);
  }
  return in_figure("skeleton", skeleton.id, skeleton.title, "",
                   svg_picture({width, height}, skeleton.label, content + polyline("arm", line) + dots));
}

std::string drawn(const DotPlot& plot) {
  constexpr double row = 17.0;
  double least = plot.reference;
  double most = plot.reference;
  for (const DotPlot::Dot& each : plot.dots) {
    if (std::isfinite(each.interval.value)) {
      least = std::min(least, each.interval.low);
      most = std::max(most, each.interval.high);
    }
  }
  const PlotArea frame{58.0, 8.0, panel_width - 12.0, 12.0 + row * static_cast<double>(plot.dots.size())};
  Scale x({least, most}, false, Scale::Ends::ticks);
  x.lay(frame.left, frame.right);
  const auto upright = [&](double value) { return std::array{x.at(value), frame.top}; };
  std::string content = abscissa(x, plot.x_label, frame);
  content += svg_box("band", upright(plot.wanted[0]), {x.at(plot.wanted[1]), frame.bottom});
  content += svg_line("reference", upright(plot.reference), {x.at(plot.reference), frame.bottom});
  for (std::size_t i = 0; i < plot.dots.size(); ++i) {
    const double y = frame.top + row * (static_cast<double>(i) + 0.5) + 2.0;
    const auto& [name, interval, mark] = plot.dots[i];
    content += svg_text("end", {frame.left - 6.0, y + 4.0}, name);
    if (std::isfinite(interval.value)) {
      const std::string off = mark == Mark::bad ? " off" : "";
      content += svg_line("whisker" + off, {x.at(interval.low), y}, {x.at(interval.high), y}) +
                 svg_dot("dot" + off, {x.at(interval.value), y}, 3.2);
    }
  }
  return in_figure("panel", plot.id, plot.title, plot.remark,
                   svg_picture({panel_width, frame.bottom + under_plot}, plot.title, content));
}

}  // namespace rivid::detail
