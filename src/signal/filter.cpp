#include "rivid/signal/filter.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "rivid/error.hpp"
#include "rivid/text.hpp"
#include "signal/forward_backward.hpp"
#include "signal_kernels.hpp"

namespace rivid {

namespace {

// Below, 1 + a1 + a2 has lost so many digits that the sections are no longer the asked filter.
constexpr double lowest_cutoff = 1e-5;
// Nearer to f_m / 2 a filter passes nearly all and takes as long to settle.
constexpr double least_distance = 1e-5;
// a choice: far above any that is of use
constexpr int highest_order = 100;

void check(const char* function, int order, double cutoff_hz, double f_m) {
  if (order < 1 || order > highest_order) {
    throw InputError(std::string(function) + ": order is " + std::to_string(order) +
                     ", must lie between 1 and " + std::to_string(highest_order));
  }
  if (!std::isfinite(f_m) || f_m <= 0.0) {
    throw InputError(std::string(function) + ": f_m is " + number(f_m, 6) +
                     " Hz, must be positive and finite");
  }
  const bool between = cutoff_hz > 0.0 && cutoff_hz < 0.5 * f_m;
  if (!between) {
    throw InputError(std::string(function) + ": cutoff_hz is " + number(cutoff_hz, 6) +
                     " Hz, must lie between 0 and f_m / 2 = " + number(0.5 * f_m, 6) + " Hz");
  }
  if (cutoff_hz < lowest_cutoff * f_m) {
    throw InputError(std::string(function) + ": cutoff_hz is " + number(cutoff_hz, 6) +
                     " Hz, must be at least 1e-5 f_m = " + number(lowest_cutoff * f_m, 6) +
                     " Hz; decimate first");
  }
  if (0.5 * f_m - cutoff_hz < least_distance * f_m) {
    throw InputError(std::string(function) + ": cutoff_hz is " + number(cutoff_hz, 10) +
                     " Hz, must be at most f_m / 2 - 1e-5 f_m = " + number((0.5 - least_distance) * f_m, 10) +
                     " Hz; without a filter nothing is lost either");
  }
}

// b from the rounded a, so that the gain at f = 0 is 1 to the last digit although a1 and a2 nearly cancel.
SecondOrderSection second_order(double a1, double a2) {
  const double b = 0.25 * ((1.0 + a1) + a2);
  return {.b0 = b, .b1 = 2.0 * b, .b2 = b, .a1 = a1, .a2 = a2};
}

SecondOrderSection first_order(double a1) {
  const double b = 0.5 * (1.0 + a1);
  return {.b0 = b, .b1 = b, .b2 = 0.0, .a1 = a1, .a2 = 0.0};
}

// Bilinear transform of the all-pole prototype with poles −width sin θ ± i height cos θ,
// θ = (2k + 1) π / (2 order), scaled by the prewarped cut-off tan(π f_c / f_m).
Filter low_pass(int order, double width, double height, double cutoff_hz, double f_m) {
  const double warped = std::tan(std::numbers::pi * cutoff_hz / f_m);
  Filter filter{.sections = {}, .order = order};
  if (order % 2 == 1) {
    const double pole = warped * width;
    filter.sections.push_back(first_order((pole - 1.0) / (pole + 1.0)));
  }
  for (int k = order / 2 - 1; k >= 0; --k) {
    const double theta = std::numbers::pi * (2 * k + 1) / (2 * order);
    const double damping = 2.0 * warped * width * std::sin(theta);
    const double modulus =
        std::pow(warped * std::hypot(width * std::sin(theta), height * std::cos(theta)), 2);
    const double a0 = 1.0 + damping + modulus;
    filter.sections.push_back(second_order(2.0 * (modulus - 1.0) / a0, (1.0 - damping + modulus) / a0));
  }
  return filter;
}

double pole_modulus(const SecondOrderSection& section) {
  const double half = 0.5 * section.a1;
  const double discriminant = half * half - section.a2;
  return discriminant < 0.0 ? std::sqrt(section.a2) : std::abs(half) + std::sqrt(discriminant);
}

}  // namespace

Filter butterworth(int order, double cutoff_hz, double f_m) {
  check("butterworth", order, cutoff_hz, f_m);
  return low_pass(order, 1.0, 1.0, cutoff_hz, f_m);
}

Filter chebyshev1(int order, double ripple_db, double cutoff_hz, double f_m) {
  check("chebyshev1", order, cutoff_hz, f_m);
  if (!std::isfinite(ripple_db) || ripple_db <= 0.0) {
    throw InputError("chebyshev1: ripple_db is " + number(ripple_db, 6) + " dB, must be positive and finite");
  }
  const double epsilon = std::sqrt(std::expm1(0.1 * ripple_db * std::numbers::ln10));
  const double mu = std::asinh(1.0 / epsilon) / order;
  Filter filter = low_pass(order, std::sinh(mu), std::cosh(mu), cutoff_hz, f_m);
  if (order % 2 == 0) {
    const double at_rest = std::pow(10.0, -0.05 * ripple_db);
    SecondOrderSection& first = filter.sections.front();
    first.b0 *= at_rest;
    first.b1 *= at_rest;
    first.b2 *= at_rest;
  }
  return filter;
}

double gain(const Filter& filter, double f_hz, double f_m) {
  const std::complex<double> delay = std::polar(1.0, -2.0 * std::numbers::pi * f_hz / f_m);
  double product = 1.0;
  for (const SecondOrderSection& s : filter.sections) {
    product *= std::abs((s.b0 + delay * (s.b1 + delay * s.b2)) / (1.0 + delay * (s.a1 + delay * s.a2)));
  }
  return product;
}

Index settling_samples(const Filter& filter, double level) {
  const bool between = level > 0.0 && level < 1.0;
  if (!between) {
    throw InputError("settling_samples: level is " + number(level, 6) + ", must lie between 0 and 1");
  }
  double r = 0.0;
  for (const SecondOrderSection& section : filter.sections) {
    r = std::max(r, pole_modulus(section));
  }
  constexpr double for_ever = 1LL << 53;  // [samples] the largest integer up to which doubles are exact
  const double samples = r < 1.0 ? std::ceil(std::log(level) / std::log(r)) : for_ever;
  return std::max(static_cast<Index>(std::min(samples, for_ever)), static_cast<Index>(filter.order));
}

}  // namespace rivid

