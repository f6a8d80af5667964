#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/identify/diagnostics.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/identify/gains.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/simulate/closed_loop.hpp"
#include "rivid/simulate/control.hpp"
#include "rivid/types.hpp"

namespace rivid {

enum class Status {
  identified,
  doubtful,          ///< an estimate that there are reasons not to trust
  rank_deficient,    ///< the data, or the instruments, do not determine all parameters
  not_converged,     ///< the iteration limit came first
  cycling,           ///< the iteration goes round among a few estimates
  weak_instruments,  ///< the simulated motion says too little about some parameters
  not_simulable,     ///< no closed loop could be simulated with an iterate or with one near it
  gave_up            ///< a budget of steps or seconds was used up first
};

template <>
inline constexpr std::array names_of<Status> =
    std::to_array<std::string_view>({"identified", "doubtful", "rank_deficient", "not_converged", "cycling",
                                     "weak_instruments", "not_simulable", "gave_up"});

/// What the data say about a parameter.
enum class Verdict {
  identified,
  weak,         ///< the 95 % interval holds zero, or the deviation is above 30 % of the value
  not_excited,  ///< undetermined, or a value as large as any of its kind would pass unnoticed
};

template <>
inline constexpr std::array names_of<Verdict> =
    std::to_array<std::string_view>({"identified", "weak", "not_excited"});

/// One identified base parameter with its statistics, Eqs. (17–19) of [RIV].
struct ParameterEstimate {
  std::string name;                     ///< "ZZ1R"
  std::string unit;                     ///< SI, joint side
  std::string regrouped;                ///< "ZZ1 + Ia1 + 0.25 M2"
  double value = 0.0;                   ///< not a number where the data do not determine it
  double sigma = 0.0;                   ///< standard deviation; infinite where undetermined
  double relative_sigma_percent = 0.0;  ///< 100 σ / |value|
  double plain_sigma = 0.0;  ///< σ of CovarianceKind::hac, where `sigma` is that of `blocks`; else the same
  std::array<double, 2> interval_95 = {0.0, 0.0};  ///< value ± CovarianceReport::quantile_975 σ
  /// Expected bias by the noise of the positions, in the σ of errors in the rows. Not a number where
  /// instruments know none of that noise, and for robust estimates.
  double noise_bias = std::numeric_limits<double>::quiet_NaN();
  /// By what those Identification::alternatives that are warnings move it together, which is part of `sigma`.
  double model_shift = 0.0;
  std::string widened_by = {};  ///< codes of these; empty where there is none
  /// By what the choice of the rows moves it, which is part of `sigma`: the bias that noise is expected to
  /// leave, and what neighbouring windows say where one moves a parameter by more than 3 σ.
  double row_shift = 0.0;
  double a_priori = 0.0;  ///< the same base parameter from the robot description
  Verdict verdict = Verdict::identified;
  std::string advice;  ///< why it is not `identified`, and the motion that would help; else empty

  template <typename R = ParameterEstimate>
  static constexpr auto fields() {
    return std::tuple(
        Field{"name", &R::name,
              "the standard parameter that leads the group (6), with R where others are regrouped into it"},
        Field{"value", &R::value, "estimate (15); null where undetermined", {.unit = "`unit`"}},
        Field{"unit", &R::unit, "SI, joint side"},
        Field{"sigma",
              &R::sigma,
              "standard deviation (18), √C_χχ(i, i); null where undetermined",
              {.unit = "`unit`"}},
        Field{
            "relative_sigma_percent", &R::relative_sigma_percent, "100 σ / \\|value\\| (19)", {.unit = "%"}},
        Field{"plain_sigma",
              &R::plain_sigma,
              "standard deviation by the residuals alone, without blocks of time",
              {.unit = "`unit`"}},
        Field{"interval_95", &R::interval_95, "value ± `covariance.quantile_975` σ", {.unit = "`unit`"}},
        Field{"noise_bias",
              &R::noise_bias,
              "expected bias by the noise of the positions, see [rows](rows.md#noise); null where it is not "
              "known",
              {.unit = "σ"}},
        Field{"model_shift",
              &R::model_shift,
              "shift by those `alternatives` that are warnings, which is part of `sigma`",
              {.unit = "`unit`"}},
        Field{"widened_by", &R::widened_by, "codes of these `alternatives`; empty where there is none"},
        Field{"row_shift",
              &R::row_shift,
              "shift by the choice of the [rows](rows.md#noise), which is part of `sigma`; 0 of rows that "
              "were given",
              {.unit = "`unit`"}},
        Field{"regrouped", &R::regrouped, "the group as a person writes it (6): `\"ZZ1 + 0.25 M2\"`"},
        Field{"regrouping",
              nullptr,
              "the same as numbers: coefficient of each standard parameter",
              {.unit = "mixed"}},
        Field{"a_priori",
              &R::a_priori,
              "the same group from the robot description; unknown friction and Ia count as 0",
              {.unit = "`unit`"}},
        Field{
            "verdict", &R::verdict,
            "`\"identified\"`, `\"weak\"` or `\"not_excited\"`, see [diagnostics](diagnostics.md#verdicts)"},
        Field{"advice", &R::advice,
              "why it is not `\"identified\"`, and the motion that would help; else empty"});
  }
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

