#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/fields.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/batch.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/solve/least_squares.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// How filtered signals become rows.
enum class RowScheme {
  automatic,  ///< exact; paper in Convention::matlab
  /// Section 2 of [RIV]: every sample makes a row, low-pass filters decimate them.
  paper,
  /// Rows that hold exactly, but for noise: torques are averaged as central differences average
  /// accelerations, what a filter does to positions it does to torques, rows of a joint that touch a reversal
  /// or standstill are left out, and decimation is a window that reaches over no gap. docs/rows.md compares
  /// the two.
  exact
};

template <>
inline constexpr std::array names_of<RowScheme> =
    std::to_array<std::string_view>({"automatic", "paper", "exact"});

/// The way from a log to the rows of Eq. (13) of [RIV]; each step can be switched off.
struct SignalOptions {
  RowScheme rows = RowScheme::automatic;
  /// Whether a torque acts from its sample until the next one, as that of a sampled controller does; else it
  /// is what was measured at the sample. Nothing lets identify() find out where the rows are chosen by it,
  /// and is false elsewhere.
  std::optional<bool> torque_held = {};
  double cutoff_hz = 0.0;         ///< of the zero-phase low-pass of the positions [Hz]; 0 is none
  int order = 4;                  ///< of that Butterworth filter, for one direction
  double torque_cutoff_hz = 0.0;  ///< of a zero-phase low-pass of the torques [Hz]; 0 is none
  int torque_order = 4;
  /// Factors of the parallel decimation, one a stage, n_d being their product; {1} is none. Empty lets
  /// identify() choose the window of exact rows without a position filter by the noise of the log, see
  /// RowChoice, and is none elsewhere.
  std::vector<int> decimation = {};
  /// Samples left out at the beginning and at the end, counted at the measuring rate before decimation;
  /// nothing lets the position filter decide (the samples that its borders spoil, see settling_samples()).
  std::optional<std::array<Index, 2>> trim = {};
  /// Rows of joint j are left out where |q̇_j| is below velocity_threshold[j] [rad/s | m/s]; empty keeps all,
  /// but for those that RowScheme::exact leaves out by itself. Where the window is chosen, empty is a
  /// twentieth of the joint's rms velocity.
  std::vector<double> velocity_threshold = {};
  /// Only rows with window[0] ≤ t ≤ window[1] [s] are kept; samples outside still serve the filters.
  std::optional<std::array<double, 2>> window = {};
  /// Padding, decimation phase and the formula of the residual's deviation, see Convention.
  Convention convention = Convention::standard;

  /// Whether identify() is to choose the rows.
  [[nodiscard]] bool automatic() const { return decimation.empty() && cutoff_hz == 0.0 && exact_rows(); }
  [[nodiscard]] bool held() const { return torque_held.value_or(false); }
  [[nodiscard]] bool exact_rows() const {
    return rows == RowScheme::exact || (rows == RowScheme::automatic && convention == Convention::standard);
  }

  /// @param n  joints of the robot
  [[nodiscard]] std::optional<std::string> complaint(Index n) const;

  template <typename S = SignalOptions>
  static constexpr auto fields() {
    return std::tuple(
        Field{"rows",
              &S::rows,
              "`\"exact\"`: rows without errors but noise; `\"paper\"`: every sample, as in [RIV]. "
              "`\"automatic\"`: exact, unless `convention = \"matlab\"`",
              {.otherwise = "see [rows](rows.md)"}},
        Field{"torque_held",
              &S::torque_held,
              "the torque of a sample acts until the next one; else it was measured at the sample. "
              "`\"auto\"`: decided by the log if `decimation` is `\"auto\"`, else false",
              {.otherwise = "`\"auto\"`", .word = "auto"}},
        Field{"cutoff_hz",
              &S::cutoff_hz,
              "cut-off of the zero-phase Butterworth low-pass of the positions, some ten times the highest "
              "frequency of the motion; exact rows need none",
              {.otherwise = "`\"off\"`",
               .unit = "Hz",
               .range = rate_range,
               .word = "off",
               .must_be = "a frequency in Hz, or \"off\" for no filter"}},
        Field{"order", &S::order, "of that filter, for one direction", {.range = Range::within(1, 20)}},
        Field{"torque_cutoff_hz",
              &S::torque_cutoff_hz,
              "cut-off of a zero-phase Butterworth low-pass of the torques",
              {.otherwise = "`\"off\"`",
               .unit = "Hz",
               .range = rate_range,
               .word = "off",
               .must_be = "a frequency in Hz, or \"off\" for no filter"}},
        Field{"torque_order",
              &S::torque_order,
              "of that filter",
              {.otherwise = "that of `order`", .range = Range::within(1, 20)}},
        Field{"decimation",
              &S::decimation,
              "n_d of (13), or factors of stages: `[10, 10]` keeps one sample in 100. `\"auto\"`: by the "
              "noise of the log, see [rows](rows.md); without exact rows, or with `cutoff_hz`, none",
              {.otherwise = "`\"auto\"`", .range = Range::from(1, 1e6), .word = "auto"}},
        Field{"trim",
              &S::trim,
              "left out at the ends, counted at the measuring rate",
              {.otherwise = "`\"auto\"`",
               .unit = "samples",
               .range = Range::from(0, 1e9),
               .word = "auto",
               .must_be = "one number of samples for both ends, [begin, end], or \"auto\""}},
        Field{"velocity_threshold",
              &S::velocity_threshold,
              "rows of a joint that moves slower are left out",
              {.otherwise = "0; a twentieth of the rms velocity where `decimation` is chosen",
               .unit = "rad/s, m/s",
               .range = Range::from(0, 1e6)}},
        Field{"window",
              &S::window,
              "only samples with begin ≤ t ≤ end give rows",
              {.otherwise = "whole log",
               .unit = "s",
               .range = Range::within(-1e12, 1e12),
               .must_be = "[begin, end] in seconds"}},
        Field{"convention", &S::convention, "`\"standard\"` or `\"matlab\"`, see [below](#conventions)"});
  }
};

