#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/estimate/estimate.hpp"
#include "identify/infer/covariance.hpp"
#include "rivid/identify/identification.hpp"

// The third stage: rows → estimate → infer → judge → describe. Once for all methods.
namespace rivid::detail {

// A covariance, and what a second pass over the rows adds to it.
struct Statistics {
  Uncertainty uncertainty;
  std::optional<Diagnostics> diagnostics;
  std::vector<BlockSums> blocks;
  Matrix loop_C;         // of the unknowns of the loop, see OutputErrorReport
  Vector least_squares;  // χ̂ of least squares on the rows of an estimate by instruments
};

[[nodiscard]] Statistics statistics_of(const EstimationProblem& problem, const Estimate& estimate);

// What the rows say of an estimate before it is judged.
struct Inference {
  Vector chi;                   // (b); not a number where there is no estimate
  std::vector<double> weights;  // 1/σ of each joint's rows
  double condition = 0.0;       // infinite where there is no estimate
  Uncertainty uncertainty;      // of errors in the rows and of gains
  Matrix gain_slopes = {};      // (b × n)
  Matrix of_choice = {};        // covariance by Estimation::choice_covariance, (b × b) or empty
  Matrix loop_C = {};           // covariance of what output error estimated of the loop
  Matrix of_geometry = {};      // covariance by Robot::tolerance, (b × b) or empty
  std::optional<Diagnostics> diagnostics = {};
  std::optional<Uncertainty> unfiltered = {};  // of the estimate before the prefilter
  Vector least_squares = {};                   // on the rows of an estimate by instruments, (b) or empty
  Vector noise_bias = {};                      // (b) or empty
  Matrix tie =
      {};  // chi = tie χ̂ where joints have twins, which all of the above has been through; else empty
  Fit fit = {};
  std::optional<PhysicalModel> physical = {};
  std::optional<EssentialModel> essential = {};  // its covariance left out
  std::vector<Finding> warnings = {};            // of the physical model, or its absence
  std::vector<std::string> notes = {};
};

[[nodiscard]] Inference inferred(const EstimationProblem& problem, const Estimated& found);

// The model against the rows, unweighted. Each joint is charged its share of the `estimated` parameters; a
// validation charges none.
[[nodiscard]] Fit fit_to(const Robot& robot, const RowFactors& data, const Vector& chi, Index estimated,
                         Convention convention);

// Of differences over so long a time that the noise of encoders does not count.
[[nodiscard]] SquaredVelocities squared_velocities(std::span<const Log> logs, Index n);
// Joints whose rms velocity is next to nothing beside the fastest joint's of the same type, one a joint.
[[nodiscard]] std::vector<std::uint8_t> hardly_moving(const Robot& robot,
                                                      const SquaredVelocities& velocities);

// Error to be expected on rows of other motion.
//
// C    covariance of the parameters, (b × b)
// fit  whose residual is to be expected
[[nodiscard]] TorqueForecast expected_error(std::span<const RowGroup> rows, const Matrix& C, const Fit& fit);
// That of random motion as far, as fast and with as large accelerations as these logs, all joints
// independent.
[[nodiscard]] TorqueForecast expected_error(const Robot& robot, const BaseParameters& base,
                                            std::span<const Log> logs, const Vector& chi, const Matrix& C,
                                            const Fit& fit);
// ‖Y − W χ‖ / ‖Y‖ on rows that no option changes, see Fit::reference_error; not a number where the logs have
// none.
[[nodiscard]] double reference_error(const Robot& robot, const BaseParameters& base,
                                     std::span<const Log> logs, const Vector& chi, ThreadTeam& team);

// The parameters that the estimate can not do without, and their fit, where they are wanted.
void add_essential(const EstimationProblem& problem, const Estimate& estimate, Inference& out);

// The physically consistent model of an estimate, where it is wanted; else a warning where the data leave
// much open that it would settle.
//
// blocks  of time that the weight of the prior is validated on, one by one; none leave it to what the prior
//         costs
void add_physical(const EstimationProblem& problem, const Estimated& found, std::span<const BlockSums> blocks,
                  Inference& out);

// What Robot::tolerance adds to the covariance of an estimate, (b × b): Σ s sᵀ, where s is the step of the
// estimate with a length or an angle of the description by its standard deviation. Empty where that is
// exact, or the rows do not determine all parameters.
//
// Some instants of each log stand for all: a deviation needs no more.
[[nodiscard]] Matrix geometry_covariance(const EstimationProblem& problem, const Estimate& estimate);

// Joint::same_as: links and joints that are alike.
struct Twins {
  struct Pair {
    int joint = 0;  // counted from 0
    int twin = 0;
    Matrix A;  // A χ = 0 is what this pair and those behind its link say, (m × b), rows orthonormal
  };
  std::vector<Pair> pairs;
  Matrix free;  // χ = free θ is what all pairs leave, (b × b − m), columns orthonormal
};

// throws InputError where a twin is none of the robot's joints, differs in kind or stands elsewhere
[[nodiscard]] Twins twins_of(const Robot& robot, const BaseParameters& base);

// Inference::tie of an estimate, applied to all of `out` that is a vector or covariance of the parameters,
// and what the data say of the ties: notes and warnings. Least squares of the rows with the ties, for
// independent errors, as essential() does it.
void tie_twins(const EstimationProblem& problem, const Estimate& estimate, Inference& out);

// The same estimate with ties that hold to a part of its deviations that does not count.
[[nodiscard]] Estimate tied(Estimate estimate, const Matrix& tie);

}  // namespace rivid::detail
