#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "rivid/signal/convention.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// The way from a log to the rows of Eq. (13) of [RIV]; each step can be switched off.
struct SignalOptions {
  double cutoff_hz = 0.0;         ///< of the zero-phase low-pass of the positions [Hz]; 0 is none
  int order = 4;                  ///< of that Butterworth filter, for one direction
  double torque_cutoff_hz = 0.0;  ///< of a zero-phase low-pass of the torques [Hz]; 0 is none
  int torque_order = 4;
  /// Factors of the parallel decimation, one a stage, n_d being their product; empty is none.
  std::vector<int> decimation = {};
  /// Samples left out at the beginning and at the end, counted at the measuring rate before decimation; nothing
  /// lets the position filter decide (the samples that its borders spoil, see settling_samples()).
  std::optional<std::array<Index, 2>> trim = {};
  /// Rows of joint j are left out where |q̇_j| is below velocity_threshold[j] [rad/s | m/s]; empty keeps all.
  std::vector<double> velocity_threshold = {};
  /// Only rows with window[0] ≤ t ≤ window[1] [s] are kept; samples outside still serve the filters.
  std::optional<std::array<double, 2>> window = {};
  /// Padding, decimation phase and the formula of the residual's deviation, see Convention.
  Convention convention = Convention::standard;

  /// @param n  joints of the robot
  [[nodiscard]] std::optional<std::string> complaint(Index n) const;
};

}  // namespace rivid
