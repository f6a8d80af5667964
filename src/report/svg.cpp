#include "report/svg.hpp"

#include "report/markup.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

std::string coordinate(double x) { return fixed(x, 1); }

std::string svg_line(std::string_view kind, double x1, double y1, double x2, double y2) {
  return "<line class=\"" + std::string(kind) + "\" x1=\"" + coordinate(x1) + "\" y1=\"" + coordinate(y1) +
         "\" x2=\"" + coordinate(x2) + "\" y2=\"" + coordinate(y2) + "\"/>";
}

std::string svg_dot(std::string_view kind, double x, double y, double r) {
  return "<circle class=\"" + std::string(kind) + "\" cx=\"" + coordinate(x) + "\" cy=\"" + coordinate(y) +
         "\" r=\"" + coordinate(r) + "\"/>";
}

std::string svg_box(std::string_view kind, double x, double y, double width, double height) {
  return "<rect class=\"" + std::string(kind) + "\" x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) +
         "\" width=\"" + coordinate(width) + "\" height=\"" + coordinate(height) + "\"/>";
}

std::string svg_text(std::string_view anchor, double x, double y, std::string_view content) {
  return element(
      "text", escaped(content),
      "text-anchor=\"" + std::string(anchor) + "\" x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) + "\"");
}

std::string svg_picture(double width, double height, const std::string& title, const std::string& content) {
  return element("svg", element("title", escaped(title)) + content,
                 "role=\"img\" width=\"" + number(width) + "\" height=\"" + number(height) +
                     "\" viewBox=\"0 0 " + number(width) + " " + number(height) + "\"");
}

}  // namespace rivid::detail
