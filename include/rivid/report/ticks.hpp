#pragma once

#include <vector>

namespace rivid {

/// Round numbers for the axis of a plot: four to eleven, 1, 2 or 5 times a power of ten apart. The first is `low` or below,
/// the last `high` or above.
///
/// @param high        above `low`
/// @param least_step  between them: 1 for what is counted
[[nodiscard]] std::vector<double> round_ticks(double low, double high, double least_step = 0.0);

}  // namespace rivid
