#pragma once

#include "rivid/types.hpp"

namespace rivid {

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
