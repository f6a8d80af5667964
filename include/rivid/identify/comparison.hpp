#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/model/robot.hpp"

namespace rivid {

/// A model of a robot whose predictions are judged: a result, what a URDF says, or values of one's own.
struct ComparedModel {
  std::string name;
  Robot robot;
  Vector chi_st;  ///< values of robot.standard_parameters(), (N_s) [SI, joint side]
};

struct ComparisonOptions {
  SignalOptions signal = {};  ///< from the logs to rows; the same for all models
  int blocks = 12;            ///< that the logs are cut into at most; at least 6
  /// p-value, times the number of pairs, below which one model is called better.
  double level = 0.01;
  int threads = 1;

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// Squared errors of two models on the same rows, in blocks of time.
struct PairedTest {
  std::size_t a = 0;  ///< models of Comparison::models
  std::size_t b = 0;
  /// Mean squared error of a over that of b, each joint in units of the mean squared error of both on it:
  /// below 1 where a predicts better.
  double ratio = std::numeric_limits<double>::quiet_NaN();
  double t = std::numeric_limits<double>::quiet_NaN();  ///< of the blocks' differences, blocks − 1 degrees of
                                                        ///< freedom
  /// That models which predict equally well differ by as much, two-sided, times the number of pairs, 1 at
  /// most. Not a number where the logs are too short for six blocks.
  double p = std::numeric_limits<double>::quiet_NaN();
  int blocks = 0;
  std::optional<std::size_t> better;  ///< the model with p below the level and the smaller error
};

/// What drives the robot of a rollout.
enum class Drive {
  torques,    ///< those of the log: open loop
  controller  ///< the control law, which follows the log's reference: closed loop
};
template <>
inline constexpr std::array names_of<Drive> = std::to_array<std::string_view>({"torques", "controller"});

/// Errors of simulated motions at the end of windows of one length.
struct Rollout {
  struct Error {
    Vector q;   ///< rms over the windows that all models were simulated through, (n) [rad | m]
    Vector qd;  ///< the same of the velocities [rad/s | m/s]
    int lost =
        0;  ///< windows that the simulation did not reach the end of: it diverged, or M was not positive
  };
  Drive drive = Drive::torques;
  double horizon = 0.0;           ///< [s]
  int windows = 0;                ///< of all logs
  std::vector<Error> models;      ///< in the order of Rollouts::models
  std::vector<PairedTest> tests;  ///< of the first model with each of the others
};

struct Rollouts {
  std::vector<std::string> models;
  std::vector<Rollout> found;      ///< by drive, then by horizon; horizons longer than the logs are left out
  std::vector<std::string> notes;  ///< why there are no rollouts of a drive
};

/// Errors of models on logs, and which of them predicts better.
struct Comparison {
  struct Error {
    std::string name;
    double relative_error = 0.0;  ///< ‖Y − W χ‖ / ‖Y‖ over all joints and logs, as Fit::relative_error
    std::vector<double> joints;   ///< the same joint by joint, (n)
  };
  /// Torque errors Y − W χ over time on one log, of the joint with the largest error of the first model.
  struct Trace {
    std::string joint;
    std::string log;
    Vector time;    ///< of the rows, and between stretches of them [s]
    Matrix errors;  ///< a column a model; not a number between stretches [N·m | N]
  };
  std::vector<std::string> joints;
  std::vector<std::string> logs;
  std::vector<Trace> traces;  ///< one a log
  std::vector<Error> models;
  std::vector<PairedTest> tests;          ///< of each pair of models
  Index rows = 0;                         ///< that all models are judged on
  SignalOptions signal;                   ///< that made them
  std::optional<Rollouts> rollouts = {};  ///< of rollouts(), where they were asked for
};

/// Judges models by the torques that they predict on logs, best on logs that took part in none of them.
///
/// For each pair of models d_t = Σ_j (e_a² − e_b²) / s_j² at each sample, with the mean squared error s_j² of
/// both on joint j, is summed over blocks of time, which are longer than the errors are correlated. Block
/// sums are nearly independent, and Student's t test decides whether their mean is zero; it is conservative
/// where their variances differ (Ibragimov & Müller 2010). docs/compare.md measures how often it is wrong.
///
/// @throws InputError  where a model, a log or the options can not be used, or models have other joints than
///                     the first
[[nodiscard]] Comparison compare(std::span<const ComparedModel> models, std::span<const Log> logs,
                                 const ComparisonOptions& options = {});

/// The test of compare() on differences that are given.
///
/// @param series   d_t of each log, in the order of time
/// @param blocks   at most
/// @return  ratio, p and t without the correction for several pairs; `better` is left open
/// @throws InputError  where a difference is not finite, or blocks is less than 6
[[nodiscard]] PairedTest paired_test(std::span<const Vector> series, int blocks);

/// A parameter of two results of one robot.
struct ParameterChange {
  std::string name;
  std::string unit;
  double a = 0.0;
  double b = 0.0;
  double sigma = 0.0;  ///< of the difference, √(σ_a² + σ_b²)
  double z = 0.0;      ///< (b − a) / sigma
  double p = 1.0;      ///< two-sided, normal, times the number of parameters, 1 at most
};

/// An estimate with its deviation, as a result has it.
struct ParameterValue {
  std::string name;
  std::string unit;
  double value = 0.0;
  double sigma = std::numeric_limits<double>::quiet_NaN();
};

/// What changed between two results of one robot, the largest |z| first. Parameters that one of the two does
/// not have, or has no deviation of, are left out.
[[nodiscard]] std::vector<ParameterChange> parameter_changes(std::span<const ParameterValue> a,
                                                             std::span<const ParameterValue> b);

}  // namespace rivid
