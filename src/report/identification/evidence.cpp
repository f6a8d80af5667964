#include "report/identification/evidence.hpp"

#include <algorithm>

#include "report/analysis.hpp"

namespace rivid::detail {

std::span<const Prediction> Evidence::fitted() const {
  const auto first = std::ranges::find(logs, true, &Prediction::validation);
  return {logs.begin(), first};
}

std::span<const Prediction> Evidence::validation() const { return logs.subspan(fitted().size()); }

std::string chart_id(const std::string& kind, std::size_t joint, std::size_t log) {
  return kind + "-" + std::to_string(joint + 1) + (log == 0 ? "" : "-log-" + std::to_string(log + 1));
}

std::string speed_unit(const Joint& joint) { return joint.type == JointType::revolute ? "rad/s" : "m/s"; }

std::string position_unit(const Joint& joint) { return joint.type == JointType::revolute ? "rad" : "m"; }

Series cloud(const std::string& name, const std::string& style, const Vector& x, const Vector& y) {
  const std::vector<Index> some = every_few(x.size(), most_points);
  return {name, style, Series::Kind::points, x(some), y(some)};
}

}  // namespace rivid::detail
