#include "rivid/signal/streaming_decimator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "message.hpp"
#include "projection.hpp"
#include "rivid/error.hpp"
#include "rivid/signal/decimate.hpp"

namespace rivid {

namespace {

// Segments that are processed at a time: enough to share the cost of fading into the open rows, few enough to stay in
// the cache.
constexpr Index batch = 32;

// The product without the care for infinities that the operator of std::complex takes, which costs more than itself.
std::complex<double> times(const std::complex<double>& a, const std::complex<double>& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

std::complex<double> upper_pole(const SecondOrderSection& section) {
  const double half = -0.5 * section.a1;
  return {half, std::sqrt(std::max(section.a2 - half * half, 0.0))};
}

}  // namespace

StreamingDecimator::StreamingDecimator(Index columns, int n_d) : n_d_(n_d) {
  if (columns < 0 || n_d < 2) {
    throw InputError(detail::message("StreamingDecimator: columns is ", columns, " and n_d is ", n_d,
                                     ", must be at least 0 and 2"));
  }
  const Filter filter = decimation_filter(n_d);
  double gain = 1.0;  // of H = gain Π (1 + 1/z) / (1 − p/z)
  std::array<Complex, 2 * modes> poles;
  for (std::size_t i = 0; i < modes; ++i) {
    gain *= filter.sections[i].b0;
    pole_[i] = upper_pole(filter.sections[i]);
    poles[i] = pole_[i];
    poles[modes + i] = std::conj(pole_[i]);
  }
  Complex product = 1.0;
  for (const Complex& p : poles) {
    product *= p;
  }
  direct_ = gain * gain / product.real();
  constexpr double order = 2.0 * modes;
  for (std::size_t i = 0; i < modes; ++i) {
    const Complex p = pole_[i];
    Complex residue = gain * gain * std::pow(1.0 + 1.0 / p, order) * std::pow(1.0 + p, order);
    for (std::size_t k = 0; k < poles.size(); ++k) {
      residue /= (1.0 - poles[k] * p) * (k == i ? Complex(1.0) : 1.0 - poles[k] / p);
    }
    residue_[i] = 2.0 * residue;
    step_[i] = std::pow(p, n_d);
  }

  weights_.resize(detail::projections, n_d);
  for (Index m = 0; m < n_d; ++m) {
    for (Index i = 0; i < modes; ++i) {
      const Complex forwards = std::pow(pole_[static_cast<std::size_t>(i)], static_cast<double>(n_d - 1 - m));
      const Complex backwards = std::pow(pole_[static_cast<std::size_t>(i)], static_cast<double>(m + 1));
      weights_(i, m) = forwards.real();
      weights_(modes + i, m) = forwards.imag();
      weights_(2 * modes + i, m) = backwards.real();
      weights_(3 * modes + i, m) = backwards.imag();
    }
  }
  double modulus = 0.0;
  for (const Complex& q : step_) {
    modulus = std::max(modulus, std::abs(q));
  }
  const auto length =
      static_cast<Index>(std::ceil(std::log(std::numeric_limits<double>::epsilon()) / std::log(modulus)));
  fading_.resize(2 * modes, length);
  for (Index d = 1; d <= length; ++d) {
    for (Index i = 0; i < modes; ++i) {
      const auto mode = static_cast<std::size_t>(i);
      const Complex factor = residue_[mode] * std::pow(step_[mode], static_cast<double>(d));
      fading_(i, length - d) = factor.real();
      fading_(modes + i, length - d) = -factor.imag();
    }
  }
  buffer_.resize(batch * n_d_, columns);
  forward_.resize(2 * modes, columns);
  open_.resize(length + batch + 1, columns);
}

// What a state adds to the output at its own place.
double StreamingDecimator::shown(const Modes& state) const {
  double out = 0.0;
  for (std::size_t i = 0; i < modes; ++i) {
    out += residue_[i].real() * state[i].real() - residue_[i].imag() * state[i].imag();
  }
  return out;
}

void StreamingDecimator::begin(const Eigen::Ref<const Eigen::RowVectorXd>& first) {
  for (Index c = 0; c < first.size(); ++c) {
    Modes state;
    for (std::size_t i = 0; i < modes; ++i) {
      state[i] = first[c] / (1.0 - pole_[i]);
      forward_(static_cast<Index>(i), c) = state[i].real();
      forward_(modes + static_cast<Index>(i), c) = state[i].imag();
    }
    open_(0, c) = direct_ * first[c] + shown(state);
  }
  open_count_ = 1;
  begun_ = true;
}

// A backward state at the last row enters the rows before it.
void StreamingDecimator::fade(Index column, const Modes& state) {
  Eigen::Matrix<double, 2 * modes, 1> parts;
  for (Index i = 0; i < modes; ++i) {
    parts[i] = state[static_cast<std::size_t>(i)].real();
    parts[modes + i] = state[static_cast<std::size_t>(i)].imag();
  }
  const Index reached = std::min(fading_.cols(), open_count_ - 1);
  open_.col(column).segment(open_count_ - 1 - reached, reached) +=
      fading_.rightCols(reached).transpose() * parts;
}

void StreamingDecimator::process(Index segments) {
  std::array<double, batch * detail::projections> projected;
  const auto mode_of = [&](Index segment, Index direction, std::size_t mode) -> Complex {
    const double* const p = projected.data() + detail::projections * segment + 2 * modes * direction + mode;
    return {p[0], p[modes]};
  };
  for (Index c = 0; c < buffer_.cols(); ++c) {
    detail::project_segments(weights_.data(), n_d_, buffer_.col(c).data(), segments, projected.data());
    Modes state;
    for (std::size_t i = 0; i < modes; ++i) {
      state[i] = {forward_(static_cast<Index>(i), c), forward_(modes + static_cast<Index>(i), c)};
    }
    for (Index s = 0; s < segments; ++s) {
      for (std::size_t i = 0; i < modes; ++i) {
        state[i] = times(step_[i], state[i]) + mode_of(s, 0, i);
      }
      open_(open_count_ + s, c) = direct_ * buffer_((s + 1) * n_d_ - 1, c) + shown(state);
    }
    for (std::size_t i = 0; i < modes; ++i) {
      forward_(static_cast<Index>(i), c) = state[i].real();
      forward_(modes + static_cast<Index>(i), c) = state[i].imag();
    }
    state = {};
    for (Index s = segments - 1; s >= 0; --s) {
      for (std::size_t i = 0; i < modes; ++i) {
        state[i] = times(step_[i], state[i]) + mode_of(s, 1, i);
      }
      open_(open_count_ - 1 + s, c) += shown(state);
    }
    fade(c, state);
  }
  open_count_ += segments;
}

// Moves the oldest rows to `out` from row `first` on; tells how many.
Index StreamingDecimator::take(Index count, Matrix& out, Index first) {
  if (count <= 0) {
    return 0;
  }
  out.middleRows(first, count) = open_.topRows(count);
  for (Index c = 0; c < open_.cols(); ++c) {
    double* const column = open_.col(c).data();
    std::copy(column + count, column + open_count_, column);
  }
  open_count_ -= count;
  return count;
}

Matrix StreamingDecimator::add(const Eigen::Ref<const Matrix>& x) {
  if (x.cols() != buffer_.cols()) {
    throw InputError(
        detail::message("StreamingDecimator::add: x has ", x.cols(), " columns, must have ", buffer_.cols()));
  }
  Index next = 0;
  if (x.rows() > 0) {
    if (!begun_) {
      begin(x.row(0));
      next = 1;
    }
    last_ = x.row(x.rows() - 1);
  }
  Matrix out((filled_ + x.rows()) / n_d_ + 1, x.cols());
  Index finished = 0;
  while (next < x.rows()) {
    const Index count = std::min(buffer_.rows() - filled_, x.rows() - next);
    buffer_.middleRows(filled_, count) = x.middleRows(next, count);
    filled_ += count;
    next += count;
    if (filled_ == buffer_.rows()) {
      process(batch);
      filled_ = 0;
      finished += take(open_count_ - 1 - fading_.cols(), out, finished);
    }
  }
  out.conservativeResize(finished, Eigen::NoChange);
  return out;
}

Matrix StreamingDecimator::finish() {
  if (!begun_) {
    return Matrix(0, buffer_.cols());
  }
  const Index segments = filled_ / n_d_;
  process(segments);
  const Index tail = filled_ - segments * n_d_;
  for (Index c = 0; c < buffer_.cols(); ++c) {
    // The last sample goes on for ever: Σ_{m ≥ 1} p^m = p / (1 − p), then the samples behind the last row before it.
    const double last = last_[c];
    Modes state;
    for (std::size_t i = 0; i < modes; ++i) {
      state[i] = last * pole_[i] / (1.0 - pole_[i]);
      for (Index m = tail - 1; m >= 0; --m) {
        state[i] = pole_[i] * (state[i] + buffer_(segments * n_d_ + m, c));
      }
    }
    open_(open_count_ - 1, c) += shown(state);
    fade(c, state);
  }
  begun_ = false;
  filled_ = 0;
  Matrix out(open_count_, open_.cols());
  take(open_count_, out, 0);
  return out;
}

}  // namespace rivid
