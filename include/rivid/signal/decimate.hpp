#pragma once

#include <vector>

#include "rivid/signal/convention.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// The low-pass in front of a decimation by n_d: Chebyshev of the first kind, order 8, 0.05 dB, cut-off
/// 0.8 f_m / (2 n_d), section 2 of [RIV]; the identity for n_d = 1.
///
/// Convention::matlab leaves |H(0)| at −0.05 dB, so that decimate() shrinks what it is given by 1.1 %, torque
/// and regressor alike. Convention::standard has |H(0)| = 1: a decimated series keeps its unit and its mean.
///
/// @throws InputError  where n_d < 1
[[nodiscard]] Filter decimation_filter(int n_d, Convention convention = Convention::standard);

/// Which samples a decimation by n_d keeps, counted from 0, ceil(n_m / n_d) of them.
///
/// - Convention::standard: 0, n_d, 2 n_d, …: the instants k n_d / f_m, whatever the length of the series, so
///   two logs, or a log and its beginning, are sampled alike.
/// - Convention::matlab: the last sample and each n_d-th before it; counted from 1,
///   n_d − (n_d ceil(n_m / n_d) − n_m) : n_d : n_m.
///
/// @param n_m  length of the series
/// @throws InputError  where n_d < 1
[[nodiscard]] std::vector<Index> kept_samples(Index n_m, int n_d,
                                              Convention convention = Convention::standard);

/// The same for several stages, one after the other; the samples are those of one stage by the product.
[[nodiscard]] std::vector<Index> kept_samples(Index n_m, const std::vector<int>& stages,
                                              Convention convention = Convention::standard);

/// One stage of the parallel decimation, Eqs. (13, 14) of [RIV]: the zero-phase filter with the gain of
/// decimation_filter(n_d) forwards and backwards, then kept_samples(). It is linear and treats columns alike, so Y = Wχ
/// holds after it as before, at the ends too.
///
/// - Convention::standard: the series counts as constant before its first sample and beyond its last. It is the work of
///   StreamingDecimator, which serves series of any length block by block.
/// - Convention::matlab: zero_phase() with MATLAB's padding. MATLAB's decimate loses accuracy in its polynomials and
///   lowers the order from n_d = 15 on; this one does not follow it there, and agrees up to n_d = 13, MATLAB's own
///   advice for one stage. x must have more than 24 samples.
///
/// @param x  series, (n_m × columns), any unit
/// @return   (ceil(n_m / n_d) × columns), in the unit of x
/// @throws InputError  where n_d < 1 or x is too short
[[nodiscard]] Matrix decimate(const Eigen::Ref<const Matrix>& x, int n_d,
                              Convention convention = Convention::standard);

/// Several stages, one after the other: decimate(x, {10, 10}) by 10 and by 10 again.
[[nodiscard]] Matrix decimate(const Eigen::Ref<const Matrix>& x, const std::vector<int>& stages,
                              Convention convention = Convention::standard);

/// By how much classical standard deviations of a least-squares estimate from decimated rows come out too small where the
/// errors of the rows were white before: the filter takes more of them away than it takes rows,
///
///   sqrt(n_d · mean |H|⁴)
///
/// over the frequencies up to half the rate, H being one pass of the filter and the product that of all stages; 0.91 for
/// one stage. To undo it, divide by it.
///
/// @throws InputError  where a stage is below 1
[[nodiscard]] double deviation_factor(const std::vector<int>& stages,
                                      Convention convention = Convention::standard);

}  // namespace rivid
