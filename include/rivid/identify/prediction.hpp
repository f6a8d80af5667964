#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/simulate/dynamic_model.hpp"

namespace rivid {

/// The rows of the fit of one joint, after decimation, and what their torques are made of:
///
///   W χ = gravity + inertia + coriolis + friction
///
/// With M, c and g those of the model, the parts are g(q), M(q) q̈ with the rotors, c(q, q̇), and all that a
/// friction law has, the offset included. Each is decimated as the columns of W are.
struct FittedRows {
  Vector position = {};  ///< mean of what a row reaches over, (rows) [rad | m]
  Vector velocity = {};  ///< the same, (rows) [rad/s | m/s]
  Vector measured = {};  ///< Y, (rows) [N·m | N]
  Vector a_priori = {};  ///< W χ with χ of the robot description, (rows) [N·m | N]
  Vector gravity = {};   ///< (rows) [N·m | N]
  Vector inertia = {};   ///< (rows) [N·m | N]
  Vector coriolis = {};  ///< (rows) [N·m | N]
  Vector friction = {};  ///< (rows) [N·m | N]
  /// Root mean square of each column of W over these rows, (b) [N·m | N per unit of the parameter]; 0 where
  /// the joint does not feel it.
  Vector column_rms = {};

  /// W χ, (rows) [N·m | N].
  [[nodiscard]] Vector predicted() const { return gravity + inertia + coriolis + friction; }
};

/// Torques of one joint along a log, measured and predicted.
struct JointPrediction {
  Vector measured = {};   ///< Y as rows have it, before decimation, (samples) [N·m | N]
  Vector predicted = {};  ///< W χ, (samples) [N·m | N]
  /// Whether the fit takes the sample; else the joint is too slow there, or reverses nearby.
  std::vector<std::uint8_t> kept = {};

  std::vector<Index> rows = {};  ///< samples that the rows of the fit stand for, counted as those above
  Vector residual = {};          ///< Y − W χ of these rows, after decimation [N·m | N]
  FittedRows fitted = {};        ///< these rows
};

/// What an identified model says of the torques of a log, sample by sample.
struct Prediction {
  std::string source = {};  ///< the log's
  bool validation = false;  ///< whether the log took no part in the fit
  double start = 0.0;       ///< instant of the first sample [s]
  double f_m = 0.0;         ///< rate of the samples [Hz]
  Index row_stride = 1;     ///< samples from one row to the next, where none is left out between them
  std::vector<JointPrediction> joints = {};

  [[nodiscard]] Index samples() const { return joints.empty() ? 0 : joints.front().measured.size(); }
};

/// Measured and predicted torques of a log by the signal chain of the identification: the samples that its
/// trim and window leave, at the rate of the log. W is never held, so memory is that of the series.
///
/// @return  not a number in all predictions where chi is not a number
/// @throws InputError where rows() throws it, or the result has not one value for each base parameter
[[nodiscard]] Prediction predict(const Robot& robot, const Identification& identification, const Log& log);

/// A set of parameters that a result has.
enum class ParameterSet {
  estimate,  ///< the base parameters as they were estimated, Identification::chi
  physical   ///< the physically consistent ones that are nearest to them, Identification::physical
};

/// Which numbers of a result a model is made of.
struct IdentifiedModelOptions {
  /// Empty: the physically consistent set where the result has one, else the estimate. That set is the better
  /// one for a controller: M(q) is positive definite everywhere, and friction brakes, see docs/physical.md.
  std::optional<ParameterSet> parameters = std::nullopt;
  bool force = false;  ///< takes a result whose status is not `identified`
};

/// The robot with the numbers of a result, for a controller or a simulation:
///
///   InverseDynamics dynamics(identified_model(robot, result));
///
/// Friction that would drive is taken as zero, see DynamicModel::clamped(); a physically consistent set has
/// none. read_identified_model() makes the same of result.json.
///
/// @param robot   that was identified
/// @throws InputError  where the result is not identified and force was not asked for; where it has not the
///                     set that was asked for, or is that of another robot; as DynamicModel does
[[nodiscard]] DynamicModel identified_model(const Robot& robot, const Identification& result,
                                            const IdentifiedModelOptions& options = {});

}  // namespace rivid
