#pragma once

#include "report/document.hpp"
#include "rivid/excite/excitation.hpp"
#include "rivid/experiment/excitation.hpp"

// What the page of a motion shows in pictures.
namespace rivid::detail {

// A motion with its forecast.
struct ForecastMotion {
  const ExcitationPlan& plan;
  const Motion& motion;
  const Forecast& forecast;
};

// The joints at a glance beside the path of the last joint among the obstacles.
[[nodiscard]] std::vector<Block> motion_at_a_glance(const ForecastMotion& of);
// The distances of the nearest pairs that are kept apart.
[[nodiscard]] Block clearances_over_time(const ForecastMotion& of);
// q, q̇, q̈ and τ of each joint over time with their limits.
[[nodiscard]] Section motion_section(const ForecastMotion& of);
// What the rows of each joint contribute, and when.
[[nodiscard]] Section information_section(const ForecastMotion& of);

}  // namespace rivid::detail
