#pragma once

#include <array>
#include <complex>

#include "rivid/rows_target.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// decimate() of Convention::standard for series that come block by block and may be of any length: memory does not
/// grow with the number of samples. The result is that of the whole series at once, whatever the blocks.
///
/// The zero-phase filter H(z) H(1/z) is split into its modes, y[k] = Σ_i r_i Σ_m p_i^|m| x[k + m] with poles p_i and
/// residues r_i. A mode is a recursion forwards and one backwards that need only be known at the kept samples: a segment
/// of n_d samples enters through inner products, and nothing recurs at the measuring rate. What later samples still add
/// to a row fades with the slowest pole; a row is finished where that lies below the rounding of doubles.
class StreamingDecimator {
 public:
  /// @param columns  of the series
  /// @param n_d      at least 2
  /// @param wanted   samples that room() must offer at times; where fewer are wanted than it takes anyway, fewer come
  /// @throws InputError  where an argument lies outside
  StreamingDecimator(Index columns, int n_d, Index wanted = 0);

  /// Adds samples.
  ///
  /// @param x  (count × columns), count ≥ 0
  /// @return   the rows that are finished by now, (0 or more × columns)
  /// @throws InputError  where x has another number of columns
  [[nodiscard]] Matrix add(const Eigen::Ref<const Matrix>& x);

  /// Ends the series and returns the rows that were still open. The series counts as constant before its first sample
  /// and beyond its last. Afterwards a new series may begin.
  [[nodiscard]] Matrix finish();

  /// Room for the next samples, at least one: who makes samples writes them here instead of handing them to add(). It
  /// holds until anything else is called.
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
  Matrix
      buffer_;  // samples that wait for complete segments, from row `lead` on; the first of a series lies before it
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
