#pragma once

#include <span>

#include "rivid/types.hpp"

namespace rivid {

/// P(X > x) of a chi-square variable: the p-value of a test statistic.
///
/// @param freedom  degrees of freedom, positive, at most 1e12
/// @return         not a number where x is none, freedom lies outside of this, or no digit is found
[[nodiscard]] double chi_square_tail(double x, double freedom);

/// P(X > x) of an F variable.
///
/// @param freedom_1  degrees of freedom of the numerator, positive, at most 1e12
/// @param freedom_2  of the denominator, alike
/// @return           not a number where x is none, a freedom lies outside of this, or no digit is found
[[nodiscard]] double f_tail(double x, double freedom_1, double freedom_2);

/// The 97.5 % quantile of Student's t distribution: half the width of a 95 % interval in standard deviations.
///
/// @param freedom  degrees of freedom, at least 1
/// @return         not a number for less
[[nodiscard]] double student_quantile_975(double freedom);

/// Long-run covariance of sums of correlated vectors, after Newey & West (1987): with Bartlett weights,
///
///   S = Σ_t s_t s_tᵀ + Σ_{l = 1}^{L} (1 − l / (L + 1)) Σ_t (s_t s_{t−l}ᵀ + s_{t−l} s_tᵀ),
///
/// positive semidefinite, estimates the covariance of Σ_t s_t where the s_t have mean zero.
///
/// @param series  each (T × columns), a row for each instant; of several logs one each, between which nothing
///                is correlated
/// @param lag     L, at least 0
/// @return        S, (columns × columns)
/// @throws InputError  where the numbers of columns differ, or the lag is negative or above 1e8
[[nodiscard]] Matrix long_run_covariance(std::span<const Matrix> series, Index lag);

/// The lag L for the same by the rule of Andrews (1991), Eqs. (6.2) and (6.4) there, with a first-order
/// autoregression for each column and columns weighted by the inverse square of their variance.
///
/// @throws InputError  where the numbers of columns differ
[[nodiscard]] Index bartlett_lag(std::span<const Matrix> series);

/// 97.5 % quantile of a t statistic whose variance is of long_run_covariance(), in units of the normal one:
/// it grows with the part of the series that the lag takes, after Kiefer & Vogelsang (2005), table 1.
///
/// @param part  (L + 1) / T, between 0 and 1
[[nodiscard]] double fixed_lag_widening(double part);

}  // namespace rivid
