#pragma once

#include <span>
#include <vector>

#include "rivid/types.hpp"

namespace rivid::detail {

/// The window: h_m, |m| < n_d, (2 n_d − 1).
[[nodiscard]] Vector decimation_window(Index n_d);

/// Decimation by a Hann window of twice the stride around chosen samples of a series that comes block by
/// block: row c is Σ_m h_m x[c + m], |m| < n_d, with h_m = (1 + cos(π m / n_d)) / (2 n_d). What lies n_d
/// samples away from a row takes no part in it, which no recursive filter can say, so that gaps of a series
/// stay gaps.
class WindowDecimator {
 public:
  /// @param columns  of the series
  /// @param n_d      stride that the window is made for, at least 1
  /// @param centres  samples of the series, counted from 0, that rows are wanted for, ascending; those whose
  ///                 window would begin before the series are not allowed, those whose window ends beyond it
  ///                 never come
  WindowDecimator(Index columns, Index n_d, std::vector<Index> centres);

  /// Room for the next samples, at least one; it holds until anything else is called. Finished rows must be
  /// taken before.
  [[nodiscard]] RowsRoom room();
  /// Adds the first samples of the room.
  void commit(Index samples);
  /// Rows that are finished and not taken.
  [[nodiscard]] Index finished() const;
  /// Takes the oldest finished rows.
  void take(Index count, const RowsTarget& to);

 private:
  Index n_d_;
  std::vector<Index> centres_;
  std::size_t next_ = 0;  // of the centres
  Vector window_;         // h, (2 n_d − 1)
  Matrix buffer_;
  Index first_ = 0;  // sample in row 0 of the buffer
  Index filled_ = 0;
};

}  // namespace rivid::detail
