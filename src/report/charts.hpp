#pragma once

#include <string>

#include "report/document.hpp"

// Charts, heat maps, skeletons and dot plots as pictures, each in a figure that report.js finds by its identifier.
namespace rivid::detail {

[[nodiscard]] std::string drawn(const Chart& chart);
[[nodiscard]] std::string drawn(const HeatMap& map);
[[nodiscard]] std::string drawn(const Skeleton& skeleton);
[[nodiscard]] std::string drawn(const DotPlot& plot);

}  // namespace rivid::detail
