#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/solve/robust_loss.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Robust estimation against outliers in the torques: an M-estimate Σ Z_t ψ(ρ_t / s_j) s_j = 0 in place of
/// Σ Z_t ρ_t = 0, where Z are the rows of W or of the instruments V and s_j is a robust_scale() of the residuals of joint
/// j. It is found by least squares with weights ψ(u)/u on the rows, again and again, until the parameters that give the
/// weights are those that the weights give (IRLS, [Holland 1977]). Weights by joint are 1/s_j.
///
/// The bisquare begins from Huber's estimate, with its default tuning.
///
/// Wrong positions spoil W and draw least squares by their leverage all the same; not so IDIM-IV, whose V is simulated.
struct Robust {
  RobustKind kind = RobustKind::huber;
  std::optional<double> tuning = {};  ///< in units of s_j; default_tuning() of the kind without
  int max_rounds = 200;               ///< of weights and parameters in turn, for each loss
  /// The rounds end when no parameter moves by more than so many of its standard deviations.
  double tolerance = 1e-3;

  [[nodiscard]] RobustLoss loss() const { return {kind, tuning.value_or(default_tuning(kind))}; }

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// What became of the rows of one joint.
struct RobustJoint {
  std::string name;    ///< of the joint
  double scale = 0.0;  ///< s_j of its residuals [N·m | N]
  Index rows = 0;
  Index below_one = 0;   ///< of these, rows with a weight below 1: of bisquare nearly all
  Index below_half = 0;  ///< rows with a weight below 1/2
  Index rejected = 0;    ///< rows without any weight
};

/// What robust estimation made of an identification.
struct RobustReport {
  Robust options;
  int rounds = 0;  ///< in all
  std::vector<RobustJoint> joints;
  Vector chi;                  ///< estimate without it, (b)
  double largest_shift = 0.0;  ///< max |χ̂ − chi| / σ, with the deviations σ of the robust estimate
  std::string parameter;       ///< where it is
};

}  // namespace rivid
