#pragma once

#include <vector>

#include "rivid/fields.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Whose habits decide where a choice is free: the padding of zero_phase(), and the padding, the scale and
/// the kept samples of decimate(). Once the border samples are dropped (settling_samples()) the padding no
/// longer matters.
enum class Convention {
  standard,  ///< rivid's own, argued at the functions that take it
  matlab     ///< that of MATLAB's filtfilt and decimate, to reproduce what was published with them
};
template <>
inline constexpr std::array names_of<Convention> = std::to_array<std::string_view>({"standard", "matlab"});

/// H(z) = (b0 + b1 z⁻¹ + b2 z⁻²) / (1 + a1 z⁻¹ + a2 z⁻²); a section of first order has b2 = a2 = 0.
struct SecondOrderSection {
  double b0 = 1.0;
  double b1 = 0.0;
  double b2 = 0.0;
  double a1 = 0.0;
  double a2 = 0.0;
};

/// A low-pass as a cascade of sections, the least resonant one first. Without a section it is the identity.
///
/// One polynomial (b, a) of the same filter would lose 7e-7 at order 4 and everything at order 8, at a
/// cut-off of 0.002 Nyquist; sections do not.
struct Filter {
  std::vector<SecondOrderSection> sections;
  int order = 0;
};

/// Butterworth low-pass: |H|² = 1 / (1 + (tan(π f / f_m) / tan(π f_c / f_m))^(2 order)), by the bilinear
/// transform with prewarping, so that |H(f_c)|² = 1/2 exactly. |H(0)| is 1 for the coefficients as rounded.
///
/// @param order      number of poles, 1 to 100, odd ones included
/// @param cutoff_hz  f_c, from 1e-5 f_m to below f_m / 2 [Hz]
/// @param f_m        measuring rate [Hz]
/// @throws InputError  where an argument lies outside
[[nodiscard]] Filter butterworth(int order, double cutoff_hz, double f_m);

/// Chebyshev low-pass of the first kind: ripples between 0 and −ripple_db up to the cut-off, where |H| is
/// −ripple_db for the last time. With an even order |H(0)| is −ripple_db too, with an odd one 1.
///
/// @param order      number of poles, 1 to 100
/// @param ripple_db  positive [dB]
/// @param cutoff_hz  from 1e-5 f_m to f_m / 2 - 1e-5 f_m [Hz]
/// @param f_m        measuring rate [Hz]
/// @throws InputError  where an argument lies outside
[[nodiscard]] Filter chebyshev1(int order, double ripple_db, double cutoff_hz, double f_m);

/// |H| at a frequency, one pass of the filter; zero_phase() has its square.
///
/// @param f_hz  frequency [Hz]
/// @param f_m   measuring rate [Hz]
[[nodiscard]] double gain(const Filter& filter, double f_hz, double f_m);

/// Samples after which the filter has forgotten its start: the smallest m, at least the order, with r^m ≤
/// level, where r is the modulus of the pole nearest to the unit circle. At each end of a series so many
/// samples carry the padding of zero_phase() beside the data: the number to drop where none is given.
///
/// @param level  what is left of a transient, between 0 and 1
/// @throws InputError  for any other level
[[nodiscard]] Index settling_samples(const Filter& filter, double level = 1e-3);

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

/// ẋ[k] = (x[k+1] − x[k−1]) f_m / 2 of each column, without phase shift; the first and the last sample take
/// the one-sided difference to their neighbour. Exact on parabolas, but for these two.
///
/// @param x    series, (n_m × columns), any unit, n_m ≥ 2
/// @param f_m  measuring rate [Hz]
/// @return     (n_m × columns), in the unit of x per second
/// @throws InputError  where x is too short or f_m is not positive and finite
[[nodiscard]] Matrix central_difference(const Eigen::Ref<const Matrix>& x, double f_m);

/// q with its derivatives, section 2 of [RIV]: q̇ is the central difference of q, q̈ that of q̇.
///
/// q is taken as it is; filter it first, see zero_phase(). Inside,
/// q̈[k] = (q[k+2] − 2 q[k] + q[k−2]) f_m² / 4; the one-sided ends spoil two samples of q̈ at each end.
///
/// @param q    positions, (n_m × n) [rad | m], n_m ≥ 2
/// @param f_m  measuring rate [Hz]
/// @throws InputError  as central_difference() does
[[nodiscard]] Motion differentiate(const Eigen::Ref<const Matrix>& q, double f_m);

}  // namespace rivid
