#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/observation.hpp"
#include "rivid/signal/convention.hpp"
#include "rivid/solve/least_squares.hpp"

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

/// Rows of a log, Eqs. (10–14): filtered positions, central differences, observation matrix, parallel decimation
/// of Y and of every column of W, borders and slow samples left out.
///
/// @throws InputError where log, robot and options do not fit together, or no row is left
[[nodiscard]] Rows rows(const Robot& robot, const BaseParameters& base, const Log& log,
                        const SignalOptions& options);

/// Triangles of [W_j Y_j], one group a joint.
[[nodiscard]] std::vector<RowGroup> factors(const Rows& rows);

}  // namespace rivid