/// The rows of one log: W and Y of Eq. (13), joint by joint.
struct Rows {
  std::vector<std::vector<Index>> samples;  ///< for each joint the samples of the log that its rows stand for
  Observation W;                            ///< (rows_j × own columns) for each joint
  std::vector<Vector> Y;                    ///< (rows_j) for each joint [N·m | N]
  std::vector<Index> left_out;  ///< rows of each joint that are missing: slow ones, or near a reversal, (n)
  std::vector<double>
      thresholds;  ///< velocity below which rows of each joint are left out, (n) [rad/s | m/s]
};

/// What least squares needs of the rows of one log, see rows(): their orthogonal factors.
struct RowFactors {
  std::vector<RowGroup> groups;  ///< triangle of [W_j Y_j] of each joint, (n)
  /// The same of the rows (10) before decimation, whose |diag R| convention `matlab` prints; empty without
  /// decimation and in other conventions.
  std::vector<RowGroup> undecimated;
  std::vector<Index> left_out;     ///< as in Rows, (n)
  std::vector<double> thresholds;  ///< as in Rows, (n); of several logs the largest
};

/// A log that was recorded on the motors' side of the gears, on the joint side: q = R⁻¹ q_motor, its velocity
/// and reference likewise, τ = Rᵀ τ_motor with R = Robot::gears(). Control signals stay as they are, see
/// effort().
///
/// @param log  its angles and torques are those of the motors, in the order of the joints
/// @throws InputError where the log has a number of columns that does not fit the robot
[[nodiscard]] Log joint_side(const Robot& robot, Log log);

/// Torques of a log on the joint side, τ = G v_τ (8): the torque columns where the log has them, else the
/// control signal times Robot::drive_matrix(), (n_m × n) [N·m | N].
///
/// @throws InputError where the log has neither, or a number of columns that does not fit the robot
[[nodiscard]] Matrix effort(const Robot& robot, const Log& log);

/// Parallel decimation of every column, Eqs. (13, 14); see the decimate() of a series.
[[nodiscard]] Observation decimate(Observation W, int n_d, Convention convention = Convention::standard);

/// Rows of a log, Eqs. (10–14): filtered positions, central differences, observation matrix, parallel
/// decimation of Y and of every column of W, borders and slow samples left out.
///
/// All of W is held in memory; factors() needs no more than the log for logs of any length.
///
/// @throws InputError where log, robot and options do not fit together, where the log itself can not be used
///                    (see Log::complaint(): its clock must be uniform), or no row is left
[[nodiscard]] Rows rows(const Robot& robot, const BaseParameters& base, const Log& log,
                        const SignalOptions& options);

/// The rows of a log, factored while they are made: a piece of W and Y is filled, decimated and eliminated
/// before the next one is made. Beside the log and its filtered positions (and torques, where they are
/// filtered or made from control signals) that takes some 7 kB of memory for each column of each joint,
/// without growing with the log. Convention `matlab` with decimation holds all rows instead.
///
/// @param threads   that share the work; the result is the same, bit by bit, whatever their number
/// @param progress  called now and then with the fraction done, 0 to 1, by the calling thread
/// @throws InputError where rows() throws it, or threads is not positive
[[nodiscard]] RowFactors factors(const Robot& robot, const BaseParameters& base, const Log& log,
                                 const SignalOptions& options, int threads = 1,
                                 const std::function<void(double)>& progress = {});

}  // namespace rivid
