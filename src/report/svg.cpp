#include "report/svg.hpp"

#include <algorithm>
#include <cmath>

#include "report/markup.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

std::string coordinate(double x) { return fixed(x, 1); }

std::string svg_line(std::string_view kind, Point from, Point to) {
  return "<line class=\"" + std::string(kind) + "\" x1=\"" + coordinate(from[0]) + "\" y1=\"" +
         coordinate(from[1]) + "\" x2=\"" + coordinate(to[0]) + "\" y2=\"" + coordinate(to[1]) + "\"/>";
}

std::string svg_dot(std::string_view kind, Point at, double r) {
  return "<circle class=\"" + std::string(kind) + "\" cx=\"" + coordinate(at[0]) + "\" cy=\"" +
         coordinate(at[1]) + "\" r=\"" + coordinate(r) + "\"/>";
}

// Between two corners.
std::string svg_box(std::string_view kind, Point a, Point b) {
  return "<rect class=\"" + std::string(kind) + "\" x=\"" + coordinate(std::min(a[0], b[0])) + "\" y=\"" +
         coordinate(std::min(a[1], b[1])) + "\" width=\"" + coordinate(std::abs(b[0] - a[0])) +
         "\" height=\"" + coordinate(std::abs(b[1] - a[1])) + "\"/>";
}

// @param anchor  "start", "middle" or "end": what of the text is at the point
std::string svg_text(std::string_view anchor, Point at, std::string_view content) {
  return element("text", escaped(content),
                 "text-anchor=\"" + std::string(anchor) + "\" x=\"" + coordinate(at[0]) + "\" y=\"" +
                     coordinate(at[1]) + "\"");
}

std::string polyline(std::string_view kind, const std::vector<Point>& points) {
  std::string list;
  for (const auto& [x, y] : points) {
    list += coordinate(x) + "," + coordinate(y) + " ";
  }
  return "<polyline class=\"" + std::string(kind) + "\" points=\"" + list + "\"/>";
}

// @param label  text for a reader who does not see the plot
std::string svg_picture(Point size, const std::string& label, const std::string& content,
                        const std::string& more) {
  const std::string w = number(size[0]);
  const std::string h = number(size[1]);
  return element("svg", element("title", escaped(label)) + content,
                 "role=\"img\" width=\"" + w + "\" height=\"" + h + "\" viewBox=\"0 0 " + w + " " + h + "\"" +
                     (more.empty() ? "" : " " + more));
}

}  // namespace rivid::detail
