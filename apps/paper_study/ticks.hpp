#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace rivid::study {

/// Round numbers for the axis of a plot: four to eleven, 1, 2 or 5 times a power of ten apart. The first is
/// `low` or below, the last `high` or above.
///
/// @param high        above `low`
/// @param least_step  between them: 1 for what is counted
[[nodiscard]] inline std::vector<double> round_ticks(double low, double high, double least_step = 0.0) {
  const double wanted = (high - low) / 5.0;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  const double lead = wanted / decade;
  const double step = std::max(least_step, decade * (lead < 1.5   ? 1.0
                                                     : lead < 3.5 ? 2.0
                                                     : lead < 7.5 ? 5.0
                                                                  : 10.0));
  // A multiple that is missed by rounding alone counts as met.
  constexpr double rounding = 1e-9;
  const auto first = std::llround(std::floor(low / step + rounding));
  const auto last = std::llround(std::ceil(high / step - rounding));
  std::vector<double> out;
  for (auto i = first; i <= last; ++i) {
    out.push_back(static_cast<double>(i) * step);
  }
  return out;
}

}  // namespace rivid::study
