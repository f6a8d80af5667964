#pragma once

#include <functional>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/signal_options.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/observation.hpp"
#include "rivid/solve/least_squares.hpp"

namespace rivid {

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
  /// The same of the rows (10) before decimation, whose |diag R| convention `matlab` prints; empty without decimation
  /// and in other conventions.
  std::vector<RowGroup> undecimated;
  std::vector<Index> left_out;     ///< as in Rows, (n)
  std::vector<double> thresholds;  ///< as in Rows, (n); of several logs the largest
};

/// A log that was recorded on the motors' side of the gears, on the joint side: q = R⁻¹ q_motor, its velocity and
/// reference likewise, τ = Rᵀ τ_motor with R = Robot::gears(). Control signals stay as they are, see effort().
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

/// Rows of a log, Eqs. (10–14): filtered positions, central differences, observation matrix, parallel decimation
/// of Y and of every column of W, borders and slow samples left out.
///
/// All of W is held in memory; factors() needs no more than the log for logs of any length.
///
/// @throws InputError where log, robot and options do not fit together, where the log itself can not be used (see
///                    Log::complaint(): its clock must be uniform), or no row is left
[[nodiscard]] Rows rows(const Robot& robot, const BaseParameters& base, const Log& log,
                        const SignalOptions& options);

/// The rows of a log, factored while they are made: a piece of W and Y is filled, decimated and eliminated before the
/// next one is made. Beside the log and its filtered positions (and torques, where they are filtered or made from control
/// signals) that takes some 7 kB of memory for each column of each joint, without growing with the log. Convention
/// `matlab` with decimation holds all rows instead.
///
/// @param threads   that share the work; the result is the same, bit by bit, whatever their number
/// @param progress  called now and then with the fraction done, 0 to 1, by the calling thread
/// @throws InputError where rows() throws it, or threads is not positive
[[nodiscard]] RowFactors factors(const Robot& robot, const BaseParameters& base, const Log& log,
                                 const SignalOptions& options, int threads = 1,
                                 const std::function<void(double)>& progress = {});

}  // namespace rivid
