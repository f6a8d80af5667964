#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

// Elements of pictures in SVG. What they are called by is for the style sheet.
namespace rivid::detail {

using Point = std::array<double, 2>;

// A coordinate in tenths of a pixel.
[[nodiscard]] std::string coordinate(double x);
[[nodiscard]] std::string svg_line(std::string_view kind, Point from, Point to);
[[nodiscard]] std::string svg_dot(std::string_view kind, Point at, double r);
// Between two corners.
[[nodiscard]] std::string svg_box(std::string_view kind, Point a, Point b);
// @param anchor  "start", "middle" or "end": what of the text is at the point
[[nodiscard]] std::string svg_text(std::string_view anchor, Point at, std::string_view content);
[[nodiscard]] std::string polyline(std::string_view kind, const std::vector<Point>& points);
// @param label  text for a reader who does not see the picture
// @param more   attributes
[[nodiscard]] std::string svg_picture(Point size, const std::string& label, const std::string& content,
                                      const std::string& more = {});

}  // namespace rivid::detail
