#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/finding.hpp"
#include "rivid/identify/diagnostics.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/control.hpp"
#include "rivid/types.hpp"

namespace rivid {

enum class Status {
  identified,
  rank_deficient,    ///< the data, or the instruments, do not determine all parameters
  not_converged,     ///< the iteration limit came first
  cycling,           ///< the iteration goes round among a few estimates
  weak_instruments,  ///< the simulated motion says too little about some parameters
  not_simulable      ///< no closed loop could be simulated with an iterate or with one near it
};

/// "identified", "rank_deficient", "not_converged", "cycling", "weak_instruments", "not_simulable".
[[nodiscard]] std::string_view name(Status status);

/// What the data say about a parameter.
enum class Verdict {
  identified,
  weak,         ///< the 95 % interval holds zero, or the deviation is above 30 % of the value
  not_excited,  ///< undetermined, or a value as large as any of its kind would pass unnoticed
};

/// "identified", "weak", "not_excited".
[[nodiscard]] std::string_view name(Verdict verdict);

/// One identified base parameter with its statistics, Eqs. (17–19) of [RIV].
struct ParameterEstimate {
  std::string name;                                ///< "ZZ1R"
  std::string unit;                                ///< SI, joint side
  std::string regrouped;                           ///< "ZZ1 + Ia1 + 0.25 M2"
  double value = 0.0;                              ///< not a number where the data do not determine it
  double sigma = 0.0;                              ///< standard deviation; infinite where undetermined
  double relative_sigma_percent = 0.0;             ///< 100 σ / |value|
  std::array<double, 2> interval_95 = {0.0, 0.0};  ///< value ± CovarianceReport::quantile_975 σ
  double a_priori = 0.0;                           ///< the same base parameter from the robot description
  Verdict verdict = Verdict::identified;
  std::string advice;  ///< why it is not `identified`, and the motion that would help; else empty
};

/// How well a model explains the rows of one joint.
struct JointFit {
  std::string name;  ///< of the joint
  std::string unit;  ///< of its torque
  Index rows = 0;
  Index left_out = 0;                   ///< rows left out for low velocity or a reversal nearby
  double velocity_threshold = 0.0;      ///< below which they are left out [rad/s | m/s]
  double relative_error = 0.0;          ///< ‖Y_j − W_j χ‖ / ‖Y_j‖
  double centred_relative_error = 0.0;  ///< ‖Y_j − W_j χ‖ / ‖Y_j − mean Y_j‖
  double sigma_rho = 0.0;               ///< standard deviation of the residual [N·m | N]
};

/// How well a model explains rows.
struct Fit {
  double relative_error = 0.0;          ///< ‖Y − W χ‖ / ‖Y‖
  double centred_relative_error = 0.0;  ///< the mean of each joint's Y taken off in the denominator
  double error_norm = 0.0;              ///< ‖Y − W χ‖
  /// Standard deviation of the residual, (17). Of the weighted residual for WLS, where it is near 1. Of robust estimates
  /// that which it has but for the outliers.
  double sigma_rho = 0.0;
  Index rows = 0;
  std::vector<JointFit> joints;
};

/// Cross-validation: the identified model on a log that took no part in the fit.
struct Validation {
  std::string file;
  Fit fit;
  std::optional<Fit> physical;   ///< of the physically consistent model, where there is one
  std::optional<Fit> essential;  ///< of the essential parameters, where they were asked for
};

/// The physically consistent model that is nearest to the estimate, see physical(), and what it costs in fit.
struct PhysicalModel {
  Physical options;
  PhysicalParameters parameters;
  Fit fit;  ///< on the rows of the identification
};

/// The model of the parameters that matter, and what it costs in fit.
struct EssentialModel {
  Essential options;
  EssentialParameters parameters;
  Fit fit;  ///< on the rows of the identification
};

/// Distance of one motion from another, joint by joint: ‖a − b‖ / ‖b‖ of positions, velocities, accelerations, (n) each.
struct MotionError {
  Vector q;
  Vector qd;
  Vector qdd;
};

/// One iterate of IDIM-IV: the parameters, and the closed loop that was simulated with them.
struct IvIteration {
  Vector chi;                   ///< χ̂_k, (b); k = 0 is the start
  double error_norm = 0.0;      ///< ‖ε_k‖ = ‖Y − V_k χ̂_k‖
  Vector joint_error_norm;      ///< the same for the rows of each joint, (n)
  double relative_error = 0.0;  ///< ‖ε_k‖ / ‖Y‖
  MotionError to_measured;      ///< of the simulated motion from the filtered measured one
  MotionError to_reference;     ///< of the simulated motion from the reference
  Vector J;                     ///< design inertias that the gains were adapted to, (n) [kg·m² | kg]
  std::vector<Gain> gains;      ///< of the control law
  double condition_V = 0.0;     ///< of V
  double condition_VW = 0.0;    ///< of Q_Vᵀ W
  double largest_step =
      0.0;  ///< largest change of a parameter from the last iterate, in its standard deviations
  SimulationEffort effort;  ///< of the simulations
  std::string safeguard;    ///< what was simulated instead where χ̂_k itself could not be
};

/// How well the assumed controller explains the log.
struct LoopDiagnosis {
  /// Relative error of the control signal that the law gives for the measured motion, (n); empty where the log has none.
  Vector control_error;
  Vector tracking_ratio;  ///< ‖q_simulated − q‖ / ‖q_r − q‖, (n): small where the loop is the actual one
};

/// What IDIM-IV did on its way.
struct IvHistory {
  std::vector<IvIteration> iterations;
  LoopDiagnosis loop;
  /// Strength of the instruments for each parameter, as the F statistic of a first stage, (b): weak below 10.
  Vector first_stage_F;
};

/// Autoregressive model of the error of one joint's rows, ρ_t = Σ_i ar_i ρ_{t−i} + e_t.
struct NoiseModel {
  std::string joint;
  Vector ar;                ///< a_1 … a_p
  double innovation = 0.0;  ///< standard deviation of e [N·m | N]
};

/// What prefiltering made of IDIM-IV.
struct PrefilterReport {
  std::vector<NoiseModel> noise;  ///< one a joint
  int rounds = 0;                 ///< of noise models and instruments in turn
  Index rows = 0;                 ///< that were left, whitened
  Vector chi;                   ///< estimate without the prefilter, from the rows of the signal options, (b)
  Vector sigma;                 ///< its standard deviations, (b)
  CovarianceReport covariance;  ///< what these were made of
};

/// What an identification found, the answer of identify().
struct [[nodiscard]] Identification {
  std::string method;  ///< "ols", "wls", "iv"
  std::string
      title;  ///< "IDIM-OLS", "IDIM-WLS", "IDIM-IV"; of robust ones "IDIM-OLS, Huber", "IDIM-OLS, bisquare"
  Status status = Status::identified;
  std::vector<std::string> reasons;  ///< why the status is not `identified`
  std::vector<Finding> warnings;     ///< what may make the result wrong
  std::vector<std::string> notes;    ///< what was done to the data

