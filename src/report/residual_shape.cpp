#include <algorithm>
#include <cmath>
#include <limits>

#include "report/analysis.hpp"

namespace rivid::detail {

namespace {

using Logs = std::vector<const Prediction*>;

// Over five deviations to either side, or as far as the residual goes.
void fill_histogram(const Logs& logs, std::size_t joint, ResidualShape& out) {
  constexpr int bins = 40;
  constexpr double reach = 5.0;
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const Prediction* const log : logs) {
    const Vector& residual = log->joints[joint].residual;
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
  for (const Prediction* const log : logs) {
    for (const double r : log->joints[joint].residual) {
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
  constexpr Index fewest_rows = 8;
  constexpr Index most_lags = 60;
  Logs logs;
  ResidualShape out;
  double sum = 0.0;
  for (const Prediction& log : predictions) {
    if (!log.validation) {
      logs.push_back(&log);
      out.rows += log.joints[joint].residual.size();
      sum += log.joints[joint].residual.sum();
    }
  }
  if (out.rows < fewest_rows) {
    return out;
  }
  out.mean = sum / static_cast<double>(out.rows);
  double squares = 0.0;
  for (const Prediction* const log : logs) {
    squares += (log->joints[joint].residual.array() - out.mean).square().sum();
  }
  out.sigma = std::sqrt(squares / static_cast<double>(out.rows));
  if (!(out.sigma > 0.0)) {
    return out;
  }
  fill_histogram(logs, joint, out);
  const Index lags = std::min(most_lags, out.rows / 4);
  out.autocorrelation.assign(static_cast<std::size_t>(lags), 0.0);
  for (const Prediction* const log : logs) {
    add_products(*log, log->joints[joint], out.mean, lags, out.autocorrelation);
  }
  for (double& product : out.autocorrelation) {
    product /= squares;
  }
  return out;
}

}  // namespace rivid::detail
