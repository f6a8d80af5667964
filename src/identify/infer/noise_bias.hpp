#pragma once

#include <span>
#include <vector>

#include "identify/estimate/estimate.hpp"
#include "identify/rows/position_noise.hpp"

namespace rivid::detail {

// Noise of the positions of all logs, one for each joint of each log.
[[nodiscard]] std::vector<std::vector<PositionNoise>> position_noise(std::span<const Log> logs);

// Some samples of a log that stand for all, and how the joints move there, as rows of that signal see it.
[[nodiscard]] Motion some_motion(const Log& log, const SignalOptions& signal);

// What noise of the positions does to an estimate by least squares. Its rows are W + ΔW, and while ΔW has the
// mean zero, that of ΔWᵀ Ω⁻¹ ΔW = D is not:
//
//   χ̂ − χ ≈ −(Wᵀ Ω⁻¹ W)⁻¹ D χ
//
// W is linear in accelerations and, but for signs, at most quadratic in velocities; with E_j and F_j its
// derivatives by q̈_j and q̇_j, D is Σ_j var(q̈_j) E_jᵀ E_j + var(q̇_j) F_jᵀ F_j, summed over the rows. That
// of positions in gravity's columns is left out: it is smaller by the square of what a row's duration has in
// radians of the motion.
class NoiseSensitivity {
 public:
  // data  rows of each joint, that the estimate χ is from
  NoiseSensitivity(const Robot& robot, const BaseParameters& base, std::span<const Log> logs,
                   std::span<const SignalOptions> signals, const RowFactors& data, const Vector& chi);

  // D χ, (b), and of each joint's rows the mean square of their error ΔW χ.
  struct Effect {
    Vector D_chi;
    std::vector<double> mean_squares;
  };
  // noise    of each log, of each joint's rows
  // weights  1/σ of each joint's rows
  [[nodiscard]] Effect effect(std::span<const std::vector<DerivativeNoise>> noise,
                              std::span<const double> weights) const;

  // What E[Wᵀ Ω⁻¹ ρ] is at most, (b), where the errors ρ of the rows are torques that move the arm, which
  // accelerates by M⁻¹ ρ: feedback takes away what is slower than the loop.
  //
  // mean_squares  of the errors of each joint's rows
  [[nodiscard]] Vector disturbance(std::span<const double> mean_squares,
                                   std::span<const double> weights) const;

 private:
  // Mean of EᵀE χ and FᵀF χ over the rows of a joint in one log, for noise of one joint.
  struct Means {
    Vector acceleration;
    Vector velocity;
  };

  Index b_ = 0;
  Vector chi_;
  std::vector<std::vector<Index>> columns_;             // of each joint's rows
  std::vector<double> rows_;                            // of each joint
  std::vector<std::vector<double>> shares_;             // of the logs in the rows of each joint
  std::vector<std::vector<Vector>> responses_;          // [log][joint of the row], mean of Σ_j E_j (M⁻¹)_ji
  std::vector<std::vector<std::vector<Means>>> means_;  // [log][joint of the row][joint of the noise]
};

// Expected bias of an estimate by least squares where chi is about the truth, (b) [SI].
[[nodiscard]] Vector noise_bias(const EstimationProblem& problem, const Estimate& estimate,
                                const Vector& chi);

}  // namespace rivid::detail
