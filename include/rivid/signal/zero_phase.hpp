#pragma once

#include "rivid/signal/convention.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Each column filtered forwards, then backwards: gain |H|², phase zero, section 2 of [RIV].
///
/// Both ends are padded by odd reflection, x[−k] = 2 x[0] − x[k], and each pass starts in the steady state of
/// the first sample it meets. The result is linear in x; with |H(0)| = 1 a constant stays, and so does a
/// straight line, up to what the padding leaves of the start.
///
/// How long the padding is:
/// - Convention::standard: settling_samples(filter, 1e-6), at most n_m − 1. The start of a pass is then
///   forgotten where the data begin, and only the reflection is felt there; a longer padding changes nothing.
///   The reflection is odd about the end samples, so these pass as they are, noise and all: drop the ends.
/// - Convention::matlab: 3 · order, the 3 (max(n_a, n_b) − 1) of MATLAB's filtfilt for a filter
///   given as (b, a). At a low cut-off the end samples then depend on that length.
///
/// Columns are taken eight at a time; besides the result, one buffer of 8 (n_m + twice the padding) numbers
/// is allocated. A value that is not finite spoils its own column.
///
/// @param x  series, (n_m × columns), any unit, with n_m > 3 · order
/// @return   (n_m × columns), in the unit of x
/// @throws InputError  where x is too short
[[nodiscard]] Matrix zero_phase(const Eigen::Ref<const Matrix>& x, const Filter& filter,
                                Convention convention = Convention::standard);

/// The same with butterworth(order, cutoff_hz, f_m); the gain at the cut-off is 1/2.
///
/// @param f_m        measuring rate [Hz]
/// @param cutoff_hz  [Hz]
/// @throws InputError  where x is too short or butterworth() refuses its arguments
[[nodiscard]] Matrix zero_phase(const Eigen::Ref<const Matrix>& x, double f_m, double cutoff_hz,
                                int order = 4, Convention convention = Convention::standard);

}  // namespace rivid
