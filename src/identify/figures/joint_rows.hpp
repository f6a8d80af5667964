#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/robot.hpp"

// The rows of a joint over the logs of an identification, and what they say together.
namespace rivid::detail {

/// @throws InputError  in the name of `who`, where robot, result and predictions do not belong together
void require_fitting(std::string_view who, const Robot& robot, const Identification& result,
                     std::span<const Prediction> predictions);

// Whether there is anything to show beside what was measured.
[[nodiscard]] inline bool predicted(const Identification& result) { return result.chi.allFinite(); }

// The logs of the identification, which come first.
[[nodiscard]] std::span<const Prediction> fitted_logs(std::span<const Prediction> logs);

// Parts of the torque of a joint: Σ |part| over the rows as a share of the sum for all four parts.
struct TorqueShares {
  double gravity = 0.0;
  double inertia = 0.0;
  double coriolis = 0.0;
  double friction = 0.0;
};

// Of the logs of the identification; not numbers where there is no row or no estimate.
[[nodiscard]] TorqueShares torque_shares(std::span<const Prediction> predictions, std::size_t joint);

// ‖Y − Ŷ‖ / ‖Y‖ of one joint's rows, where Ŷ is the torque of the robot description.
[[nodiscard]] double a_priori_error(const Prediction& log, std::size_t joint);

// The rows of one joint over some logs, one log after the other.
struct StackedRows {
  std::vector<const Prediction*> logs;
  Vector time;  // [s]; the second log begins where the first one ends
  Vector position;
  Vector velocity;
  Vector measured;
  Vector predicted;
  Vector a_priori;
  Vector residual;
  Vector friction;            // measured less all of the model that is no friction [N·m | N]
  std::vector<Index> begins;  // row at which each stretch without gaps begins
};

[[nodiscard]] StackedRows stacked_rows(std::span<const Prediction> logs, std::size_t joint);

// ‖Y − Ŷ‖ / ‖Y‖ of these rows, where Ŷ is the torque of the model.
[[nodiscard]] double relative_error(const StackedRows& rows);

// Every so many rows, so that no more than these are left.
[[nodiscard]] std::vector<Index> every_few(Index rows, Index most);

// Correlation of the estimates, C_ij / √(C_ii C_jj); not a number where a deviation is not one or is zero.
[[nodiscard]] Matrix correlation(const Matrix& covariance);

// Root mean square of the torque that each parameter causes, W_i χ_i, in deviations of the residual: of the
// joint that shows it best, (b).
[[nodiscard]] Vector excitation(const Identification& result, std::span<const Prediction> predictions);

}  // namespace rivid::detail
