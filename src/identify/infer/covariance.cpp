#include "identify/infer/covariance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "dense.hpp"
#include "ranges.hpp"
#include "rivid/signal/decimate.hpp"
#include "rivid/solve/inference.hpp"
#include "signal/window_decimator.hpp"

namespace rivid {

std::optional<std::string> CovarianceOptions::complaint() const { return range_fault(*this); }

namespace detail {

namespace {

Index intervals(std::span<const Matrix> series) { return sum_of(series, &Matrix::rows); }

TestResult chi_square_test(double statistic, double freedom) {
  return {.statistic = statistic, .freedom = freedom, .p = chi_square_tail(statistic, freedom)};
}

// Variances of the parameters by what they are without each block; some are not finite where a block
// determines one alone.
Vector jackknife_variance(std::span<const BlockSums> blocks, const Matrix& bread) {
  const Index b = bread.rows();
  const auto G = static_cast<Index>(blocks.size());
  Matrix left_out(b, G);
  Matrix influence(b, G);
  for (Index g = 0; g < G; ++g) {
    const BlockSums& block = blocks[static_cast<std::size_t>(g)];
    influence.col(g) = bread * block.Z_rho;
    // χ̂ without the block: (A − A_g)⁻¹ (a − a_g).
    left_out.col(g) = -solve(Matrix::Identity(b, b) - bread * block.ZW, influence.col(g));
  }
  left_out.colwise() -= left_out.rowwise().mean().eval();
  // A block draws the estimate towards itself: its influence is too small by one minus its leverage, and what
  // the estimate without it moves by too large by as much. With errors that last the larger one is the better
  // one by far. Half-way between 1, unbiased for independent errors (HC2), and 2, the jackknife (HC3)
  // [MacKinnon & White 1985].
  constexpr double of_left_out = 1.5;
  const auto count = static_cast<double>(G);
  return (count - 1.0) / count * left_out.rowwise().norm().array().pow(of_left_out) *
         influence.rowwise().norm().array().pow(2.0 - of_left_out);
}

}  // namespace

Index lag_of(std::span<const Matrix> series, double interval, const CovarianceOptions& options) {
  return options.lag > 0.0 ? static_cast<Index>(std::min(std::ceil(options.lag / interval),
                                                         static_cast<double>(intervals(series))))
                           : bartlett_lag(series);
}

double decimation_factor(const SignalOptions& signal) {
  if (signal.decimation.empty() || signal.convention == Convention::matlab) {
    return 1.0;
  }
  if (signal.exact_rows()) {
    const Index n_d = stride_of(signal);
    return std::sqrt(static_cast<double>(n_d) * decimation_window(n_d).squaredNorm());
  }
  return deviation_factor(signal.decimation, signal.convention);
}

CovarianceKind resolved(CovarianceKind kind, Convention convention) {
  if (kind != CovarianceKind::automatic) {
    return kind;
  }
  return convention == Convention::matlab ? CovarianceKind::classical : CovarianceKind::blocks;
}

Uncertainty classical_covariance(const SignalOptions& signal, double sigma, const Matrix& unit_covariance,
                                 double freedom) {
  const double factor = decimation_factor(signal);
  const double deviation = sigma / factor;
  return {.C = deviation * deviation * unit_covariance,
          .plain_sigma = {},
          .report = {.kind = CovarianceKind::classical,
                     .decimation_factor = factor,
                     .quantile_975 = student_quantile_975(freedom)}};
}

Uncertainty hac_covariance(std::span<const Matrix> series, double interval, const Matrix& bread,
                           const CovarianceOptions& options, double freedom) {
  const Index lag = lag_of(series, interval, options);
  const Matrix S = long_run_covariance(series, lag);
  const auto instants = static_cast<double>(intervals(series));
  return {
      .C = bread * S * bread.transpose(),
      .plain_sigma = {},
      .report = {.kind = CovarianceKind::hac,
                 .lag = static_cast<double>(lag) * interval,
                 .quantile_975 = student_quantile_975(freedom) *
                                 fixed_lag_widening(std::min(static_cast<double>(lag + 1) / instants, 1.0))}};
}

void scale_to_blocks(std::span<const BlockSums> blocks, const Matrix& bread, Uncertainty& uncertainty) {
  // Degrees of freedom that the ratio of all parameters counts beside those of one: as many as the ten blocks
  // of a single log have, where both count alike. More blocks know more of each parameter by itself.
  constexpr double common = 9.0;
  // By which deviations shrink at most.
  constexpr double least = 0.5;
  const auto G = static_cast<Index>(blocks.size());
  if (G < 4) {
    return;
  }
  const Vector variance = uncertainty.C.diagonal();
  const Vector by_blocks = jackknife_variance(blocks, bread);
  if (!by_blocks.allFinite()) {
    return;
  }
  const auto usable = [&](Index i) { return std::isfinite(variance[i]) && variance[i] > 0.0; };
  std::vector<double> ratios;
  for (Index i = 0; i < by_blocks.size(); ++i) {
    if (usable(i)) {
      ratios.push_back(by_blocks[i] / variance[i]);
    }
  }
  if (ratios.empty()) {
    return;
  }
  std::ranges::sort(ratios);
  const double middle = 0.5 * (ratios[(ratios.size() - 1) / 2] + ratios[ratios.size() / 2]);
  const auto freedom = static_cast<double>(G - 1);
  // Of a mean of so many squares, relative to its expectation [Wilson & Hilferty 1931]: 0.93 of nine.
  const double median = std::pow(1.0 - 2.0 / (9.0 * freedom), 3);
  const double all = std::max(middle / median, least * least);
  Vector scale = Vector::Ones(variance.size());
  for (Index i = 0; i < scale.size(); ++i) {
    if (usable(i)) {
      const double own = std::max(by_blocks[i] / variance[i], least * least);
      scale[i] = std::sqrt((common * all + freedom * own) / (common + freedom));
    }
  }
  uncertainty.plain_sigma = variance.cwiseSqrt();
  uncertainty.report.kind = CovarianceKind::blocks;
  uncertainty.report.blocks = static_cast<int>(G);
  uncertainty.report.block_ratio = std::sqrt(all);
  uncertainty.C = scale.asDiagonal() * uncertainty.C * scale.asDiagonal();
  uncertainty.report.quantile_975 =
      std::max(uncertainty.report.quantile_975, student_quantile_975(common + freedom));
}

std::vector<ResidualTests> residual_tests(const Robot& robot, const Scores& scores) {
  std::vector<ResidualTests> out;
  for (std::size_t j = 0; j < scores.residuals.size(); ++j) {
    const ResidualMoments& sums = scores.residuals[j];
    ResidualTests& test = out.emplace_back();
    test.joint = robot.joints[j].name;
    const auto rows = static_cast<double>(sums.rows);
    if (sums.rows < 2 || !(sums.powers[1] > 0.0)) {
      constexpr double none = std::numeric_limits<double>::quiet_NaN();
      test.whiteness = test.normality = {.statistic = none, .freedom = none, .p = none};
      test.autocorrelation = test.skewness = test.excess_kurtosis = none;
      continue;
    }
    const double mean = sums.powers[0] / rows;
    const double variance = sums.powers[1] / rows - mean * mean;
    const double third = sums.powers[2] / rows - mean * (3.0 * variance + mean * mean);
    const double fourth =
        sums.powers[3] / rows - mean * (4.0 * third + mean * (6.0 * variance + mean * mean));
    test.skewness = third / std::pow(variance, 1.5);
    test.excess_kurtosis = fourth / (variance * variance) - 3.0;
    test.normality = chi_square_test(
        rows / 6.0 * (test.skewness * test.skewness + 0.25 * test.excess_kurtosis * test.excess_kurtosis),
        2.0);
    double statistic = 0.0;
    double lags = 0.0;
    for (std::size_t l = 0; l < ResidualMoments::lags; ++l) {
      const double pairs = sums.pair_counts[l];
      if (pairs < 1.0) {
        continue;
      }
      // The part of the autocorrelation that gaps leave pairs for.
      const double correlation = sums.products[l] / sums.powers[1] * rows / pairs;
      statistic += correlation * correlation * pairs * (rows + 2.0) / rows;
      ++lags;
      if (l == 0) {
        test.autocorrelation = std::clamp(correlation, -1.0, 1.0);
      }
    }
    if (lags > 0.0) {
      test.whiteness = chi_square_test(statistic, lags);
    }
  }
  return out;
}

HausmanTest hausman_test(const BaseParameters& base, const Vector& shift, std::span<const Matrix> by_iv,
                         const Matrix& bread_iv, std::span<const Matrix> by_ls, const Matrix& bread_ls,
                         double interval, const CovarianceOptions& options, const Vector& sigma) {
  HausmanTest out;
  Index at = 0;
  out.largest_shift = (shift.array() / sigma.array()).abs().maxCoeff(&at);
  out.parameter = base.parameters[static_cast<std::size_t>(at)].name;
  // What each interval adds to the difference of the estimates, in deviations of the estimate.
  const Vector scale = sigma.cwiseInverse();
  const std::vector<Matrix> influence = made_of(by_iv.size(), [&](std::size_t k) {
    return Matrix((by_iv[k] * bread_iv.transpose() - by_ls[k] * bread_ls.transpose()) * scale.asDiagonal());
  });
  const auto instants = static_cast<double>(intervals(influence));
  const Matrix D = long_run_covariance(influence, lag_of(influence, interval, options));
  // Directions in which both estimates agree by construction carry no information.
  constexpr double least = 1e-10;
  const SymmetricEigen eigen = symmetric_eigen(D);
  const Vector along = eigen.vectors.transpose() * scale.cwiseProduct(shift);
  double statistic = 0.0;
  double freedom = 0.0;
  for (Index i = 0; i < along.size(); ++i) {
    if (eigen.values[i] > least * eigen.values.maxCoeff()) {
      statistic += along[i] * along[i] / eigen.values[i];
      ++freedom;
    }
  }
  const double left = std::max(instants - freedom, 1.0);
  out.test.statistic = freedom > 0.0 ? statistic / freedom * left / instants : 0.0;
  out.test.freedom = freedom;
  out.test.p = freedom > 0.0 ? f_tail(out.test.statistic, freedom, left) : 1.0;
  return out;
}

}  // namespace detail

Vector deviation_bound(const Robot& robot, const Log& log, const Vector& sigma) {
  const BaseParameters base = base_parameters(robot);
  const RowFactors rows = factors(robot, base, log, {.rows = RowScheme::exact});
  const Vector inverse = sigma.cwiseInverse();
  const std::vector<double> weights(inverse.begin(), inverse.end());
  return least_squares(rows.groups, base.size(), weights).unit_covariance.diagonal().cwiseSqrt();
}

}  // namespace rivid
