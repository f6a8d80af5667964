#pragma once

#include <span>
#include <vector>

#include "rivid/identify/prediction.hpp"

// Distribution, memory and frequencies of the residual.
namespace rivid::detail {

// The residual of one joint's rows over the logs of the identification.
struct ResidualShape {
  Index rows = 0;
  double mean = 0.0;
  double sigma = 0.0;
  double first_edge = 0.0;  // of the histogram …
  double bin = 0.0;         // … and the width of its bins
  std::vector<double> counts;
  Index outside = 0;                    // rows beyond the histogram
  std::vector<double> autocorrelation;  // at lags of 1, 2 … rows; empty where rows are few
};

[[nodiscard]] ResidualShape residual_shape(std::span<const Prediction> predictions, std::size_t joint);

// Amplitudes of sinusoids that fit a series best, one by one: √(a² + b²) of a cos ωt + b sin ωt, root mean
// square over stretches of equal length. Rows need not be evenly spaced [Lomb 1976].
struct Spectrum {
  Vector frequency;    // cycles per unit of the abscissa
  Vector amplitude;    // unit of the series
  double noise = 0.0;  // that white noise of the same variance stays below at 99 % of the frequencies
};

// @param x         ascending, or not
// @param most      highest frequency
// @param count     of frequencies, most / count apart
[[nodiscard]] Spectrum amplitude_spectrum(const Vector& x, const Vector& values, double most, Index count);

}  // namespace rivid::detail
