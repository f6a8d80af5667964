#pragma once

#include <functional>
#include <span>
#include <vector>

#include "identify/reweighting.hpp"
#include "rivid/identify/identification.hpp"
#include "rivid/identify/rows.hpp"

namespace rivid::detail {

// The M-estimate of least squares.
struct RobustLeastSquares {
  Vector chi;
  std::vector<double> weights;  // by joint
  LeastSquares information;     // A by its triangle, unit_covariance being A⁻¹, see RobustInformation
  Matrix C;                     // (b × b) covariance for independent errors; infinite where undetermined
  double sigma = 0.0;           // of RobustInformation
  double deviation = 0.0;       // of the weighted errors but for the outliers
  RowLoss loss;
  std::vector<RobustSums> sums;
  int rounds = 0;
  bool settled = false;
};

// chi       estimate of the unweighted rows
// by_joint  whether the rows of each joint are divided by their scale
[[nodiscard]] RobustLeastSquares robust_least_squares(const Robot& robot, const BaseParameters& base,
                                                      std::span<const Log> logs, const SignalOptions& signal,
                                                      const RowFactors& data, const Vector& chi,
                                                      bool by_joint, const Robust& options, int threads,
                                                      const Progress& progress);

}  // namespace rivid::detail
