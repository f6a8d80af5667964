#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/estimate/robust.hpp"
#include "identify/rows/kept_rows.hpp"
#include "identify/rows/thread_team.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/log_factors.hpp"
#include "rivid/identify/loop_factors.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/solve/least_squares.hpp"

// The second of three stages: rows → estimate → infer.
namespace rivid::detail {

// What an identification stands on, from the beginning to the end.
struct EstimationProblem {
  // All are referred to, not copied.
  //
  // load  of friction that follows the load: the point and widths that the rows are the tangent at
  //
  // throws InputError where they do not fit together
  EstimationProblem(const Robot& robot, std::span<const Log> logs, const Estimation& estimation,
                    LoadPoint load = {});
  // The same from logs that were reduced to factors: `logs` is empty.
  //
  // ask  for the loops of the logs, of instrumental variables
  EstimationProblem(const Robot& robot, const LogFactors& factors, const Estimation& estimation,
                    const LoopAsk* ask = nullptr);

  const Robot& robot;
  std::span<const Log> logs;
  const Estimation& estimation;
  BaseParameters base;
  const LogFactors* factors = nullptr;  // in place of logs
  const LoopAsk* ask = nullptr;
  std::vector<SignalOptions> signals;  // one a log: the transient is left out
  RowFactors data;                     // of [W Y]
  std::optional<RowFactors> secant;  // where `data` are those of a tangent: the rows whose W χ is the torque
  std::unique_ptr<ThreadTeam> team;
  std::vector<std::unique_ptr<KeptRows>>
      kept;  // one a log; nullptr where its rows are made anew for each pass

  // Sends the rows [V_1 … V_k W Y] of log k, made with signals[k] or with the same but its decimation.
  //
  // others  motions V_1 … V_k
  void send_rows(std::size_t k, const SignalOptions& signal, std::span<RowSink* const> sinks,
                 std::span<const Motion> others = {}) const;

  [[nodiscard]] Index joints() const { return robot.size(); }
  // Rows that a model is judged by.
  [[nodiscard]] const RowFactors& rows_to_judge() const { return secant ? *secant : data; }
  [[nodiscard]] const Iv& iv() const { return std::get<Iv>(estimation.method); }
  // throws InputError
  [[noreturn]] void refuse_few_rows(Index rows) const;
};

// What an estimate by instrumental variables has beside others.
struct EstimateInstruments {
  std::vector<Motion> motions;  // that V is built from, one a log; none where the logs are elsewhere
  std::vector<std::vector<InstrumentalGroup>> blocks;  // of rows [V | W Y] there
  std::vector<std::vector<Index>> from_V;              // columns of W that were taken from V
  std::vector<Vector> whitening;                       // of each joint's rows; empty for none
  std::vector<RowGroup> used;                          // [W Y]
  Vector first_stage_F;                                // (b)
};

// Sums over the rows of a block of time.
struct BlockSums {
  Matrix ZW;     // Zᵀ Ω⁻¹ W, (b × b)
  Vector Z_rho;  // Zᵀ Ω⁻¹ ρ, (b)
};

// What a covariance is made of where rows of torques were not what was compared.
struct EstimateScores {
  std::vector<Matrix> series;  // Σ Jᵀ Ω⁻¹ e over each interval of time, one of each log, (intervals × b)
  double interval = 0.0;       // [s]
  std::vector<BlockSums> blocks;
  Matrix bread;  // (Jᵀ Ω⁻¹ J)⁻¹ of χ and of what was estimated behind it, (b + g × b + g), as all above are
  Vector of_prior;  // variance of the score of what was known of the latter, (g)
};

// An estimate χ̂ of Zᵀ Ω⁻¹ (Y − W χ) = 0, with Z the instruments V or W itself, and what its statistics are
// made of.
struct Estimate {
  Vector chi;                   // (b)
  std::vector<double> weights;  // 1/σ of each joint's rows, Ω = diag σ²
  Index rows = 0;               // of all joints
  Index rank = 0;               // parameters that are determined
  double condition = 0.0;       // of W or Q_Vᵀ W, weighted
  double sigma = 0.0;           // root / sigma is a root of the information
  double sigma_rho = 0.0;       // standard deviation of the weighted residual, but for outliers
  Matrix root;                  // (b × b)
  Matrix unit_covariance;       // covariance for independent errors over sigma²; infinite where undetermined
  Matrix bread;                 // (Zᵀ Ω⁻¹ W)⁻¹, alike; of an M-estimate see RobustInformation
  std::vector<SignalOptions> signals;  // that made the rows, one a log
  std::optional<RowLoss> loss;         // of an M-estimate
  std::optional<EstimateInstruments> instruments;
  std::optional<EstimateScores> scores;  // nothing: those of its rows of torques

