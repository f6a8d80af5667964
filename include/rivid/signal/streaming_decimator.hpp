#pragma once

#include <array>
#include <complex>

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
  /// @throws InputError  where an argument lies outside
  StreamingDecimator(Index columns, int n_d);

  /// Adds samples.
  ///
  /// @param x  (count × columns), count ≥ 0
  /// @return   the rows that are finished by now, (0 or more × columns)
  /// @throws InputError  where x has another number of columns
  [[nodiscard]] Matrix add(const Eigen::Ref<const Matrix>& x);

  /// Ends the series and returns the rows that were still open. The series counts as constant before its first sample
  /// and beyond its last. Afterwards a new series may begin.
  [[nodiscard]] Matrix finish();

 private:
  static constexpr int modes = 4;  // pairs of conjugate poles of the order-8 filter
  using Complex = std::complex<double>;
  using Modes = std::array<Complex, modes>;

  void begin(const Eigen::Ref<const Eigen::RowVectorXd>& first);
  void process(Index segments);
  void fade(Index column, const Modes& state);
  [[nodiscard]] double shown(const Modes& state) const;
  Index take(Index count, Matrix& out, Index first);

  Index n_d_;
  double direct_ = 0.0;  // coefficient of x[k] beside the modes
  Modes pole_{};         // p_i
  Modes step_{};         // p_i^n_d: from one kept sample to the next
  Modes residue_{};      // 2 r_i, the conjugate pole's share included
  Matrix weights_;  // (4 modes × n_d): the way of a segment's samples into the states, forwards and backwards
  Matrix fading_;   // (2 modes × rows): what a backward state adds to the rows before it, the farthest first

  bool begun_ = false;
  Eigen::RowVectorXd last_;  // last sample, (columns)
  Matrix buffer_;            // (samples × columns) that wait for complete segments
  Index filled_ = 0;
  Matrix forward_;  // (2 modes × columns) forward states at the last row, real parts above imaginary ones
  Matrix open_;     // (rows × columns) that later samples still change
  Index open_count_ = 0;
};

}  // namespace rivid
