#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/fields.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// How often a fault of the time stamps occurs, and where first.
struct TimeFault {
  Index count = 0;
  Index row = -1;     ///< of the later of the two stamps, from 0; −1 where there is none
  double time = 0.0;  ///< stamp of that row [s]
};

/// What a column of time stamps looks like.
struct TimeReport {
  Index samples = 0;
  double period = 0.0;         ///< median of the steps forward [s]
  double shortest_step = 0.0;  ///< of the steps forward [s]
  double longest_step = 0.0;   ///< [s]
  /// Mean rate, (samples − 1) / (last − first) [Hz], of stamps that are late that of their clock; 0 where
  /// time does not go forward.
  double rate_hz = 0.0;
  TimeFault repeated;      ///< steps below a thousandth of a period: no log has two samples that close
  TimeFault reversed;      ///< steps back
  TimeFault missing;       ///< gaps of k periods, k ≥ 2 after rounding, up to max_gap
  Index missing_rows = 0;  ///< rows that these gaps lack, Σ (k − 1)
  TimeFault jumps;         ///< gaps of more than max_gap periods
  /// Deviation of the stamps from the nearest uniform grid, by least squares between jumps, each stamp at the
  /// grid point that its steps lead to: root mean square and largest, as fractions of a period. Counts
  /// nothing twice: a missing row is no jitter.
  double jitter_rms = 0.0;
  double jitter_max = 0.0;
  /// Stamps that are late on a clock that a fifth or more keep, where none is early: those of the arrival of
  /// samples, which were taken in time. 0 where stamps are off both ways.
  Index late = 0;

  /// Whether the rows may be taken for samples of a uniform clock: nothing repeated, reversed, missing or
  /// jumped, jitter_rms below 1 % and jitter_max below 10 % of a period.
  ///
  /// A stamp that is off by δ periods shifts a sample along its own curve by δ samples. One percent, at
  /// random, moves a central difference by 0.7 % of the velocity in each sample, before any filter averages
  /// it; real arms leave 2 to 5 % of their torque unexplained. The bound on the largest keeps one late row
  /// from hiding in many good ones.
  bool regular = false;

  /// One line: "1000 samples at 99.9 Hz; 3 repeated (first at row 17, t = 0.16 s); jitter 0.2 % rms, 1 % at
  /// most".
  [[nodiscard]] std::string summary() const;
};

/// Default of the gap that ends a piece of a log, in periods.
inline constexpr double default_max_gap = 10.0;

/// Finds what is irregular in time stamps.
///
/// @param t        instants, (n_m) [s]
/// @param max_gap  longest gap that counts as missing rows, in periods, from 2 to 1e9
/// @throws InputError  where t holds a value that is not finite, or max_gap is out of range
[[nodiscard]] TimeReport inspect_time(const Eigen::Ref<const Vector>& t, double max_gap = default_max_gap);

/// What to do with irregular time stamps.
enum class Irregular {
  refuse,    ///< InputError
  resample,  ///< interpolate onto a uniform grid
  ignore     ///< take the rows for uniform samples all the same
};
template <>
inline constexpr std::array names_of<Irregular> =
    std::to_array<std::string_view>({"refuse", "resample", "ignore"});

struct ResampleOptions {
  /// Rate of the new clock [Hz]; default: to resample one over the median period, to ignore the mean rate.
  std::optional<double> rate_hz = {};
  double max_gap = default_max_gap;  ///< longest gap that is interpolated over, in periods, ≥ 2
  Index min_samples = 20;            ///< pieces with fewer rows than this on the new grid are dropped

  template <typename R = ResampleOptions>
  static constexpr auto fields() {
    return std::tuple(Field{"resample_hz",
                            &R::rate_hz,
                            "sampling rate after resampling; implies `irregular = \"resample\"` and "
                            "resamples regular logs too",
                            {.otherwise = "one over the median period", .unit = "Hz", .range = rate_range}},
                      Field{"max_gap",
                            &R::max_gap,
                            "a longer gap splits a log that is resampled",
                            {.unit = "periods", .range = Range::from(2.0, 1e9)}});
  }

  /// The first fault found, nothing if the options can be used.
  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// The log on a uniform clock, as one or more logs; `notes` say what was found and done.
///
/// - refuse: returns the log where its stamps are regular.
/// - ignore: t becomes t(0) + k / rate.
/// - resample: regular stamps are left alone unless a rate is asked for. Of repeated stamps the first row is
///   kept. A gap of more than max_gap periods splits the log. Positions and references follow a cubic spline,
///   torques, control signals and velocities are interpolated linearly. No filter guards against aliasing:
///   where the new rate is much below the old one, filter first.
///
/// @throws InputError  on irregular stamps where they are refused; on stamps that go back, unless they are
///                     ignored; where no piece is long enough
[[nodiscard]] std::vector<Log> regularised(Log log, Irregular irregular, const ResampleOptions& options = {});

}  // namespace rivid
