#pragma once

namespace rivid {

/// The 97.5 % quantile of Student's t distribution: half the width of a 95 % interval in standard deviations.
///
/// @param freedom  degrees of freedom, at least 1
[[nodiscard]] double student_quantile_975(double freedom);

}  // namespace rivid
