#pragma once

#include <span>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

// Least squares from many logs that are read in different places: each log is reduced to factors, the factors
// are merged, and the parameters are identified from what is merged.
namespace rivid {

/// What the velocities of logs add up to.
struct SquaredVelocities {
  Vector sums;         ///< Σ q̇², (n)
  double count = 0.0;  ///< of the addends
};

/// What identify() by least squares needs of logs in place of their samples. Its size does not grow with the
/// logs.
struct LogFactors {
  /// Most blocks of time that are kept.
  static constexpr Index most_blocks = 64;

  RowFactors rows;  ///< of all logs
  /// Factors of the rows of blocks of time, (blocks × n): standard deviations come from how far the blocks
  /// disagree.
  std::vector<std::vector<RowGroup>> blocks;
  SquaredVelocities velocities;
  Index logs = 0;
};

/// Signal options in which nothing is left open, so that all logs are turned into rows alike: where
/// SignalOptions::automatic() asks for it, the rows are chosen by these logs as identify() chooses them.
///
/// @throws InputError  where identify() would throw it
[[nodiscard]] SignalOptions chosen_signal(const Robot& robot, std::span<const Log> logs,
                                          const Estimation& estimation);

/// Factors of one log.
///
/// @param signal   must not be automatic(): chosen_signal()
/// @param blocks   of equal time that the log is divided into, from 1 to LogFactors::most_blocks
/// @param threads  that share the work; no result depends on them
/// @throws InputError  where factors() throws it, and for friction that follows the load: its rows depend on
///                     the parameters
[[nodiscard]] LogFactors log_factors(const Robot& robot, const Log& log, const SignalOptions& signal,
                                     int blocks = 10, int threads = 1);

/// Adds the factors of other logs of the same robot, made with the same options. `rows` merged log by log are
/// those of all logs together, bit by bit; merged in another order they are the same to rounding. Where there
/// are too many blocks, neighbours that have the fewest rows become one.
///
/// @throws InputError  where they have other columns
void merge(LogFactors& into, const LogFactors& other);

/// Identification by ordinary or weighted least squares from factors: estimate, fit and weights are those of
/// identify() from the logs themselves.
///
/// Standard deviations: classical (18), or by default those scaled to what the estimate moves by when a block
/// of time is left out. The autocorrelation of the residuals, which identify() looks at besides, is not
/// known, nor is what tests of the residuals, judging and ParameterEstimate::noise_bias need.
///
/// @param estimation  its signal options are those of the factors
/// @throws InputError  for what needs samples: instrumental variables, robust and essential parameters,
///                     CovarianceKind::hac
[[nodiscard]] Identification identify(const Robot& robot, const LogFactors& factors,
                                      const Estimation& estimation);

}  // namespace rivid