  template <typename R = JointFit>
  static constexpr auto fields() {
    return std::tuple(
        Field{"name", &R::name, "of the joint"},
        Field{"relative_error", &R::relative_error, "of this joint's rows (14), unweighted", {.unit = "1"}},
        Field{"centred_relative_error",
              &R::centred_relative_error,
              "the same over the norm of Y without its mean",
              {.unit = "1"}},
        Field{"sigma_rho", &R::sigma_rho, "deviation of this joint's residual (17)", {.unit = "`unit`"}},
        Field{"unit", &R::unit, "N·m or N"}, Field{"rows", &R::rows, "rows of this joint (14)"},
        Field{"left_out", &R::left_out, "rows left out: too slow, or near a reversal"},
        Field{"velocity_threshold", &R::velocity_threshold, "below which they are", {.unit = "rad/s, m/s"}});
  }
};

/// How well a model explains rows.
struct Fit {
  double relative_error = 0.0;          ///< ‖Y − W χ‖ / ‖Y‖
  double centred_relative_error = 0.0;  ///< the mean of each joint's Y taken off in the denominator
  /// ‖Y − W χ‖ / ‖Y‖ on rows that do not depend on the signal options: the paper's, every 20 ms, of positions
  /// low-passed at 10 Hz, or what the sampling rate allows. Not a number where there is no log.
  double reference_error = std::numeric_limits<double>::quiet_NaN();
  double error_norm = 0.0;  ///< ‖Y − W χ‖
  /// Standard deviation of the residual, (17). Of the weighted residual for WLS, where it is near 1. Of
  /// robust estimates that of the inliers.
  double sigma_rho = 0.0;
  Index rows = 0;
  std::vector<JointFit> joints;

  template <typename R = Fit>
  static constexpr auto fields() {
    return std::tuple(
        Field{"relative_error", &R::relative_error, "‖Y − W χ‖ / ‖Y‖ over all joints (13)", {.unit = "1"}},
        Field{"centred_relative_error",
              &R::centred_relative_error,
              "‖Y − W χ‖ over the norm of Y without each joint's mean",
              {.unit = "1"}},
        Field{"reference_error",
              &R::reference_error,
              "the relative error on rows that do not depend on `[signal]`, to compare results: the paper's "
              "rows, every 20 ms, of positions low-passed at 10 Hz (at slow sampling rates a fifth of "
              "these). Null without a log, and of `physical` and `essential`",
              {.unit = "1"}},
        Field{"error_norm", &R::error_norm, "‖Y − W χ‖ (13)", {.unit = "N·m, N"}},
        Field{"sigma_rho",
              &R::sigma_rho,
              "standard deviation of the residual (17), see [conventions](experiment.md#conventions); in "
              "`fit` of `wls` that of the weighted residual, near 1 and without unit",
              {.unit = "N·m, N"}},
        Field{"rows", &R::rows, "r, rows of all joints (13)"},
        Field{"joints", &R::joints, "the same joint by joint (14), see below"});
  }
};

/// Expected ‖Y − W χ̂‖ / ‖Y‖ on rows that take no part in a fit: the residual of the fit, and what errors of
/// the parameters by their covariance make of these rows. Infinite where they show what is not determined.
struct TorqueForecast {
  double relative_error = 0.0;  ///< of all joints
  Vector joints;                ///< of each joint, (n)

