#include "identify/rows/exact_rows.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "rivid/signal/filter.hpp"

namespace rivid::detail {

namespace {

// A velocity stands out of its noise from so many standard deviations on …
constexpr double outstanding = 4.0;
// … and above this part of the joint's own rms velocity, below which the rounding of a log without noise decides.
constexpr double least_velocity = 1e-3;
// Two central differences in a row reach over two samples to each side.
constexpr Index difference_reach = 2;
// Part of the differences that tells the noise, the small ones: the others see reversals. And the mean square of a
// Gaussian within the quantile of that part, in units of its variance.
constexpr double quiet_part = 0.95;
constexpr double quiet_square = 0.7588;
// Σ of the squared binomial coefficients of the fourth difference.
constexpr double fourth_difference_gain = 70.0;

// Standard deviation of the velocity per unit of the position's, for white noise.
double velocity_gain(double f_m, const SignalOptions& options) {
  if (options.cutoff_hz == 0.0) {
    return f_m * std::sqrt(0.5);
  }
  const Filter filter = butterworth(options.order, options.cutoff_hz, f_m);
  const Index half = settling_samples(filter) + difference_reach;
  Matrix impulse = Matrix::Zero(2 * half + 1, 1);
  impulse(half, 0) = 1.0;
  return central_difference(zero_phase(impulse, filter), f_m).norm();
}

// Samples that a row reaches to each side: filters smear a reversal over half a period of their cut-off.
Index reach(double f_m, const SignalOptions& options) {
  double smeared = 0.0;
  for (const double cutoff_hz : {options.cutoff_hz, options.torque_cutoff_hz}) {
    if (cutoff_hz > 0.0) {
      smeared = std::max(smeared, 0.5 * f_m / cutoff_hz);
    }
  }
  return difference_reach + static_cast<Index>(std::ceil(smeared));
}

// Clears the samples that do not lie within a stretch of one direction above the threshold, or near its ends.
void mask_slow(const Vector& velocity, double threshold, Index reach, std::vector<std::uint8_t>& moving) {
  const auto direction = [&](Index k) {
    return std::abs(velocity[k]) > threshold ? (velocity[k] > 0.0 ? 1 : -1) : 0;
  };
  for (Index begin = 0; begin < velocity.size();) {
    Index end = begin + 1;
    while (end < velocity.size() && direction(end) == direction(begin)) {
      ++end;
    }
    // The borders of the log are no reversals.
    const Index from = begin == 0 ? 0 : begin + reach;
    const Index to = end == velocity.size() ? end : end - reach;
    if (direction(begin) == 0 || from >= to) {
      std::fill(moving.begin() + begin, moving.begin() + end, 0);
    } else {
      std::fill(moving.begin() + begin, moving.begin() + from, 0);
      std::fill(moving.begin() + to, moving.begin() + end, 0);
    }
    begin = end;
  }
}

// Σ_i kernel_i x[k + first + i] in place of x[k] of each column, the ends repeated.
void average(Matrix& x, Index first, std::initializer_list<double> kernel) {
  const Index rows = x.rows();
  std::vector<double> before(static_cast<std::size_t>(rows));
  for (Index j = 0; j < x.cols(); ++j) {
    double* const column = x.col(j).data();
    std::copy_n(column, rows, before.begin());
    std::fill_n(column, rows, 0.0);
    Index shift = first;
    for (const double weight : kernel) {
      for (Index k = 0; k < rows; ++k) {
        column[k] += weight * before[static_cast<std::size_t>(std::clamp<Index>(k + shift, 0, rows - 1))];
      }
      ++shift;
    }
  }
}

}  // namespace

double noise_level(const Eigen::Ref<const Vector>& x) {
  const Index m = x.size() - 4;
  if (m < 1) {
    return 0.0;
  }
  Vector squares =
      (x.head(m) - 4.0 * x.segment(1, m) + 6.0 * x.segment(2, m) - 4.0 * x.segment(3, m) + x.tail(m))
          .cwiseAbs2();
  const auto quiet = static_cast<Index>(std::ceil(quiet_part * static_cast<double>(m)));
  std::nth_element(squares.begin(), squares.begin() + (quiet - 1), squares.end());
  const double mean = squares.head(quiet).sum() / static_cast<double>(quiet);
  return std::sqrt(mean / (quiet_square * fourth_difference_gain));
}

void average_torque(Matrix& tau, bool held) {
  if (held) {
    average(tau, -2, {1.0 / 8.0, 3.0 / 8.0, 3.0 / 8.0, 1.0 / 8.0});
  } else {
    average(tau, -1, {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0});
  }
}

Motion averaged_motion(const Eigen::Ref<const Matrix>& q, double f_m) {
  Motion out = differentiate(q, f_m);
  average(out.qd, -1, {1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0});
  average(out.q, -1, {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0});
  return out;
}

std::vector<MotionMask> motion_masks(const Robot& robot, const Matrix& q, const Matrix& filtered, double f_m,
                                     const SignalOptions& options) {
  const Index n = robot.size();
  const double gain = velocity_gain(f_m, options);
  Vector sigma(n);
  for (Index j = 0; j < n; ++j) {
    sigma[j] = gain * noise_level(q.col(j));
  }
  const Index to_each_side = reach(f_m, options);
  const auto threshold_of = [&](const Vector& v, double noise) {
    const double rms = std::sqrt(v.squaredNorm() / static_cast<double>(v.size()));
    return std::max(outstanding * noise, least_velocity * rms);
  };
  std::vector<MotionMask> out(static_cast<std::size_t>(n));
  for (Index j = 0; j < n; ++j) {
    MotionMask& mask = out[static_cast<std::size_t>(j)];
    const Vector v = central_difference(filtered.col(j), f_m);
    mask.threshold = threshold_of(v, sigma[j]);
    if (!options.velocity_threshold.empty()) {
      mask.threshold = std::max(mask.threshold, options.velocity_threshold[static_cast<std::size_t>(j)]);
    }
    mask.moving.assign(static_cast<std::size_t>(q.rows()), 1);
    mask_slow(v, mask.threshold, to_each_side, mask.moving);
  }
  // The dry friction of a motor that several joints turn reverses with that motor.
  for (const Coupling& coupling : robot.couplings) {
    if (coupling.coulomb != Coupling::Coulomb::sum) {
      continue;
    }
    const Vector c = coupling.row(n);
    const Vector v = central_difference(filtered * c, f_m);
    const double threshold = threshold_of(v, c.cwiseProduct(sigma).norm());
    for (Index j = 0; j < n; ++j) {
      if (c[j] != 0.0) {
        mask_slow(v, threshold, to_each_side, out[static_cast<std::size_t>(j)].moving);
      }
    }
  }
  return out;
}

std::vector<Index> window_centres(const MotionMask& mask, Index first, Index count, Index n_d) {
  const auto moving = [&](Index k) { return mask.moving[static_cast<std::size_t>(first + k)] != 0; };
  std::vector<Index> out;
  for (Index begin = 0; begin < count; ++begin) {
    Index end = begin;
    while (end < count && moving(end)) {
      ++end;
    }
    for (Index centre = begin + n_d - 1; centre + n_d <= end; centre += n_d) {
      out.push_back(centre);
    }
    begin = end;
  }
  return out;
}

}  // namespace rivid::detail
