#include "identify/rows/exact_rows.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "identify/rows/position_noise.hpp"
#include "rivid/signal/filter.hpp"

namespace rivid::detail {

namespace {

// A velocity stands out of its noise from so many standard deviations on, which should be no more than this
// part of its rms …
constexpr double outstanding = 4.0;
constexpr double small_part = 0.01;
// … to which a low-pass brings it, whose cut-off falls by this factor, but not below so many times the end of
// the motion's spectrum: a velocity that is no longer that of the joint has no direction. A stretch of motion
// goes further than so many standard deviations of the position: less is a joint that sticks.
constexpr double least_travel = 12.0;
constexpr double cutoff_step = 1.4;
constexpr double least_cutoff = 0.5;
// … and above this part of the joint's own rms velocity, below which the rounding of a log without noise
// decides.
constexpr double least_velocity = 1e-3;
// Two central differences in a row reach over two samples to each side.
constexpr Index difference_reach = 2;

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
void mask_slow(const Vector& velocity, double threshold, double travel, Index reach,
               std::vector<std::int8_t>& mask) {
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
    if (direction(begin) == 0 || from >= to ||
        std::abs(velocity.segment(begin, end - begin).sum()) < travel) {
      std::fill(mask.begin() + begin, mask.begin() + end, 0);
    } else {
      std::fill(mask.begin() + begin, mask.begin() + from, 0);
      std::fill(mask.begin() + to, mask.begin() + end, 0);
    }
    begin = end;
  }
}

double rms(const Vector& v) { return std::sqrt(v.squaredNorm() / static_cast<double>(v.size())); }

// A velocity from which follows where a joint moves, and its noise.
struct MaskVelocity {
  Vector v;
  double sigma = 0.0;
  double travel = 0.0;  // sum of v over a stretch that noise may pretend
  bool smoothed = false;

  [[nodiscard]] double threshold() const { return std::max(outstanding * sigma, least_velocity * rms(v)); }
};

// q, filtered  measured and filtered positions of a joint, or of a motor that several turn
MaskVelocity mask_velocity(const Vector& q, const Vector& filtered, double f_m,
                           const SignalOptions& options) {
  const PositionNoise noise(q, f_m);
  MaskVelocity out{.v = central_difference(filtered, f_m)};
  const auto deviation_with = [&](const Filter& filter) {
    return noise.deviation() * std::sqrt(RowBand(filter, f_m).velocity_gain());
  };
  const bool prefiltered = options.cutoff_hz > 0.0;
  out.sigma = deviation_with(prefiltered ? butterworth(options.order, options.cutoff_hz, f_m) : Filter{});
  out.travel = least_travel * noise.deviation() * f_m;
  double cutoff_hz = 0.25 * f_m;
  const auto noisy = [&] { return outstanding * out.sigma > small_part * rms(out.v); };
  if (!noisy() || prefiltered) {
    return out;
  }
  while (noisy() && cutoff_hz > least_cutoff * noise.valley()) {
    cutoff_hz /= cutoff_step;
    out.sigma = deviation_with(butterworth(2, cutoff_hz, f_m));
  }
  out.v = central_difference(zero_phase(q, butterworth(2, cutoff_hz, f_m)), f_m);
  out.smoothed = true;
  return out;
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
  return std::sqrt(mean / (quiet_square * fourth_difference_power));
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
  const Index to_each_side = reach(f_m, options);
  std::vector<MotionMask> out(static_cast<std::size_t>(n));
  for (Index j = 0; j < n; ++j) {
    MotionMask& mask = out[static_cast<std::size_t>(j)];
    if (j < robot.base_joints) {  // without friction any speed is good
      mask.direction.assign(static_cast<std::size_t>(q.rows()), 1);
      continue;
    }
    const MaskVelocity found = mask_velocity(q.col(j), filtered.col(j), f_m, options);
    mask.threshold = found.threshold();
    mask.smoothed = found.smoothed;
    if (!options.velocity_threshold.empty()) {
      mask.threshold = std::max(mask.threshold, options.velocity_threshold[static_cast<std::size_t>(j)]);
    }
    mask.direction.resize(static_cast<std::size_t>(q.rows()));
    std::ranges::transform(found.v, mask.direction.begin(),
                           [](double v) { return v < 0.0 ? std::int8_t{-1} : std::int8_t{1}; });
    mask_slow(found.v, mask.threshold, found.travel, to_each_side, mask.direction);
  }
  // The dry friction of a motor that several joints turn reverses with that motor.
  for (const Coupling& coupling : robot.couplings) {
    if (coupling.coulomb != Coupling::Coulomb::sum) {
      continue;
    }
    const Vector c = coupling.row(n);
    const MaskVelocity found = mask_velocity(q * c, filtered * c, f_m, options);
    for (Index j = 0; j < n; ++j) {
      if (c[j] != 0.0) {
        mask_slow(found.v, found.threshold(), found.travel, to_each_side,
                  out[static_cast<std::size_t>(j)].direction);
      }
    }
  }
  return out;
}

std::vector<Index> window_centres(const MotionMask& mask, Index first, Index count, Index n_d) {
  const auto moving = [&](Index k) { return mask.direction[static_cast<std::size_t>(first + k)] != 0; };
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
