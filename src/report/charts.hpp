#pragma once

#include <string>

#include "report/document.hpp"

// Charts, heat maps and skeletons as pictures, each in a figure that report.js finds by its identifier.
namespace rivid::detail {

[[nodiscard]] std::string drawn(const Chart& chart);
[[nodiscard]] std::string drawn(const HeatMap& map);
[[nodiscard]] std::string drawn(const Skeleton& skeleton);

}  // namespace rivid::detail