namespace rivid::detail {

namespace {

// part of a transient that is left after the padding; a choice: shorter paddings leave more
constexpr double forgotten = 1e-6;

// A state that dies out in a standstill would end in subnormal numbers, which cost thirty times as much.
constexpr double dead = 1e-250;

// Columns side by side, and instants that are filtered at a time: they stay in the first-level cache.
constexpr Index lanes = 8;
constexpr Index block = 256;
using Block = Eigen::Array<double, lanes, block>;
using Instant = Eigen::Array<double, lanes, 1>;

// A cascade for eight columns and the states of its sections.
class Cascade {
 public:
  explicit Cascade(const Filter& filter) {
    for (const SecondOrderSection& s : filter.sections) {
      coefficients_.insert(coefficients_.end(), {s.b0, s.b1, s.b2, s.a1, s.a2});
    }
    states_.resize(2 * lanes, static_cast<Index>(filter.sections.size()));
  }

  // The steady state for a constant input.
  void settle(const Instant& input) {
    Instant x = input;
    for (Index i = 0; i < states_.cols(); ++i) {
      const double* const s = coefficients_.data() + 5 * i;
      const Instant y = x * (((s[0] + s[1]) + s[2]) / ((1.0 + s[3]) + s[4]));
      states_.col(i) << y - s[0] * x, s[2] * x - s[4] * y;
      x = y;
    }
  }

  void run(Block& x, Index count) {
    signal_kernels().cascade(coefficients_.data(), states_.cols(), states_.data(), x.data(), count);
    states_ = (states_.abs() < dead).select(0.0, states_);
  }