  template <typename R = TorqueForecast>
  static constexpr auto fields() {
    return std::tuple(Field{"relative_error",
                            &R::relative_error,
                            "expected relative error; null where the rows show what is not determined",
                            {.unit = "1"}},
                      Field{"joints", &R::joints, "the same of each joint", {.unit = "1"}});
  }
};

/// Cross-validation: the identified model on a log that took no part in the fit.
struct Validation {
  std::string file;
  Fit fit;
  TorqueForecast forecast;       ///< of the error of the answer on this log
  std::optional<Fit> physical;   ///< of the physically consistent model, where there is one
  std::optional<Fit> essential;  ///< of the essential parameters, where they were asked for
};

/// The physically consistent model that is nearest to the estimate, see physical(), and what it costs in fit.
struct PhysicalModel {
  Physical options;
  PhysicalParameters parameters;
  Fit fit;  ///< on the rows of the identification
  /// Whether blocks of time that are left out one by one are predicted better than by the estimate, beyond
  /// what that scatters by, or the estimate is rank deficient: then this set is the answer.
  bool better = false;
  /// Covariance of `parameters.chi` by the blocks, and by what the prior decided, (b × b); empty where the
  /// blocks can not say.
  Matrix C_chi;
};

/// The model of the parameters that matter, and what it costs in fit.
struct EssentialModel {
  Essential options;
  EssentialParameters parameters;
  Fit fit;  ///< on the rows of the identification
};

/// Distance of one motion from another, joint by joint: ‖a − b‖ / ‖b‖ of positions, velocities,
/// accelerations, (n) each.
struct MotionError {
  Vector q;
  Vector qd;
  Vector qdd;

  template <typename R = MotionError>
  static constexpr auto fields() {
    return std::tuple(Field{"position", &R::q, ""}, Field{"velocity", &R::qd, ""},
                      Field{"acceleration", &R::qdd, ""});
  }
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

  template <typename R = IvIteration>
  static constexpr auto fields() {
    return std::tuple(
        Field{"chi",
              &R::chi,
              "parameters that were simulated (29), in the order of `parameters`",
              {.unit = "SI"}},
        Field{"error_norm", &R::error_norm, "‖Y − V χ‖, V from this simulation", {.unit = "mixed"}},
        Field{"relative_error", &R::relative_error, "the same over ‖Y‖", {.unit = "1"}},
        Field{"joint_error_norm", &R::joint_error_norm, "of the rows of each joint", {.unit = "N·m, N"}},
        Field{"largest_step_sigmas",
              &R::largest_step,
              "largest change of a parameter since the last iterate, in its standard deviations",
              {.unit = "1"}},
        Field{"simulated_to_measured",
              &R::to_measured,
              "relative distance of the simulated motion from the filtered measured one: `position`, "
              "`velocity`, `acceleration`",
              {.unit = "1"}},
        Field{"simulated_to_reference", &R::to_reference, "the same from the reference", {.unit = "1"}},
        Field{"design_inertia", &R::J, "that the gains follow (38)", {.unit = "kg·m², kg"}},
        Field{"gains",
              [](const IvIteration& r) { return by_name(r.gains); },
              "of the control law (46), as it was simulated",
              {.unit = "mixed"}},
        Field{"condition_V", &R::condition_V, "condition number of V (34)", {.unit = "1"}},
        Field{"condition_VW", &R::condition_VW, "of Q_Vᵀ W", {.unit = "1"}},
        Field{"steps", [](const IvIteration& r) { return r.effort.steps; }, "of the simulation"},
        Field{"right_hand_sides", [](const IvIteration& r) { return r.effort.right_hand_sides; },
              "evaluations of the dynamics"},
        Field{"mode_changes", [](const IvIteration& r) { return r.effort.mode_changes; }, "of dry friction"},
        Field{"safeguard", &R::safeguard,
              "what was done where the iterate itself could not be simulated; else empty"});
  }
};

/// How well the assumed controller explains the log.
struct LoopDiagnosis {
  /// Relative error of the control signal that the law gives for the measured motion, (n); empty where the
  /// log has none.
  Vector control_error;
  Vector tracking_ratio;  ///< ‖q_simulated − q‖ / ‖q_r − q‖, (n): small where the loop is the actual one

