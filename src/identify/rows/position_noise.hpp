#pragma once

#include <vector>

#include "rivid/identify/rows.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/types.hpp"

namespace rivid::detail {

// Part of squared differences that measures noise, the small ones; a choice: the others contain reversals and
// outliers.
inline constexpr double quiet_part = 0.95;
// Mean square of a normal variable within the quantile of that part, in units of its variance:
// 1 - 2 · 1.96 φ(1.96) / 0.95.
inline constexpr double quiet_square = 0.7588;
// Σ of the squared binomial coefficients of the fourth difference: 1 + 16 + 36 + 16 + 1.
inline constexpr double fourth_difference_power = 70.0;

// Variances of the noise of a joint's velocity and acceleration.
struct DerivativeNoise {
  double velocity = 0.0;
  double acceleration = 0.0;
};

// What makes rows of positions, as gains over frequency: differences, averages, position filter and the
// window of the decimation.
class RowBand {
 public:
  // The band of rows; of paper rows too, whose decimation filter is taken for an ideal one.
  RowBand(const SignalOptions& signal, double f_m);
  // Of central differences of positions that a zero-phase filter has seen.
  RowBand(const Filter& filter, double f_m);

  // Variance of the velocity of rows, over that of white noise of positions.
  [[nodiscard]] double velocity_gain() const { return velocity.sum(); }

  // Frequencies [Hz], and by what a spectral density there contributes to both variances.
  Vector frequencies;
  Vector velocity;
  Vector acceleration;

 private:
  explicit RowBand(double f_m);
};

// What of a joint's logged positions is no motion, by octaves of frequency: white noise, quantisation, jitter
// of the clock, repeated samples, vibrations.
//
// Fourth differences of the series, of its means over 2 samples, over 4, …, each see an octave and next to
// nothing of what is slower. The motion takes the low octaves, where accelerations are the larger the lower
// the frequency; noise takes the high ones, where it is the other way round. The first valley of the
// acceleration's spectrum, from the highest octave on, parts them; below it noise is taken for as large as
// there, which overestimates it: the octave of the valley has some of the motion in it.
class PositionNoise {
 public:
  // q  positions, (n_m) [rad | m]
  PositionNoise(const Eigen::Ref<const Vector>& q, double f_m);

  // Of rows that are made with this band.
  [[nodiscard]] DerivativeNoise in(const RowBand& band) const;
  // Where motion ends and noise begins [Hz].
  [[nodiscard]] double valley() const { return valley_; }
  // Standard deviation of the noise if it were white, outliers aside [rad | m].
  [[nodiscard]] double deviation() const { return deviation_; }
  // Mean square of the acceleration below that.
  [[nodiscard]] double motion() const { return motion_; }
  // That of rows that are made with this band.
  [[nodiscard]] double motion_in(const RowBand& band) const;

 private:
  // Variance of the white noise that has the density of this frequency.
  [[nodiscard]] double level(double frequency) const;
  [[nodiscard]] std::size_t octave(double frequency) const;

  double f_m_ = 0.0;
  std::vector<double> levels_;   // of the noise, one an octave, the highest first
  std::vector<double> motions_;  // of all that is below the valley, zero above
  double valley_ = 0.0;
  double deviation_ = 0.0;
  double motion_ = 0.0;
};

}  // namespace rivid::detail
