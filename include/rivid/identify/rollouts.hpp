#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/comparison.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/control.hpp"

namespace rivid {

struct RolloutOptions {
  std::vector<double> horizons = {0.1, 0.3, 1.0, 3.0};  ///< [s]
  int windows = 40;  ///< of each log and horizon at most; they do not overlap
  /// Part of each log that they lie in, as in SignalOptions [s]; a log without a sample in it stays whole.
  std::optional<std::array<double, 2>> window = {};
  /// p-value, times the number of tests, below which one model is called better.
  double level = 0.01;
  /// Of the actual robot; empty: rollouts are driven by torques alone. Gains that follow the plant follow
  /// that of the first model, for all models.
  Control control = {};
  Sampling sampling = {};   ///< of that control
  double cutoff_hz = 20.0;  ///< of the positions that the states at the start come from, at most f_m / 5 [Hz]

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// Judges models by the motions that they make: windows of the logs are simulated from the state that was
/// measured at their start, driven by the torques of the log, and by its controller, and compared at their
/// end.
///
/// Each window has for a pair of models the score (e_a² − e_b²) / (e_a² + e_b²), e² being the squared errors
/// of positions and velocities, each in units of that joint's standard deviation in the logs: between −1 and
/// 1, however errors grow with time. A window that one model alone is lost in counts ±1. paired_test()
/// decides whether their mean is zero.
///
/// Open loop, errors grow by the dynamics alone, so that few seconds say more of the initial state than of
/// the model. Laws with an integral are left out: what the integral was at the start of a window is not
/// logged.
///
/// @throws InputError  where a model, a log or the options can not be used
[[nodiscard]] Rollouts rollouts(std::span<const ComparedModel> models, std::span<const Log> logs,
                                const RolloutOptions& options = {});

}  // namespace rivid
