#pragma once

#include <string>
#include <string_view>

// Small pictures within a page; report.css says how their classes look.
namespace rivid::detail {

[[nodiscard]] std::string coordinate(double x);
[[nodiscard]] std::string svg_line(std::string_view kind, double x1, double y1, double x2, double y2);
[[nodiscard]] std::string svg_dot(std::string_view kind, double x, double y, double r);
[[nodiscard]] std::string svg_box(std::string_view kind, double x, double y, double width, double height);
// @param anchor  "start", "middle" or "end": what of the text is at x
[[nodiscard]] std::string svg_text(std::string_view anchor, double x, double y, std::string_view content);
// @param title  what a reader who does not see it is told
[[nodiscard]] std::string svg_picture(double width, double height, const std::string& title,
                                      const std::string& content);

}  // namespace rivid::detail