  [[nodiscard]] double freedom() const { return static_cast<double>(rows - rank); }
};

// What a method comes to, and its way there.
struct Estimated {
  Status status = Status::identified;
  std::vector<std::string> reasons;    // why it is not `identified`
  std::string loss;                    // of robust estimation: ", Huber"
  std::vector<double> weights;         // 1/σ of each joint's rows, where a method has come to some
  std::optional<Estimate> estimate;    // nothing where there is none
  std::optional<Estimate> unfiltered;  // that of the rows before they were prefiltered
  std::optional<Estimate> start;       // that of IDIM-IV, where the gains of simulated loops have its errors
  // Relative error with the simulated motion, before any prefilter; not a number where there is none.
  double error_with_V = std::numeric_limits<double>::quiet_NaN();
  std::optional<IvHistory> iv;
  std::optional<PrefilterReport> prefilter;
  std::optional<OutputErrorReport> output_error;
  std::optional<RobustReport> robust;
};

[[nodiscard]] Estimated estimated(const EstimationProblem& problem);

// Each fills `out`.
void least_squares_estimate(const EstimationProblem& problem, Estimated& out);
void instrumental_estimate(const EstimationProblem& problem, Estimated& out);
void didim_estimate(const EstimationProblem& problem, Estimated& out);
void output_error_estimate(const EstimationProblem& problem, Estimated& out);

// Where the methods begin that compare something else of the simulated loop: chi_0, or the estimate of
// IDIM-IV, which `out` tells of; nothing where there is none.
[[nodiscard]] std::optional<Vector> start_of_loop_fit(const EstimationProblem& problem, Estimated& out);

// A covariance without the infinite deviations of what is not determined, and these: zero where there are
// none, (b).
[[nodiscard]] Matrix finite_part(Matrix covariance);
[[nodiscard]] Vector undetermined(const Matrix& covariance);

// Deviation of a residual: (17) with its degrees of freedom, or MATLAB's std with the mean removed.
[[nodiscard]] double deviation(const Residual& r, double freedom, Convention convention);

// 1 / σ of each joint's rows, (20).
//
// throws InputError where a joint's torque is zero throughout
[[nodiscard]] std::vector<double> joint_weights(const EstimationProblem& problem);

// 1/σ of a joint's rows, σ being the deviation of what `chi` leaves of them; nothing where it leaves nothing.
[[nodiscard]] std::optional<double> residual_weight(const RowGroup& group, const Vector& chi);

// Status and reasons of an estimate that does not determine some sets of parameters, "… is not excited by
// `what`".
void explain_rank(const BaseParameters& base, Index rank, const std::vector<std::vector<Index>>& undetermined,
                  const std::string& what, Estimated& out);

// What an M-estimate made of the rows: out.robust, its loss, and the status where it did not settle.
//
// plain  estimate of the rows as they are
void report_robust(const EstimationProblem& problem, const Robust& options, const Reweighting& reweighting,
                   const Vector& plain, Estimated& out);

}  // namespace rivid::detail
