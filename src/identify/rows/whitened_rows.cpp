#include "identify/rows/whitened_rows.hpp"

#include <cmath>

namespace rivid::detail {

namespace {

// The order with the least BIC.
Index best_order(const StreamingQr& lagged) {
  const auto rows = static_cast<double>(lagged.rows());
  const Vector z = lagged.qty();
  double squares = lagged.unreachable_norm() * lagged.unreachable_norm() + z.squaredNorm();
  Index best = 0;
  if (!(squares > 0.0)) {
    return best;
  }
  double least = rows * std::log(squares);
  for (Index p = 1; p <= z.size(); ++p) {
    squares -= z[p - 1] * z[p - 1];
    if (!(squares > 0.0)) {
      break;
    }
    const double criterion = rows * std::log(squares) + static_cast<double>(p) * std::log(rows);
    if (criterion < least) {
      least = criterion;
      best = p;
    }
  }
  return best;
}

}  // namespace

Autoregression autoregression(const StreamingQr& lagged, Index order) {
  // Stretches this short are not enough for a model.
  if (lagged.rows() <= lagged.columns()) {
    return {};
  }
  const Index p = order > 0 ? order : best_order(lagged);
  const Vector z = lagged.qty();
  const double squares =
      lagged.unreachable_norm() * lagged.unreachable_norm() + z.tail(z.size() - p).squaredNorm();
  return {.ar = lagged.R().topLeftCorner(p, p).triangularView<Eigen::Upper>().solve(z.head(p)),
          .innovation = std::sqrt(squares / static_cast<double>(lagged.rows() - p))};
}

LaggedResidualSink::LaggedResidualSink(StreamingQr& lagged, Vector chi, std::vector<Index> from_V)
    : BufferedSink(2 * chi.size() + 1),
      lagged_(lagged),
      chi_(std::move(chi)),
      from_V_(std::move(from_V)),
      before_(Vector::Zero(lagged.columns())) {}

void LaggedResidualSink::commit(std::span<const Index> samples) {
  const auto count = static_cast<Index>(samples.size());
  const Index own = chi_.size();
  for (const Index c : from_V_) {
    rows_.col(own + c).head(count) = rows_.col(c).head(count);
  }
  const Vector rho = rows_.col(2 * own).head(count) - rows_.topRows(count).middleCols(own, own) * chi_;
  const Index lags = before_.size();
  for (Index k = 0; k < count; ++k) {
    const Index sample = samples[static_cast<std::size_t>(k)];
    run_ = sample - last_ == 1 ? run_ + 1 : 0;
    last_ = sample;
    if (run_ >= lags) {
      const RowsTarget target = lagged_.room(1).target;
      for (Index l = 0; l < lags; ++l) {
        target.data[l * target.ld] = before_[l];
      }
      target.data[lags * target.ld] = rho[k];
      lagged_.commit(1);
    }
    for (Index l = lags - 1; l > 0; --l) {
      before_[l] = before_[l - 1];
    }
    before_[0] = rho[k];
  }
}

WhitenedSink::WhitenedSink(RowSink& to, Vector ar, Index columns)
    : BufferedSink(columns, ar.size()), to_(to), ar_(std::move(ar)) {}

void WhitenedSink::commit(std::span<const Index> samples) {
  const Index p = ar_.size();
  kept_.clear();
  samples_.clear();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    run_ = samples[k] - last_ == 1 ? run_ + 1 : 0;
    last_ = samples[k];
    if (run_ >= p) {
      kept_.push_back(p + static_cast<Index>(k));
      samples_.push_back(samples[k]);
    }
  }
  if (!kept_.empty()) {
    const RowsTarget target = to_.room(static_cast<Index>(kept_.size())).target;
    for (Index c = 0; c < rows_.cols(); ++c) {
      const double* const column = rows_.col(c).data();
      for (std::size_t k = 0; k < kept_.size(); ++k) {
        const Index row = kept_[k];
        double x = column[row];
        for (Index i = 0; i < p; ++i) {
          x -= ar_[i] * column[row - 1 - i];
        }
        target.data[static_cast<Index>(k) + c * target.ld] = x;
      }
    }
    to_.commit(samples_);
  }
  rows_.topRows(p) = rows_.middleRows(static_cast<Index>(samples.size()), p).eval();
}

WhitenedSinks::WhitenedSinks(std::span<RowSink* const> to, std::span<const Vector> ar,
                             std::span<const Index> columns)
    : sinks_(to.begin(), to.end()) {
  whitened_.reserve(ar.size());
  for (std::size_t j = 0; j < ar.size(); ++j) {
    sinks_[j] = &whitened_.emplace_back(*to[j], ar[j], columns[j]);
  }
}

}  // namespace rivid::detail
