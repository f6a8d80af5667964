#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "rivid/data/log.hpp"
#include "rivid/fields.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// How the covariance of an estimate is computed.
enum class CovarianceKind {
  automatic,  ///< classical in Convention::matlab, blocks otherwise
  classical,  ///< (18) of [RIV]: as if the errors of the rows were independent of each other
  hac,  ///< from the errors themselves, however they are correlated over time and among joints: Newey & West
        ///< (1987)
  blocks  ///< that of `hac`, scaled to what the estimate moves by when a block of time is left out: model
          ///< errors that last
};

template <>
inline constexpr std::array names_of<CovarianceKind> =
    std::to_array<std::string_view>({"automatic", "classical", "hac", "blocks"});

struct CovarianceOptions {
  CovarianceKind kind = CovarianceKind::automatic;
  double lag = 0.0;  ///< of `hac` [s], over which errors count as correlated; 0: by a rule from the errors,
                     ///< Andrews (1991)

  [[nodiscard]] std::optional<std::string> complaint() const;

  template <typename C = CovarianceOptions>
  static constexpr auto fields() {
    return std::tuple(
        Field{"covariance", &C::kind,
              "of the estimate, see [statistics](statistics.md). `\"hac\"`: errors are correlated in time "
              "and among joints; `\"blocks\"`: the same, scaled to the scatter of blocks of time; "
              "`\"classical\"`: (18), errors of rows are independent; `\"automatic\"`: classical with "
              "`convention = \"matlab\"`, else blocks"},
        Field{"covariance_lag",
              &C::lag,
              "time over which `\"hac\"` and `\"blocks\"` count residuals as correlated",
              {.otherwise = "by a rule", .unit = "s", .range = Range::above(0.0, 1e6)}});
  }
};

/// Where the standard deviations of an estimate come from.
struct CovarianceReport {
  CovarianceKind kind = CovarianceKind::classical;
  double lag = 0.0;  ///< of `hac` and `blocks` [s]
  int blocks = 0;    ///< of time, of `blocks`; 0 where there were none
  double block_ratio =
      1.0;  ///< of the deviations by blocks over those of `hac`, the median of all parameters
  /// By which deviations were divided to undo what a decimation filter does to white errors, see
  /// deviation_factor(); 1 where nothing was undone.
  double decimation_factor = 1.0;
  /// Half width of a 95 % interval in standard deviations.
  double quantile_975 = 0.0;

  template <typename R = CovarianceReport>
  static constexpr auto fields() {
    return std::tuple(
        Field{"kind", &R::kind,
              "`\"hac\"`, `\"blocks\"` or `\"classical\"`, see [statistics](statistics.md)"},
        Field{"lag", &R::lag, "time over which residuals count as correlated", {.unit = "s"}},
        Field{"blocks", &R::blocks, "of time, of `\"blocks\"`; 0 where there were none"},
        Field{"block_ratio",
              &R::block_ratio,
              "of the deviations by blocks to those of `\"hac\"`, the median: far above 1 where errors of "
              "the model outweigh noise",
              {.unit = "1"}},
        Field{"decimation_factor",
              &R::decimation_factor,
              "by which classical deviations were divided to undo the decimation; 1 where they were not",
              {.unit = "1"}},
        Field{"quantile_975",
              &R::quantile_975,
              "half width of `interval_95` in σ: Student's t, widened for the lag but with `\"classical\"`",
              {.unit = "1"}});
  }
};

/// Standard deviations that weighted least squares would have from regressors without noise, on all samples
/// where joints move: sqrt diag (Σ_j W_jᵀ W_j / σ_j²)⁻¹. No method can do much better.
///
/// @param log    of the motion, without noise
/// @param sigma  standard deviation of each joint's torque errors, white from sample to sample, (n) [N·m | N]
/// @return       (b), SI, in the order of base_parameters()
/// @throws InputError  where robot and log do not fit together
[[nodiscard]] Vector deviation_bound(const Robot& robot, const Log& log, const Vector& sigma);

}  // namespace rivid
