#pragma once

#include <vector>

#include "rivid/types.hpp"

namespace rivid {

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
/// @param order      number of poles, 1 or more, odd ones included
/// @param cutoff_hz  f_c, from 1e-5 f_m to below f_m / 2 [Hz]
/// @param f_m        measuring rate [Hz]
/// @throws InputError  where an argument lies outside
[[nodiscard]] Filter butterworth(int order, double cutoff_hz, double f_m);

/// Chebyshev low-pass of the first kind: ripples between 0 and −ripple_db up to the cut-off, where |H| is
/// −ripple_db for the last time. With an even order |H(0)| is −ripple_db too, with an odd one 1.
///
/// @param order      number of poles, 1 or more
/// @param ripple_db  positive [dB]
/// @param cutoff_hz  from 1e-5 f_m to below f_m / 2 [Hz]
/// @param f_m        measuring rate [Hz]
/// @throws InputError  where an argument lies outside
[[nodiscard]] Filter chebyshev1(int order, double ripple_db, double cutoff_hz, double f_m);

/// |H| at a frequency, one pass of the filter; zero_phase() has its square.
///
/// @param f_hz  frequency [Hz]
/// @param f_m   measuring rate [Hz]
[[nodiscard]] double gain(const Filter& filter, double f_hz, double f_m);

/// Samples after which the filter has forgotten its start: the smallest m, at least the order, with
/// r^m ≤ level, where r is the modulus of the pole nearest to the unit circle. At each end of a series so many
/// samples carry the padding of zero_phase() beside the data: the number to drop where none is given.
///
/// @param level  what is left of a transient, between 0 and 1
/// @throws InputError  for any other level
[[nodiscard]] Index settling_samples(const Filter& filter, double level = 1e-3);

}  // namespace rivid
