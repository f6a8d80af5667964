#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "report/documents.hpp"

// What the page of an identification draws, and what its plots have in common.
namespace rivid::detail {

// A result with its logs, those of the identification first.
struct Evidence {
  const Robot& robot;
  const Identification& result;
  std::span<const Prediction> logs;

  [[nodiscard]] std::span<const Prediction> fitted() const { return fitted_logs(logs); }
  [[nodiscard]] std::span<const Prediction> validation() const { return logs.subspan(fitted().size()); }
  [[nodiscard]] std::size_t joints() const { return result.fit.joints.size(); }
  [[nodiscard]] bool empty() const { return logs.empty() || joints() == 0; }
};

inline constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

// Points of a cloud that a panel can show.
inline constexpr Index most_points = 500;

// Identifier of a plot of a joint, and of a log behind the first.
[[nodiscard]] inline std::string chart_id(const std::string& kind, std::size_t joint, std::size_t log = 0) {
  return kind + "-" + std::to_string(joint + 1) + (log == 0 ? "" : "-log-" + std::to_string(log + 1));
}

// Some rows over others as points.
[[nodiscard]] inline Series cloud(const std::string& name, const std::string& style, const Vector& x,
                                  const Vector& y) {
  const std::vector<Index> some = every_few(x.size(), most_points);
  return {name, style, Series::Kind::points, x(some), y(some)};
}

}  // namespace rivid::detail
