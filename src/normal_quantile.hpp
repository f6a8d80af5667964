#pragma once

namespace rivid::detail {

/// 97.5 % of the normal distribution, to all digits of a double: half of a 95 % confidence interval, in
/// standard deviations.
inline constexpr double normal_quantile_975 = 1.959963984540054;

}  // namespace rivid::detail