 private:
  std::vector<double> coefficients_;
  Eigen::ArrayXXd states_;
};

struct Task {
  const Eigen::Ref<const Matrix>& x;
  const Filter& filter;
  Index padding;
  Index first;
  Index step;
  Matrix& out;
};

// At most eight columns from `column` on; idle lanes carry zeros. What the way forwards leaves is kept in
// `forward`, which may be the columns of the result itself.
void filter_columns(const Task& task, Index column, Index count, Eigen::Ref<Matrix> forward) {
  const Index n_m = task.x.rows();
  const Index pad = task.padding;
  const auto x = task.x.middleCols(column, count);
  Eigen::ArrayXXd behind = Eigen::ArrayXXd::Zero(lanes, pad);  // the way forwards beyond the last sample
  Block data = Block::Zero();
  Cascade cascade(task.filter);
  const auto reflected = [&](Index k) -> Eigen::ArrayXd {
    const Index end = k < 0 ? 0 : n_m - 1;
    return 2.0 * x.row(end).array() - x.row(2 * end - k).array();
  };

  for (Index begin = -pad; begin < n_m + pad; begin += block) {
    const Index end = std::min(begin + block, n_m + pad);
    const Index inner_begin = std::clamp<Index>(0, begin, end);
    const Index inner_end = std::clamp<Index>(n_m, begin, end);
    for (Index k = begin; k < inner_begin; ++k) {
      data.col(k - begin).head(count) = reflected(k);
    }
    for (Index c = 0; c < count; ++c) {
      for (Index k = inner_begin; k < inner_end; ++k) {
        data(c, k - begin) = x(k, c);
      }
    }
    for (Index k = inner_end; k < end; ++k) {
      data.col(k - begin).head(count) = reflected(k);
    }
    if (begin == -pad) {
      cascade.settle(data.col(0));
    }
    cascade.run(data, end - begin);
    for (Index c = 0; c < count; ++c) {
      for (Index k = inner_begin; k < inner_end; ++k) {
        forward(k, c) = data(c, k - begin);
      }
    }
    for (Index k = inner_end; k < end; ++k) {
      behind.col(k - n_m) = data.col(k - begin);
    }
  }

  for (Index end = n_m + pad; end > 0; end -= block) {
    const Index begin = std::max<Index>(end - block, 0);
    const Index inner_end = std::min(end, n_m);
    for (Index k = end - 1; k >= n_m && k >= begin; --k) {
      data.col(end - 1 - k) = behind.col(k - n_m);
    }
    for (Index c = 0; c < count; ++c) {
      for (Index k = begin; k < inner_end; ++k) {
        data(c, end - 1 - k) = forward(k, c);
      }
    }
    if (end == n_m + pad) {
      cascade.settle(data.col(0));
    }
    cascade.run(data, end - begin);
    const Index first_row = (std::max(begin - task.first, Index{0}) + task.step - 1) / task.step;
    for (Index c = 0; c < count; ++c) {
      for (Index row = first_row; task.first + row * task.step < inner_end; ++row) {
        task.out(row, column + c) = data(c, end - 1 - task.first - row * task.step);
      }
    }
  }
}

}  // namespace

Matrix forward_backward(const char* function, const Eigen::Ref<const Matrix>& x, const Filter& filter,
                        Convention convention, Index first, Index step) {
  const Index n_m = x.rows();
  const Index shortest = 3 * static_cast<Index>(filter.order);
  if (n_m <= shortest) {
    throw InputError(std::string(function) + ": x has " + std::to_string(n_m) +
                     " samples, must have more than " + std::to_string(shortest) +
                     " = 3 times the order of the filter");
  }
  const Index padding =
      convention == Convention::matlab ? shortest : std::min(settling_samples(filter, forgotten), n_m - 1);
  Matrix out((n_m - first + step - 1) / step, x.cols());
  const Task task{x, filter, padding, first, step, out};
  const bool in_place = first == 0 && step == 1;
  Matrix apart(in_place ? 0 : n_m, in_place ? 0 : std::min(lanes, x.cols()));
  for (Index column = 0; column < x.cols(); column += lanes) {
    const Index count = std::min(lanes, x.cols() - column);
    filter_columns(task, column, count, in_place ? out.middleCols(column, count) : apart.leftCols(count));
  }
  return out;
}

}  // namespace rivid::detail

namespace rivid {

Matrix zero_phase(const Eigen::Ref<const Matrix>& x, const Filter& filter, Convention convention) {
  return detail::forward_backward("zero_phase", x, filter, convention, 0, 1);
}

Matrix zero_phase(const Eigen::Ref<const Matrix>& x, double f_m, double cutoff_hz, int order,
                  Convention convention) {
  return zero_phase(x, butterworth(order, cutoff_hz, f_m), convention);
}

}  // namespace rivid
