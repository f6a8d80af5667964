#include "rivid/signal/decimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "forward_backward.hpp"
#include "rivid/error.hpp"
#include "signal/window_decimator.hpp"
#include "signal_kernels.hpp"

namespace rivid {

namespace {

constexpr int decimation_order = 8;            // of the Chebyshev filter: as MATLAB's decimate()
constexpr double decimation_ripple_db = 0.05;  // [dB] in the pass band, as MATLAB's decimate()
constexpr double decimation_band = 0.8;        // of half the new rate, as MATLAB's decimate()

void check(const char* function, int n_d) {
  if (n_d < 1) {
    throw InputError(std::string(function) + ": n_d is " + std::to_string(n_d) + ", must be at least 1");
  }
}

Index first_kept(Index n_m, int n_d, Convention convention) {
  return convention == Convention::matlab ? (n_m + n_d - 1) % n_d : 0;
}

}  // namespace

Filter decimation_filter(int n_d, Convention convention) {
  check("decimation_filter", n_d);
  if (n_d == 1) {
    return {};
  }
  Filter filter = chebyshev1(decimation_order, decimation_ripple_db, decimation_band / (2.0 * n_d), 1.0);
  if (convention == Convention::standard) {
    const double at_rest = gain(filter, 0.0, 1.0);
    SecondOrderSection& first = filter.sections.front();
    first.b0 /= at_rest;
    first.b1 /= at_rest;
    first.b2 /= at_rest;
  }
  return filter;
}

std::vector<Index> kept_samples(Index n_m, int n_d, Convention convention) {
  check("kept_samples", n_d);
  std::vector<Index> kept;
  for (Index k = first_kept(n_m, n_d, convention); k < n_m; k += n_d) {
    kept.push_back(k);
  }
  return kept;
}

std::vector<Index> kept_samples(Index n_m, const std::vector<int>& stages, Convention convention) {
  std::vector<Index> kept = kept_samples(n_m, 1, convention);
  for (const int n_d : stages) {
    std::vector<Index> still;
    for (const Index k : kept_samples(static_cast<Index>(kept.size()), n_d, convention)) {
      still.push_back(kept[static_cast<std::size_t>(k)]);
    }
    kept = std::move(still);
  }
  return kept;
}

Matrix decimate(const Eigen::Ref<const Matrix>& x, int n_d, Convention convention) {
  check("decimate", n_d);
  if (n_d == 1) {
    return x;
  }
  if (convention == Convention::standard) {
    StreamingDecimator decimator(x.cols(), n_d);
    const Matrix finished = decimator.add(x);
    const Matrix open = decimator.finish();
    Matrix out(finished.rows() + open.rows(), x.cols());
    out << finished, open;
    return out;
  }
  return detail::forward_backward("decimate", x, decimation_filter(n_d, convention), convention,
                                  first_kept(x.rows(), n_d, convention), n_d);
}

Matrix decimate(const Eigen::Ref<const Matrix>& x, const std::vector<int>& stages, Convention convention) {
  Matrix out = x;
  for (const int n_d : stages) {
    out = decimate(out, n_d, convention);
  }
  return out;
}

double deviation_factor(const std::vector<int>& stages, Convention convention) {
  struct Pass {
    Filter filter;
    double f_m;  // per rate of the first stage
  };
  constexpr int points_of_a_row = 64;  // |H|⁴ is smooth over the band of the rows
  std::vector<Pass> passes;
  int n_d = 1;
  for (const int stage : stages) {
    passes.push_back({decimation_filter(stage, convention), 1.0 / n_d});
    n_d *= stage;
  }
  const int points = points_of_a_row * n_d;
  double sum = 0.0;
  for (int k = 0; k < points; ++k) {
    const double f = 0.5 * (k + 0.5) / points;
    double H = 1.0;
    for (const Pass& pass : passes) {
      // Above half the rate of a stage what is left of a frequency shows as its alias.
      const double alias = std::abs(std::remainder(f, pass.f_m));
      H *= gain(pass.filter, alias, pass.f_m);
    }
    sum += H * H * H * H;
  }
  return std::sqrt(n_d * sum / points);
}

}  // namespace rivid

