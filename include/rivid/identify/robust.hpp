#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/solve/robust_loss.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Robust estimation against outliers in the torques: an M-estimate Σ Z_t ψ(ρ_t / s_j) s_j = 0 in place of Σ
/// Z_t ρ_t = 0, where Z are the rows of W or of the instruments V and s_j is a robust_scale() of the
/// residuals of joint j. It is found by least squares with weights ψ(u)/u on the rows, again and again, until
/// the parameters that give the weights are those that the weights give (IRLS, [Holland 1977]). Weights by
/// joint are 1/s_j.
///
/// The bisquare begins from Huber's estimate, with its default tuning.
///
/// Wrong positions spoil W and draw least squares by their leverage all the same; not so IDIM-IV, whose V is
/// simulated.
struct Robust {
  RobustKind kind = RobustKind::huber;
  std::optional<double> tuning = {};  ///< in units of s_j; default_tuning() of the kind without
  int max_rounds = 200;               ///< of weights and parameters in turn, for each loss
  /// The rounds end when no parameter moves by more than so many of its standard deviations.
  double tolerance = 1e-3;

  [[nodiscard]] RobustLoss loss() const { return {kind, tuning.value_or(default_tuning(kind))}; }

  [[nodiscard]] std::optional<std::string> complaint() const;

  template <typename R = Robust>
  static constexpr auto fields() {
    return std::tuple(
        Field{"robust",
              &R::kind,
              "robust estimation against outliers in the torques: `\"huber\"`, `\"bisquare\"` or `\"off\"`, "
              "see [statistics](statistics.md#outliers); not with `prefilter`",
              {.otherwise = "`\"off\"`", .word = "off"}},
        Field{"robust_tuning",
              &R::tuning,
              "where that loss leaves least squares, in robust standard deviations of a joint's residual",
              {.otherwise = "1.345 (Huber), 4.685 (bisquare)",
               .range = Range::above(0.0, 1e6),
               .must_be = "positive"}},
        Field{"robust_max_rounds",
              &R::max_rounds,
              "most iterations, for each loss",
              {.range = Range::from(1, 1e4)}},
        Field{"robust_tolerance",
              &R::tolerance,
              "largest step of a parameter, in its standard deviations, with which the rounds end",
              {.range = Range::from(1e-9, 1e3)}});
  }
};

/// What became of the rows of one joint.
struct RobustJoint {
  std::string name;    ///< of the joint
  double scale = 0.0;  ///< s_j of its residuals [N·m | N]
  Index rows = 0;
  Index below_one = 0;   ///< of these, rows with a weight below 1: of bisquare nearly all
  Index below_half = 0;  ///< rows with a weight below 1/2
  Index rejected = 0;    ///< rows without any weight

  template <typename R = RobustJoint>
  static constexpr auto fields() {
    return std::tuple(
        Field{"name", &R::name, "of the joint"},
        Field{"scale", &R::scale, "of its residuals: their median magnitude over 0.6745", {.unit = "N·m, N"}},
        Field{"rows", &R::rows, "of the joint"},
        Field{"below_one", &R::below_one, "of these with a weight below 1, of the bisquare nearly all"},
        Field{"below_half", &R::below_half, "with a weight below 1/2"},
        Field{"rejected", &R::rejected, "without any weight"});
  }
};

/// What robust estimation made of an identification.
struct RobustReport {
  Robust options;
  int rounds = 0;  ///< in all
  std::vector<RobustJoint> joints;
  Vector chi;                  ///< estimate without it, (b)
  double largest_shift = 0.0;  ///< max |χ̂ − chi| / σ, with the deviations σ of the robust estimate
  std::string parameter;       ///< where it is

  template <typename R = RobustReport>
  static constexpr auto fields() {
    return std::tuple(
        Field{"loss", [](const RobustReport& r) { return r.options.kind; }, "`\"huber\"` or `\"bisquare\"`"},
        Field{"tuning",
              [](const RobustReport& r) { return r.options.loss().tuning; },
              "where it leaves least squares, in units of `scale`",
              {.unit = "1"}},
        Field{"rounds", &R::rounds, "times that weights and parameters were found in turn"},
        Field{"joints", &R::joints,
              "one a joint: `name`; `scale` of its residuals in N·m or N; `rows`; of these with a weight "
              "below 1 `below_one`, below 1/2 `below_half`, without any `rejected`"},
        Field{"largest_shift",
              &R::largest_shift,
              "the largest distance from the estimate without it, in σ",
              {.unit = "1"}},
        Field{"parameter", &R::parameter, "that it is of"},
        Field{"without",
              nullptr,
              "`chi`, the estimate without it, in the order of `parameters`",
              {.unit = "SI"}});
  }
};

}  // namespace rivid
