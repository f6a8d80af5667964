#include "identify/robust_covariance.hpp"

#include <cmath>

#include "dense.hpp"

namespace rivid::detail {

namespace {

double rows_of(std::span<const RobustSums> sums) {
  Index rows = 0;
  for (const RobustSums& joint : sums) {
    rows += joint.rows;
  }
  return static_cast<double>(rows);
}

}  // namespace

RobustInformation robust_information(std::span<const RobustSums> sums, const RowLoss& loss,
                                     std::span<const double> weights, Index b) {
  RobustInformation out;
  const double all = rows_of(sums);
  const double share = static_cast<double>(b) / all;
  double squares = 0.0;
  double slopes = 0.0;
  for (std::size_t j = 0; j < sums.size(); ++j) {
    const RobustSums& joint = sums[j];
    if (joint.rows == 0) {
      out.bread.push_back(weights[j]);
      out.meat.push_back(weights[j]);
      continue;
    }
    const auto rows = static_cast<double>(joint.rows);
    const double slope = joint.slopes / rows;
    const double variance = joint.slope_squares / rows - slope * slope;
    // The parameters take their share of the residuals, and what they take depends on the slopes of the others:
    // [Huber 1981], (6.2) and (6.5).
    const double correction = 1.0 + share * variance / (slope * slope);
    const double psi_square = correction * correction * joint.psi_squares / (rows * (1.0 - share));
    const double error = weights[j] * loss.scales[j];
    out.bread.push_back(weights[j] * std::sqrt(slope));
    out.meat.push_back(weights[j] * error * std::sqrt(psi_square));
    squares += rows * error * error * psi_square;
    slopes += joint.slopes;
  }
  out.sigma = std::sqrt(squares / slopes);
  return out;
}

Matrix bread_from_slopes(const Matrix& curvature, const Matrix& bread) {
  return solve(bread * curvature, bread);
}

double robust_deviation(std::span<const RobustSums> sums, const RowLoss& loss,
                        std::span<const double> weights) {
  double squares = 0.0;
  for (std::size_t j = 0; j < sums.size(); ++j) {
    squares += static_cast<double>(sums[j].rows) * std::pow(weights[j] * loss.scales[j], 2);
  }
  return std::sqrt(squares / rows_of(sums));
}

}  // namespace rivid::detail
