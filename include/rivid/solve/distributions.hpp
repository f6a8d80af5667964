#pragma once

namespace rivid {

/// P(X > x) of a chi-square variable: the p-value of a test statistic.
///
/// @param freedom  degrees of freedom, positive
[[nodiscard]] double chi_square_tail(double x, double freedom);

/// P(X > x) of an F variable.
///
/// @param freedom_1  degrees of freedom of the numerator, positive
/// @param freedom_2  of the denominator, positive
[[nodiscard]] double f_tail(double x, double freedom_1, double freedom_2);

/// The 97.5 % quantile of Student's t distribution: half the width of a 95 % interval in standard deviations.
///
/// @param freedom  degrees of freedom, at least 1
[[nodiscard]] double student_quantile_975(double freedom);

}  // namespace rivid
