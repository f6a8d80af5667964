#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "report/document.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/prediction.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/report/friction_curves.hpp"

// Figures that the page of an identification shows besides those of the result.
namespace rivid::detail {

// The residual of one joint's rows over the logs of the identification.
struct ResidualShape {
  Index rows = 0;
  double mean = 0.0;
  double sigma = 0.0;
  double first_edge = 0.0;  // of the histogram …
  double bin = 0.0;         // … and the width of its bins
  std::vector<double> counts;
  Index outside = 0;                    // rows beyond the histogram
  std::vector<double> autocorrelation;  // at lags of 1, 2 … rows; empty where rows are few
};

[[nodiscard]] ResidualShape residual_shape(std::span<const Prediction> predictions, std::size_t joint);

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

// The law alone, without what the rows have.
//
// @param load  |τ| of the gear that friction in proportion to the load is shown at [N·m | N]
[[nodiscard]] FrictionCurve friction_law(const Robot& robot, const Identification& result, std::size_t joint,
                                         double most_speed, double load);

// @param rows  of the joint, at least one
[[nodiscard]] FrictionCurve friction_curve(const Robot& robot, const Identification& result,
                                           std::size_t joint, const StackedRows& rows);

// Amplitudes of sinusoids that fit a series best, one by one: √(a² + b²) of a cos ωt + b sin ωt, root mean square over
// stretches of equal length. Rows need not be evenly spaced [Lomb 1976].
struct Spectrum {
  Vector frequency;    // cycles per unit of the abscissa
  Vector amplitude;    // unit of the series
  double noise = 0.0;  // that white noise of the same variance stays below at 99 % of the frequencies
};

// @param x         ascending, or not
// @param most      highest frequency
// @param count     of frequencies, most / count apart
[[nodiscard]] Spectrum amplitude_spectrum(const Vector& x, const Vector& values, double most, Index count);

// Every so many rows, so that no more than these are left.
[[nodiscard]] std::vector<Index> every_few(Index rows, Index most);

// Correlation of the estimates, C_ij / √(C_ii C_jj); not a number where a deviation is not one or is zero.
[[nodiscard]] Matrix correlation(const Matrix& covariance);

// Root mean square of the torque that each parameter causes, W_i χ_i, in deviations of the residual: of the joint that shows it
// best, (b).
[[nodiscard]] Vector excitation(const Identification& result, std::span<const Prediction> predictions);

// Joints' origins and the equivalent ellipsoids of the links, of uniform density with the mass and inertia of the link, in the
// frame of the base; links without mass, or whose inertia no body can have, have none.
[[nodiscard]] Skeleton skeleton_of(const Robot& robot, const Vector& q);
void add_ellipsoids(const Robot& robot, const Vector& q, const std::vector<Inertial>& inertials,
                    const std::string& style, Skeleton& out);

}  // namespace rivid::detail
