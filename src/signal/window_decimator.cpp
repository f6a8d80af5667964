#include "signal/window_decimator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rivid::detail {

namespace {

// Samples that are asked for at a time.
constexpr Index block = 256;

}  // namespace

Vector decimation_window(Index n_d) {
  Vector h(2 * n_d - 1);
  for (Index m = 1 - n_d; m < n_d; ++m) {
    h[m + n_d - 1] = 0.5 *
                     (1.0 + std::cos(std::numbers::pi * static_cast<double>(m) / static_cast<double>(n_d))) /
                     static_cast<double>(n_d);
  }
  return h;
}

WindowDecimator::WindowDecimator(Index columns, Index n_d, std::vector<Index> centres)
    : n_d_(n_d),
      centres_(std::move(centres)),
      window_(decimation_window(n_d)),
      buffer_(2 * n_d - 1 + block, columns) {}

RowsRoom WindowDecimator::room() {
  if (filled_ == buffer_.rows()) {
    const Index wanted = next_ < centres_.size() ? centres_[next_] - n_d_ + 1 : first_ + filled_;
    const Index gone = std::clamp<Index>(wanted - first_, 0, filled_);
    for (Index c = 0; c < buffer_.cols(); ++c) {
      double* const column = buffer_.col(c).data();
      std::copy(column + gone, column + filled_, column);
    }
    first_ += gone;
    filled_ -= gone;
  }
  return {{buffer_.data() + filled_, buffer_.rows()}, std::min(block, buffer_.rows() - filled_)};
}

void WindowDecimator::commit(Index samples) { filled_ += samples; }

Index WindowDecimator::finished() const {
  const auto* const first = centres_.data() + next_;
  const auto* const last = centres_.data() + centres_.size();
  return std::lower_bound(first, last, first_ + filled_ - n_d_ + 1) - first;
}

void WindowDecimator::take(Index count, const RowsTarget& to) {
  for (Index c = 0; c < buffer_.cols(); ++c) {
    for (Index k = 0; k < count; ++k) {
      const Index begin = centres_[next_ + static_cast<std::size_t>(k)] - n_d_ + 1 - first_;
      to.data[k + c * to.ld] = window_.dot(buffer_.col(c).segment(begin, window_.size()));
    }
  }
  next_ += static_cast<std::size_t>(count);
}

}  // namespace rivid::detail