  template <typename R = LoopDiagnosis>
  static constexpr auto fields() {
    return std::tuple(
        Field{"control_error",
              &R::control_error,
              "relative error of the control signal that the law gives for the measured motion, one a joint",
              {.unit = "1"}},
        Field{"tracking_ratio",
              &R::tracking_ratio,
              "distance of the simulated motion from the measured one over the tracking error, one a joint",
              {.unit = "1"}});
  }
};

/// What IDIM-IV did on its way.
struct IvHistory {
  std::vector<IvIteration> iterations;
  LoopDiagnosis loop;
  /// Strength of the instruments for each parameter, as the F statistic of a first stage, (b): weak below 10.
  Vector first_stage_F;
  Vector least_squares;  ///< IDIM-WLS (IDIM-OLS without weights) on the same rows, (b); empty where it has
                         ///< not full rank
};

/// Autoregressive model of the error of one joint's rows, ρ_t = Σ_i ar_i ρ_{t−i} + e_t.
struct NoiseModel {
  std::string joint;
  Vector ar;                ///< a_1 … a_p
  double innovation = 0.0;  ///< standard deviation of e [N·m | N]

  template <typename R = NoiseModel>
  static constexpr auto fields() {
    return std::tuple(Field{"joint", &R::joint, "name of the joint"},
                      Field{"ar", &R::ar, "coefficients of ρ_t = Σ_i ar_i ρ_{t−i} + e_t", {.unit = "1"}},
                      Field{"innovation", &R::innovation, "deviation of e", {.unit = "N·m, N"}});
  }
};

/// What prefiltering made of IDIM-IV.
struct PrefilterReport {
  std::vector<NoiseModel> noise;  ///< one a joint
  int rounds = 0;                 ///< of noise models and instruments in turn
  Index rows = 0;                 ///< that were left, whitened
  Vector chi;                   ///< estimate without the prefilter, from the rows of the signal options, (b)
  Vector sigma;                 ///< its standard deviations, (b)
  CovarianceReport covariance;  ///< what these were made of

  template <typename R = PrefilterReport>
  static constexpr auto fields() {
    return std::tuple(
        Field{"noise", &R::noise,
              "one a joint: `joint`, `ar`, the coefficients of ρ_t = Σ_i ar_i ρ_{t−i} + e_t, and "
              "`innovation`, the deviation of e in N·m or N"},
        Field{"rounds", &R::rounds, "times that noise models and parameters were found in turn"},
        Field{"rows", &R::rows, "whitened rows"},
        Field{"without",
              nullptr,
              "`chi` and `sigma` of the estimate without the prefilter, in the order of `parameters`",
              {.unit = "SI"}});
  }
};

/// A gain of the control law, or its delay, that output error estimated.
struct LoopEstimate {
  std::string name;          ///< "K_p", …, or "delay" [periods]
  std::string joint;         ///< empty: of all
  double prior = 0.0;        ///< what was known of it
  double prior_sigma = 0.0;  ///< its standard deviation
  double value = 0.0;
  double sigma = 0.0;
  std::array<double, 2> interval_95 = {0.0, 0.0};

  template <typename L = LoopEstimate>
  static constexpr auto fields() {
    return std::tuple(
        Field{"name", &L::name, "of the gain, or `\"delay\"` in periods"},
        Field{"joint", &L::joint, "empty: of all"}, Field{"prior", &L::prior, "value in `[control]`"},
        Field{"prior_sigma", &L::prior_sigma, "its standard deviation"},
        Field{"value", &L::value, "estimate"}, Field{"sigma", &L::sigma, "its standard deviation"},
        Field{"interval_95", &L::interval_95, "its 95 % confidence interval"});
  }
};

/// What closed-loop output error made of the estimate of IDIM-IV.
struct OutputErrorReport {
  int steps = 0;                   ///< of Gauss and Newton
  Vector start;                    ///< parameters that they began with, (b)
  Vector start_error;              ///< rms of q − q_s of each joint with these, (n) [rad | m]
  Vector joint_error;              ///< the same with the estimate, (n) [rad | m]
  Index instants = 0;              ///< of all logs that were compared
  std::vector<LoopEstimate> loop;  ///< unknowns of the control loop, see Iv::gain_sigma
  std::string scale;  ///< a sentence: where the scale of gains and parameters is from; empty without `loop`

