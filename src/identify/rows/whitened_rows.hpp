#pragma once

#include <span>
#include <vector>

#include "identify/rows/row_source.hpp"
#include "rivid/solve/streaming_qr.hpp"

namespace rivid::detail {

// An autoregressive model of a residual, ρ_t = Σ_i ar_i ρ_{t−i} + e_t with e white.
struct Autoregression {
  Vector ar;                // a_1 … a_p
  double innovation = 0.0;  // standard deviation of e
};

// The model of least squares.
//
// lagged  factor of rows ρ_{t−1} … ρ_{t−P} and ρ_t, whose triangle has those of all lower orders in it
// order   of the model; 0: the one up to P with the least BIC [Schwarz 1978]
[[nodiscard]] Autoregression autoregression(const StreamingQr& lagged, Index order);

// Gathers the lagged residuals Y − W χ of a joint's rows [V W Y]. A gap between rows begins a new stretch.
class LaggedResidualSink final : public BufferedSink {
 public:
  // from_V  columns of W that are taken from V
  LaggedResidualSink(StreamingQr& lagged, Vector chi, std::vector<Index> from_V);

  void commit(std::span<const Index> samples) override;

 private:
  StreamingQr& lagged_;
  Vector chi_;
  std::vector<Index> from_V_;
  Vector before_;  // ρ_{t−1}, ρ_{t−2} …
  Index run_ = 0;  // rows since the last gap
  Index last_ = -1;
};

// Sends rows x_t − Σ_i ar_i x_{t−i} on to another sink. The filter starts anew after each gap between rows,
// where the first p rows of a stretch only fill it.
class WhitenedSink final : public BufferedSink {
 public:
  // columns  of the rows
  WhitenedSink(RowSink& to, Vector ar, Index columns);

  void commit(std::span<const Index> samples) override;

 private:
  RowSink& to_;
  Vector ar_;  // (p); the room is behind the last p rows
  Index run_ = 0;
  Index last_ = -1;
  std::vector<Index> kept_;     // of the rows in the room
  std::vector<Index> samples_;  // of these
};

// Sinks that whiten the rows of each joint on their way to other ones.
class WhitenedSinks {
 public:
  // ar       one a joint; empty for none: the sinks are the other ones then
  // columns  of the rows, one a joint
  WhitenedSinks(std::span<RowSink* const> to, std::span<const Vector> ar, std::span<const Index> columns);

  [[nodiscard]] std::span<RowSink* const> sinks() const { return sinks_; }

 private:
  std::vector<WhitenedSink> whitened_;
  std::vector<RowSink*> sinks_;
};

}  // namespace rivid::detail
