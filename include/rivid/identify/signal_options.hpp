#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/signal/convention.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// How filtered signals become rows.
enum class RowScheme {
  automatic,  ///< exact; paper in Convention::matlab
  /// Section 2 of [RIV]: every sample makes a row, low-pass filters decimate them.
  paper,
  /// Rows that hold exactly, but for noise: torques are averaged as central differences average accelerations, what a
  /// filter does to positions it does to torques, rows of a joint that touch a reversal or standstill are left out, and
  /// decimation is a window that reaches over no gap. docs/rows.md compares the two.
  exact
};

/// "automatic", "paper", "exact".
[[nodiscard]] std::string_view name(RowScheme scheme);

/// The way from a log to the rows of Eq. (13) of [RIV]; each step can be switched off.
struct SignalOptions {
  RowScheme rows = RowScheme::automatic;
  /// Whether a torque acts from its sample until the next one, as that of a sampled controller does; else it is what was
  /// measured at the sample.
  bool torque_held = false;
  double cutoff_hz = 0.0;         ///< of the zero-phase low-pass of the positions [Hz]; 0 is none
  int order = 4;                  ///< of that Butterworth filter, for one direction
  double torque_cutoff_hz = 0.0;  ///< of a zero-phase low-pass of the torques [Hz]; 0 is none
  int torque_order = 4;
  /// Factors of the parallel decimation, one a stage, n_d being their product; empty is none.
  std::vector<int> decimation = {};
  /// Samples left out at the beginning and at the end, counted at the measuring rate before decimation; nothing
  /// lets the position filter decide (the samples that its borders spoil, see settling_samples()).
  std::optional<std::array<Index, 2>> trim = {};
  /// Rows of joint j are left out where |q̇_j| is below velocity_threshold[j] [rad/s | m/s]; empty keeps all, but for those
  /// that RowScheme::exact leaves out by itself.
  std::vector<double> velocity_threshold = {};
  /// Only rows with window[0] ≤ t ≤ window[1] [s] are kept; samples outside still serve the filters.
  std::optional<std::array<double, 2>> window = {};
  /// Padding, decimation phase and the formula of the residual's deviation, see Convention.
  Convention convention = Convention::standard;

  [[nodiscard]] bool exact_rows() const {
    return rows == RowScheme::exact || (rows == RowScheme::automatic && convention == Convention::standard);
  }

  /// @param n  joints of the robot
  [[nodiscard]] std::optional<std::string> complaint(Index n) const;
};

}  // namespace rivid
