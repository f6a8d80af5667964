#include "identify/figures/residual_shape.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "identify/figures/joint_rows.hpp"

namespace rivid::detail {

namespace {

using Logs = std::span<const Prediction>;

// Over five deviations to either side, or as far as the residual goes.
void fill_histogram(Logs logs, std::size_t joint, ResidualShape& out) {
  constexpr int bins = 40;       // a quarter of σ each over ±5 σ
  constexpr double reach = 5.0;  // σ; a normal residual goes beyond in 6 of 10 million rows
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const Prediction& log : logs) {
    const Vector& residual = log.joints[joint].residual;
    if (residual.size() > 0) {
      least = std::min(least, residual.minCoeff());
      most = std::max(most, residual.maxCoeff());
    }
  }
  least = std::max(least, out.mean - reach * out.sigma);
  most = std::min(most, out.mean + reach * out.sigma);
  out.first_edge = least;
  out.bin = (most - least) / bins;
  out.counts.assign(bins, 0.0);
  for (const Prediction& log : logs) {
    for (const double r : log.joints[joint].residual) {
      if (r < least || r > most) {
        ++out.outside;
      } else {
        ++out.counts[std::min<std::size_t>(static_cast<std::size_t>((r - least) / out.bin), bins - 1)];
      }
    }
  }
}

// Of rows that lie whole strides apart; pairs with a gap between them count for the lag that they have.
void add_products(const Prediction& log, const JointPrediction& joint, double mean, Index lags,
                  std::vector<double>& products) {
  const std::vector<Index>& rows = joint.rows;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    for (std::size_t other = k + 1; other < rows.size(); ++other) {
      const Index apart = rows[other] - rows[k];
      if (apart > lags * log.row_stride) {
        break;
      }
      if (apart % log.row_stride == 0) {
        products[static_cast<std::size_t>(apart / log.row_stride) - 1] +=
            (joint.residual[static_cast<Index>(k)] - mean) *
            (joint.residual[static_cast<Index>(other)] - mean);
      }
    }
  }
}

}  // namespace

ResidualShape residual_shape(std::span<const Prediction> predictions, std::size_t joint) {
  constexpr Index fewest_rows = 8;  // any few: a shape of fewer shows nothing
  constexpr Index most_lags = 60;   // of the plot; a choice
  const Logs logs = fitted_logs(predictions);
  ResidualShape out;
  double sum = 0.0;
  for (const Prediction& log : logs) {
    out.rows += log.joints[joint].residual.size();
    sum += log.joints[joint].residual.sum();
  }
  if (out.rows < fewest_rows) {
    return out;
  }
  out.mean = sum / static_cast<double>(out.rows);
  double squares = 0.0;
  for (const Prediction& log : logs) {
    squares += (log.joints[joint].residual.array() - out.mean).square().sum();
  }
  out.sigma = std::sqrt(squares / static_cast<double>(out.rows));
  if (!(out.sigma > 0.0)) {
    return out;
  }
  fill_histogram(logs, joint, out);
  const Index lags = std::min(most_lags, out.rows / 4);
  out.autocorrelation.assign(static_cast<std::size_t>(lags), 0.0);
  for (const Prediction& log : logs) {
    add_products(log, log.joints[joint], out.mean, lags, out.autocorrelation);
  }
  for (double& product : out.autocorrelation) {
    product /= squares;
  }
  return out;
}

Spectrum amplitude_spectrum(const Vector& x, const Vector& values, double most, Index count) {
  Spectrum out;
  const Index rows = x.size();
  if (rows < 8 || count < 1 || !(most > 0.0)) {
    return out;
  }
  const double step = most / static_cast<double>(count);
  out.frequency = Vector::LinSpaced(count, step, most);
  // A stretch resolves frequencies that are one over its length apart: stretches as long as the grid is fine.
  const double length = x.maxCoeff() - x.minCoeff();
  const auto stretches = std::clamp<Index>(static_cast<Index>(length * step), 1, rows / 8);
  const Vector centred = values.array() - values.mean();
  Vector squares = Vector::Zero(count);
  for (Index s = 0; s < stretches; ++s) {
    const Index first = rows * s / stretches;
    const Index size = rows * (s + 1) / stretches - first;
    const Eigen::ArrayXd angle = 2.0 * std::numbers::pi * step * x.segment(first, size).array();
    const Eigen::ArrayXd r = centred.segment(first, size).array();
    // cos and sin of k ω t from those of (k − 1) ω t: no more than one function a row.
    const Eigen::ArrayXd c1 = angle.cos();
    const Eigen::ArrayXd s1 = angle.sin();
    Eigen::ArrayXd c = Eigen::ArrayXd::Ones(size);
    Eigen::ArrayXd d = Eigen::ArrayXd::Zero(size);
    for (Index k = 0; k < count; ++k) {
      const Eigen::ArrayXd next = c * c1 - d * s1;
      d = c * s1 + d * c1;
      c = next;
      // The best a and b of r ≈ a cos + b sin.
      Eigen::Matrix2d normal;
      normal << c.square().sum(), (c * d).sum(), (c * d).sum(), d.square().sum();
      const Eigen::Vector2d right((r * c).sum(), (r * d).sum());
      const double determinant = normal.determinant();
      if (determinant > 1e-6 * normal.trace() * normal.trace()) {
        squares[k] += (normal.inverse() * right).squaredNorm();
      }
    }
  }
  out.amplitude = (squares / static_cast<double>(stretches)).cwiseSqrt();
  // Of white noise N (a² + b²) / (2 σ²) is χ² with 2 degrees of freedom a stretch; 2.326 is the 99 % quantile
  // of the normal distribution in the cube-root approximation of χ² by Wilson and Hilferty.
  const double freedom = 2.0 * static_cast<double>(stretches);
  const double cube = 1.0 - 2.0 / (9.0 * freedom) + 2.326 * std::sqrt(2.0 / (9.0 * freedom));
  const double chi_squared = freedom * cube * cube * cube;
  const double rows_of_stretch = static_cast<double>(rows) / static_cast<double>(stretches);
  const double variance = centred.squaredNorm() / static_cast<double>(rows);
  out.noise = std::sqrt(chi_squared * 2.0 * variance / (rows_of_stretch * static_cast<double>(stretches)));
  return out;
}

}  // namespace rivid::detail