  template <typename R = OutputErrorReport>
  static constexpr auto fields() {
    return std::tuple(
        Field{"steps", &R::steps, "of Gauss and Newton"},
        Field{"start",
              &R::start,
              "parameters that they began with, in the order of `parameters`",
              {.unit = "SI"}},
        Field{"start_error",
              &R::start_error,
              "rms of the positions less the simulated ones with these, by joint",
              {.unit = "rad, m"}},
        Field{"joint_error", &R::joint_error, "the same with the estimate", {.unit = "rad, m"}},
        Field{"instants", &R::instants, "of all logs that were compared"},
        Field{"loop", &R::loop,
              "[gains and delay](control.md#unknown-gains-and-delay) that were estimated, each with "
              "`name`, `joint`, `prior`, `prior_sigma`, `value`, `sigma`, `interval_95`"},
        Field{"scale", &R::scale, "one sentence: where the scale of all of them is from"});
  }
};

/// By how much an estimate moves when its rows are made by another window.
struct WindowShift {
  double largest = std::numeric_limits<double>::quiet_NaN();  ///< change of a parameter in its σ
  std::string parameter;                                      ///< that it is of
  Vector change = {};        ///< of each parameter, (b); empty where there is no other estimate
  Vector beyond_noise = {};  ///< the same less the change of the expected bias, (b)

  template <typename R = WindowShift>
  static constexpr auto fields() {
    return std::tuple(Field{"largest", &R::largest, "change of a parameter", {.unit = "σ"}},
                      Field{"parameter", &R::parameter, "that it is of"});
  }
};

/// Rows that were chosen by the noise of the positions: SignalOptions::automatic().
struct RowChoice {
  int decimation = 1;        ///< n_d: samples from one row to the next; half of what a row reaches over
  double row_spacing = 0.0;  ///< the same in time [s]
  bool torque_held = false;  ///< what was found of the torques, or was given
  /// Whether noise alone would have left too few rows, or rows that do not determine all parameters: the
  /// window is then that with the least expected squared error of predicted torques.
  bool by_prediction = false;
  WindowShift foretold;   ///< the largest expected bias by noise, see ParameterEstimate::noise_bias
  WindowShift at_half;    ///< the estimate by least squares at half that window, against that at the window
  WindowShift at_double;  ///< the same at twice the window
  std::string reason;     ///< one sentence: what was chosen and why

  template <typename R = RowChoice>
  static constexpr auto fields() {
    return std::tuple(
        Field{"decimation", &R::decimation, "samples from one row to the next"},
        Field{"row_spacing", &R::row_spacing, "the same in time", {.unit = "s"}},
        Field{"torque_held", &R::torque_held, "what was found of the torques, or was given"},
        Field{
            "by_prediction", &R::by_prediction,
            "whether noise alone would have left fewer than ten rows a parameter, or not determined all: the "
            "window is then that with the least expected squared error of predicted torques"},
        Field{"foretold", &R::foretold, "`largest` expected bias by noise in σ, and the `parameter`"},
        Field{"at_half", &R::at_half,
              "`largest` change of the estimate by least squares at half that window in σ, and the "
              "`parameter`"},
        Field{"at_double", &R::at_double, "the same at twice the window"},
        Field{"reason", &R::reason, "one sentence: what was chosen and why"});
  }
};

/// The method that was chosen by the experiment: Auto.
struct MethodChoice {
  std::string reason;    ///< one sentence: what ran and why
  Vector least_squares;  ///< IDIM-WLS on the same rows, (b); empty where that is what ran

  template <typename R = MethodChoice>
  static constexpr auto fields() {
    return std::tuple(
        Field{"reason", &R::reason, "one sentence: what ran and why"},
        Field{"least_squares",
              &R::least_squares,
              "IDIM-WLS on the same rows, in the order of `parameters`; empty where that is what ran",
              {.unit = "SI"}});
  }
};

/// What an identification found, the answer of identify().
struct [[nodiscard]] Identification {
  std::string method;  ///< one of method_names but "auto"
  std::string title;   ///< as title() says; of robust ones "IDIM-OLS, Huber", "IDIM-OLS, bisquare"
  Status status = Status::identified;
  std::vector<std::string> reasons;     ///< why the status is not `identified`
  std::vector<Finding> warnings;        ///< what may make the result wrong
  std::vector<ModelTest> alternatives;  ///< that are believed, the likeliest first
  std::vector<std::string> notes;       ///< what was done to the data

  /// That ran, with what was chosen in place of what was left open, without `progress`; a validation uses its
  /// signal.
  Estimation estimation;
  BaseParameters base;
  /// (b), Eq. (15), one of many solutions if rank deficient. Of IDIM-IV (29): the last iterate whose own
  /// instruments could be solved for, not a number where there is none.
  Vector chi;
  Matrix C_chi;  ///< (b × b) covariance, see `covariance`
  /// By what chi moves with relative errors of the drive gains, dχ̂/dε of torques (1 + ε_j) τ_j, (b × n);
  /// zero where the rows do not determine all parameters.
  Matrix gain_slopes;
  CovarianceReport covariance;                ///< what it was made of
  std::vector<ParameterEstimate> parameters;  ///< (b)

