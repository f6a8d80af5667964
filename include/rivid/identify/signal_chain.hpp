#pragma once

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
  std::vector<Index> left_out;              ///< rows of each joint below its velocity threshold, (n)
  /// Convention `matlab` with decimation: triangles of the rows (10) before decimation, whose |diag R| it prints.
  std::vector<RowGroup> undecimated;
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
/// @throws InputError where log, robot and options do not fit together, where the log itself can not be used (see
///                    Log::complaint(): its clock must be uniform), or no row is left
[[nodiscard]] Rows rows(const Robot& robot, const BaseParameters& base, const Log& log,
                        const SignalOptions& options);

/// Triangles of [W_j Y_j], one group a joint.
[[nodiscard]] std::vector<RowGroup> factors(const Rows& rows);

}  // namespace rivid