namespace rivid::detail {

namespace {

// Samples that are asked for at a time.
constexpr Index samples_at_once = 256;

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
      buffer_(2 * n_d - 1 + samples_at_once, columns) {}

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
  return {{buffer_.data() + filled_, buffer_.rows()}, std::min(samples_at_once, buffer_.rows() - filled_)};
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

namespace rivid {

namespace {

// Samples that are processed at a time: enough to share the cost of fading into the open rows, few enough
// that the columns of a whole observation matrix stay in the cache.
constexpr Index batch_samples = 160;
// Rows of the buffer before its first segment: the first sample of a series is a row of its own.
constexpr Index lead = 8;

std::complex<double> upper_pole(const SecondOrderSection& section) {
  const double half = -0.5 * section.a1;
  return {half, std::sqrt(std::max(section.a2 - half * half, 0.0))};
}

// Columns an odd number of cache lines apart: at a power of two they would all fall into the same few sets.
Index odd_lines(Index rows) { return ((rows + 7) / 8 | 1) * 8; }

}  // namespace

StreamingDecimator::StreamingDecimator(Index columns, int n_d, Index wanted) : n_d_(n_d) {
  if (columns < 0 || n_d < 2) {
    throw InputError("StreamingDecimator: columns is " + std::to_string(columns) + " and n_d is " +
                     std::to_string(n_d) + ", must be at least 0 and 2");
  }
  const Filter filter = decimation_filter(n_d);
  double gain = 1.0;  // of H = gain Π (1 + 1/z) / (1 − p/z)
  std::array<Complex, 2 * modes> poles;
  for (std::size_t i = 0; i < modes; ++i) {
    gain *= filter.sections[i].b0;
    pole_[i] = upper_pole(filter.sections[i]);
  }
  std::ranges::sort(pole_, std::greater{}, [](const Complex& p) { return std::abs(p); });
  for (std::size_t i = 0; i < modes; ++i) {
    poles[i] = pole_[i];
    poles[modes + i] = std::conj(pole_[i]);
  }
  Complex product = 1.0;
  for (const Complex& p : poles) {
    product *= p;
  }
  direct_ = gain * gain / product.real();
  constexpr double order = 2.0 * modes;  // of the filter: each mode is a pair of poles
  Modes step;
  for (std::size_t i = 0; i < modes; ++i) {
    const Complex p = pole_[i];
    Complex residue = gain * gain * std::pow(1.0 + 1.0 / p, order) * std::pow(1.0 + p, order);
    for (std::size_t k = 0; k < poles.size(); ++k) {
      residue /= (1.0 - poles[k] * p) * (k == i ? Complex(1.0) : 1.0 - poles[k] / p);
    }
    residue_[i] = 2.0 * residue;
    step[i] = std::pow(p, n_d);
    shown_[i] = residue_[i].real();
    shown_[modes + i] = residue_[i].imag();
    step_[i] = step[i].real();
    step_[modes + i] = step[i].imag();
  }

  const Index terms = detail::folded_terms(n_d);
  weights_.resize(4 * modes, terms);
  for (Index k = 0; k < terms; ++k) {
    // The folded samples are those of the first half, the middle, and the last one.
    const auto m = static_cast<double>(k + 1 < terms ? k : n_d - 1);
    for (Index i = 0; i < modes; ++i) {
      const Complex p = pole_[static_cast<std::size_t>(i)];
      const Complex forwards = std::pow(p, n_d - 1.0 - m);
      const Complex backwards = std::pow(p, m + 1.0);
      const Complex half_sum = 0.5 * (forwards + backwards);
      const Complex half_difference = 0.5 * (forwards - backwards);
      weights_.col(k)[i] = half_sum.real();
      weights_.col(k)[modes + i] = half_sum.imag();
      weights_.col(k)[2 * modes + i] = half_difference.real();
      weights_.col(k)[3 * modes + i] = half_difference.imag();
    }
  }

  // Whole vectors of eight rows: then what one mode has stored is what the next one loads.
  const auto reach = [&](const Complex& q) {
    const double rows = std::log(std::numeric_limits<double>::epsilon()) / std::log(std::abs(q));
    return static_cast<long>(std::ceil(rows / 8.0)) * 8;
  };
  std::ranges::transform(step, reach_.begin(), reach);
  const Index length = reach_[0];
  fading_ = Matrix::Zero(length, 2 * modes);
  for (Index i = 0; i < modes; ++i) {
    const auto mode = static_cast<std::size_t>(i);
    for (Index d = 1; d <= length; ++d) {
      const Complex factor = residue_[mode] * std::pow(step[mode], static_cast<double>(d));
      fading_(length - d, i) = factor.real();
      fading_(length - d, modes + i) = -factor.imag();
    }
  }
  const Index batches = std::max<Index>(1, (wanted + batch() * n_d_ - 1) / (batch() * n_d_));
  capacity_ = batches * batch() * n_d_;
  buffer_.resize(odd_lines(lead + capacity_), columns);
  forward_.resize(2 * modes, columns);
  open_.resize(odd_lines(length + batches * batch() + 1), columns);
  folded_.resize(2 * terms * batch());
  unknown_ = Matrix::Zero(2 * modes, columns);
}

// Segments that are processed at a time.
Index StreamingDecimator::batch() const { return std::max<Index>(1, batch_samples / n_d_); }

// The first sample is the first row: the series was constant before.
void StreamingDecimator::begin() {
  for (Index c = 0; c < buffer_.cols(); ++c) {
    const double first = buffer_(lead - 1, c);
    double row = direct_ * first;
    for (std::size_t i = 0; i < modes; ++i) {
      const Complex state = first / (1.0 - pole_[i]);
      forward_(static_cast<Index>(i), c) = state.real();
      forward_(modes + static_cast<Index>(i), c) = state.imag();
      row += (residue_[i] * state).real();
    }
    open_(0, c) = row;
  }
  open_first_ = 0;
  open_count_ = 1;
  begun_ = true;
}

void StreamingDecimator::process(Index first, Index segments, const Matrix& later) {
  static_assert(detail::most_segments * 2 >= batch_samples);
  // Rows that nobody took stay, and take memory.
  if (open_count_ + segments > open_.rows()) {
    open_.conservativeResize(odd_lines(2 * (open_count_ + segments)), Eigen::NoChange);
  }
  const detail::DecimationTables tables{.n_d = static_cast<long>(n_d_),
                                        .weights = weights_.data(),
                                        .step = step_.data(),
                                        .residue = shown_.data(),
                                        .direct = direct_,
                                        .fading = fading_.data(),
                                        .length = static_cast<long>(fading_.rows()),
                                        .reach = reach_.data()};
  const auto kernel = detail::signal_kernels().decimate;
  for (Index c = 0; c < buffer_.cols(); ++c) {
    kernel(tables, buffer_.col(c).data() + lead + first, segments, later.col(c).data(),
           forward_.col(c).data(), open_.col(c).data(), open_first_, open_count_, folded_.data());
  }
  open_first_ = 0;
  open_count_ += segments;
}

RowsRoom StreamingDecimator::room() {
  const Index first = begun_ ? lead + filled_ : lead - 1;
  return {{buffer_.data() + first, buffer_.outerStride()}, lead + capacity_ - first};
}

void StreamingDecimator::commit(Index samples) {
  const RowsRoom offered = room();
  if (samples < 0 || samples > offered.rows || (!begun_ && open_count_ > 0)) {
    throw InputError("StreamingDecimator::commit: " + std::to_string(samples) + " samples do not fit, " +
                     std::to_string(offered.rows) + " do, once the rows of the series before are taken");
  }
  if (samples == 0) {
    return;
  }
  if (!begun_) {
    begin();
    --samples;
  }
  filled_ += samples;
  Index done = 0;
  for (; filled_ - done >= batch() * n_d_; done += batch() * n_d_) {
    process(done, batch(), unknown_);
  }
  if (done > 0) {
    filled_ -= done;
    // The sample before goes along, since the series may end here.
    for (Index c = 0; c < buffer_.cols(); ++c) {
      double* const column = buffer_.col(c).data() + lead - 1;
      std::copy(column + done, column + done + filled_ + 1, column);
    }
  }
}

Index StreamingDecimator::finished() const {
  return begun_ ? std::max<Index>(0, open_count_ - 1 - fading_.rows()) : open_count_;
}

void StreamingDecimator::take(Index count, const RowsTarget& to) {
  if (count < 0 || count > finished()) {
    throw InputError("StreamingDecimator::take: " + std::to_string(count) + " rows are asked for, " +
                     std::to_string(finished()) + " are finished");
  }
  for (Index c = 0; c < open_.cols(); ++c) {
    const double* const column = open_.col(c).data() + open_first_;
    std::copy(column, column + count, to.data + c * to.ld);
  }
  open_first_ += count;
  open_count_ -= count;
}

void StreamingDecimator::end() {
  if (!begun_) {
    return;
  }
  const Index segments = filled_ / n_d_;
  const Index tail = filled_ - segments * n_d_;
  // The last sample goes on for ever: Σ_{m ≥ 1} p^m = p / (1 − p), then the samples behind the last row
  // before it.
  Matrix later(2 * modes, buffer_.cols());
  for (Index c = 0; c < buffer_.cols(); ++c) {
    const double* const x = buffer_.col(c).data() + lead + segments * n_d_;
    for (std::size_t i = 0; i < modes; ++i) {
      Complex state = x[tail - 1] * pole_[i] / (1.0 - pole_[i]);
      for (Index m = tail - 1; m >= 0; --m) {
        state = pole_[i] * (state + x[m]);
      }
      later(static_cast<Index>(i), c) = state.real();
      later(static_cast<Index>(modes + i), c) = state.imag();
    }
  }
  process(0, segments, later);
  begun_ = false;
  filled_ = 0;
}

Matrix StreamingDecimator::add(const Eigen::Ref<const Matrix>& x) {
  if (x.cols() != buffer_.cols()) {
    throw InputError("StreamingDecimator::add: x has " + std::to_string(x.cols()) + " columns, must have " +
                     std::to_string(buffer_.cols()));
  }
  Matrix out((open_count_ * n_d_ + filled_ + x.rows()) / n_d_ + 1, x.cols());
  Index rows = 0;
  for (Index next = 0; next < x.rows();) {
    const RowsRoom free = room();
    const Index count = std::min(free.rows, x.rows() - next);
    Eigen::Map<Matrix, 0, Eigen::OuterStride<>>(
        free.target.data, count, x.cols(), Eigen::OuterStride<>(free.target.ld)) = x.middleRows(next, count);
    commit(count);
    next += count;
    const Index ready = finished();
    take(ready, {out.data() + rows, out.rows()});
    rows += ready;
  }
  out.conservativeResize(rows, Eigen::NoChange);
  return out;
}

Matrix StreamingDecimator::finish() {
  end();
  Matrix out(finished(), open_.cols());
  take(out.rows(), {out.data(), out.rows()});
  return out;
}

}  // namespace rivid