  Fit fit;                 ///< on the rows of the identification
  Index columns = 0;       ///< b
  double condition = 0.0;  ///< of W, weighted if the method weights; of Q_Vᵀ W for IDIM-IV
  /// |diag R| of the unweighted observation matrix, (b); before decimation in convention `matlab`.
  Vector R_diagonal;
  std::vector<double> weights;  ///< 1/σ of each joint's rows; ones for OLS
  std::vector<Validation> validation;
  /// Of random motion within the range of the logs, as fast and with as large accelerations, all joints
  /// independent of each other; nothing where there are no parameters, or no logs but their factors.
  std::optional<TorqueForecast> forecast;
  std::optional<RowChoice> row_choice;            ///< where SignalOptions::automatic() asked for it
  std::optional<MethodChoice> method_choice;      ///< where Auto asked for it
  std::optional<GainReport> gains;                ///< where the experiment asked for it
  std::optional<IvHistory> iv;                    ///< of the methods that iterate
  std::optional<PrefilterReport> prefilter;       ///< where IDIM-IV was asked for it
  std::optional<OutputErrorReport> output_error;  ///< of that method
  std::optional<RobustReport> robust;             ///< where the method was asked for it
  std::optional<Diagnostics>
      diagnostics;  ///< where the covariance is that of CovarianceKind::hac or CovarianceKind::blocks
  /// Where the method was asked for it and all parameters are determined.
  std::optional<EssentialModel> essential;
  std::optional<PhysicalModel> physical;  ///< where the method was asked for it, and where it is the answer

  /// Whether the answer is the physically consistent set rather than chi; and of the answer its parameters
  /// and its errors, of the fit and of a validation.
  [[nodiscard]] bool physical_answers() const { return physical && physical->better; }
  [[nodiscard]] const Vector& answer() const { return physical_answers() ? physical->parameters.chi : chi; }
  [[nodiscard]] const Fit& answer_fit() const { return physical_answers() ? physical->fit : fit; }
  [[nodiscard]] const Fit& answer_fit(const Validation& found) const {
    return physical_answers() && found.physical ? *found.physical : found.fit;
  }
  [[nodiscard]] const Matrix& answer_covariance() const {
    return physical_answers() ? physical->C_chi : C_chi;
  }
};

/// Identifies the base parameters from logs of one robot; their rows are stacked.
///
/// Where the data do not determine all parameters, and where IDIM-IV comes to no end (a loop that can not be
/// simulated, cycling, instruments that are too weak), that is a status of the result with its reasons.
///
/// The answer is judged, unless Estimation::judge says no: robot, logs, model and result are looked at for
/// what makes it wrong. What is found are Identification::warnings, the gravest first; one of severity error
/// makes an `identified` result `doubtful`, with the finding as its reason. What is looked for: units by
/// magnitude, columns in a wrong order or with a wrong sign, clocks that disagree, saturation, reference and
/// motion that do not belong together; alternatives to robot and log that explain the torques better, by
/// score tests whose covariance comes from blocks of time (gains, scales and zeros of joints, direction of
/// gravity, rate of the clock, geometry, a load that changes, friction laws, elastic and coupled joints), by
/// which those that are believed widen all deviations; values that physics forbids; torques that are left
/// unexplained; validation that is much worse than the fit. SignalOptions::window cuts the logs before.
/// docs/diagnostics.md says how.
///
/// @param validation  logs that took no part: Identification::validation is of them, and they are compared
///                    with the others
/// @throws InputError where robot, logs and options do not fit together; the message names the culprit
Identification identify(const Robot& robot, std::span<const Log> logs, const Estimation& estimation,
                        std::span<const Log> validation = {});
/// The same from one log.
Identification identify(const Robot& robot, const Log& log, const Estimation& estimation);

/// Cross-validation: the torques of a log that took no part in the fit, against the identified model on it,
/// by the same signal chain.
///
/// @throws InputError where rows() throws it, the result has not one value for each base parameter, or
///                    threads is not positive
[[nodiscard]] Validation validate(const Robot& robot, const Identification& identification, const Log& log,
                                  int threads = 1);

}  // namespace rivid
