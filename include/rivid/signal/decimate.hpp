#pragma once

#include <array>
#include <complex>
#include <vector>

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
/// decimation_filter(n_d) forwards and backwards, then kept_samples(). It is linear and treats columns alike,
/// so Y = Wχ holds after it as before, at the ends too.
///
/// - Convention::standard: the series counts as constant before its first sample and beyond its last. It is
///   the work of StreamingDecimator, which serves series of any length block by block.
/// - Convention::matlab: zero_phase() with MATLAB's padding. MATLAB's decimate loses accuracy in its
///   polynomials and lowers the order from n_d = 15 on; this one does not follow it there, and agrees up to
///   n_d = 13, MATLAB's own advice for one stage. x must have more than 24 samples.
///
/// @param x  series, (n_m × columns), any unit
/// @return   (ceil(n_m / n_d) × columns), in the unit of x
/// @throws InputError  where n_d < 1 or x is too short
[[nodiscard]] Matrix decimate(const Eigen::Ref<const Matrix>& x, int n_d,
                              Convention convention = Convention::standard);

/// Several stages, one after the other: decimate(x, {10, 10}) by 10 and by 10 again.
[[nodiscard]] Matrix decimate(const Eigen::Ref<const Matrix>& x, const std::vector<int>& stages,
                              Convention convention = Convention::standard);

/// By how much classical standard deviations of a least-squares estimate from decimated rows come out too
/// small where the errors of the rows were white before: the filter takes more of them away than it takes
/// rows,
///
///   sqrt(n_d · mean |H|⁴)
///
/// over the frequencies up to half the rate, H being one pass of the filter and the product that of all
/// stages; 0.91 for one stage. To undo it, divide by it.
///
/// @throws InputError  where a stage is below 1
[[nodiscard]] double deviation_factor(const std::vector<int>& stages,
                                      Convention convention = Convention::standard);

/// decimate() of Convention::standard for series that come block by block and may be of any length: memory
/// does not grow with the number of samples. The result is that of the whole series at once, whatever the
/// blocks.
///
/// The zero-phase filter H(z) H(1/z) is split into its modes, y[k] = Σ_i r_i Σ_m p_i^|m| x[k + m] with poles
/// p_i and residues r_i. A mode is a recursion forwards and one backwards that need only be known at the kept
/// samples: a segment of n_d samples enters through inner products, and nothing recurs at the measuring rate.
/// What later samples still add to a row fades with the slowest pole; a row is finished where that lies below
/// the rounding of doubles.
class StreamingDecimator {
 public:
  /// @param columns  of the series
  /// @param n_d      at least 2
  /// @param wanted   samples that room() must offer at times; where fewer are wanted than it takes anyway,
  ///                 fewer come
  /// @throws InputError  where an argument lies outside
  StreamingDecimator(Index columns, int n_d, Index wanted = 0);

  /// Adds samples.
  ///
  /// @param x  (count × columns), count ≥ 0
  /// @return   the rows that are finished by now, (0 or more × columns)
  /// @throws InputError  where x has another number of columns
  [[nodiscard]] Matrix add(const Eigen::Ref<const Matrix>& x);

  /// Ends the series and returns the rows that were still open. The series counts as constant before its
  /// first sample and beyond its last. Afterwards a new series may begin.
  [[nodiscard]] Matrix finish();

  /// Room for the next samples, at least one: who makes samples writes them here instead of handing them to
  /// add(). It holds until anything else is called.
  [[nodiscard]] RowsRoom room();
  /// Adds the first samples of the room.
  ///
  /// @throws InputError  for more than fit
  void commit(Index samples);
  /// Ends the series: all its rows are finished then. A new one may begin once they are taken.
  void end();

  /// Rows that are finished and not taken.
  [[nodiscard]] Index finished() const;
  /// Takes the oldest finished rows.
  ///
  /// @throws InputError  for more than finished()
  void take(Index count, const RowsTarget& to);

 private:
  static constexpr Index modes = 4;  // pairs of conjugate poles of the order-8 filter
  using Complex = std::complex<double>;
  using Modes = std::array<Complex, modes>;

  void begin();
  void process(Index first, Index segments, const Matrix& later);
  [[nodiscard]] Index batch() const;

  Index n_d_;
  double direct_ = 0.0;  // coefficient of x[k] beside the modes
  Modes pole_{};         // p_i, the slowest mode first
  Modes residue_{};      // 2 r_i, the conjugate pole's share included
  // What the kernel reads, see src/signal/signal_kernels.hpp.
  Matrix weights_;
  std::array<double, 2 * modes> step_{};
  std::array<double, 2 * modes> shown_{};
  Matrix fading_;
  std::array<long, modes> reach_{};

  bool begun_ = false;
  Matrix buffer_;  // samples that wait for complete segments, from row `lead` on; the first of a series lies
                   // before it
  Index capacity_ = 0;
  Index filled_ = 0;
  Matrix forward_;  // (2 modes × columns) forward states at the last row, real parts above imaginary ones
  Matrix open_;     // rows that are not taken, those that later samples still change the last
  Index open_first_ = 0;
  Index open_count_ = 0;
  Matrix unknown_;  // (2 modes × columns) of zeros: backward states while later samples are to come
  Vector folded_;   // scratch of the kernel
};

}  // namespace rivid