  Estimation estimation;  ///< that was asked for, without `progress`; a validation uses its signal
  BaseParameters base;
  /// (b), Eq. (15), one of many solutions if rank deficient. Of IDIM-IV (29): the last iterate whose own instruments
  /// could be solved for, not a number where there is none.
  Vector chi;
  Matrix C_chi;                               ///< (b × b) covariance, see `covariance`
  CovarianceReport covariance;                ///< what it was made of
  std::vector<ParameterEstimate> parameters;  ///< (b)

  Fit fit;                 ///< on the rows of the identification
  Index columns = 0;       ///< b
  double condition = 0.0;  ///< of W, weighted if the method weights; of Q_Vᵀ W for IDIM-IV
  /// |diag R| of the unweighted observation matrix, (b); before decimation in convention `matlab`.
  Vector R_diagonal;
  std::vector<double> weights;  ///< 1/σ of each joint's rows; ones for OLS
  std::vector<Validation> validation;
  std::optional<IvHistory> iv;               ///< of the methods that iterate
  std::optional<PrefilterReport> prefilter;  ///< where IDIM-IV was asked for it
  std::optional<RobustReport> robust;        ///< where the method was asked for it
  std::optional<Diagnostics> diagnostics;    ///< where the covariance is that of CovarianceKind::hac
  /// Where the method was asked for it and all parameters are determined.
  std::optional<EssentialModel> essential;
  std::optional<PhysicalModel> physical;  ///< where the method was asked for it
};

/// Identifies the base parameters from logs of one robot; their rows are stacked.
///
/// Where the data do not determine all parameters, and where IDIM-IV comes to no end (a loop that can not be simulated,
/// cycling, instruments that are too weak), that is a status of the result with its reasons.
///
/// @throws InputError where robot, logs and options do not fit together; the message names the culprit
Identification identify(const Robot& robot, std::span<const Log> logs, const Estimation& estimation);
/// The same from one log.
Identification identify(const Robot& robot, const Log& log, const Estimation& estimation);

/// Cross-validation: the torques of a log that took no part in the fit, against the identified model on it, by the
/// same signal chain.
[[nodiscard]] Validation validate(const Robot& robot, const Identification& identification, const Log& log,
                                  int threads = 1);

}  // namespace rivid
