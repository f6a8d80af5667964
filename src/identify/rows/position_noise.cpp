#include "identify/rows/position_noise.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "identify/rows/row_source.hpp"
#include "rivid/signal/filter.hpp"

namespace rivid::detail {

namespace {

constexpr double pi = std::numbers::pi;
// An octave with fewer means is ignored.
constexpr std::size_t fewest_means = 24;
// Power that rises by more than this factor from one octave to the next lower one is motion: that of the arm,
// or stiction and vibration, which is in the torques as well.
constexpr double clear_rise = 2.0;
// Frequencies of a band, evenly over the logarithm.
constexpr Index grid = 256;
constexpr double octaves = 14.0;

// Σ cos(m ω) over |m| < n.
double dirichlet(double omega, double n) {
  const double half = std::sin(0.5 * omega);
  return std::abs(half) < 1e-12 ? 2.0 * n - 1.0 : std::sin((n - 0.5) * omega) / half;
}

// Gain of the window of a decimation, see WindowDecimator.
double window_gain(double omega, double n_d) {
  const double shift = pi / n_d;
  return (dirichlet(omega, n_d) + 0.5 * (dirichlet(omega - shift, n_d) + dirichlet(omega + shift, n_d))) /
         (2.0 * n_d);
}

// Squared gain of one pass of a filter, which is the gain of both passes.
double zero_phase_gain(const Filter& filter, double omega) {
  const std::complex<double> z = std::polar(1.0, -omega);
  std::complex<double> gain = 1.0;
  for (const SecondOrderSection& s : filter.sections) {
    gain *= (s.b0 + z * (s.b1 + z * s.b2)) / (1.0 + z * (s.a1 + z * s.a2));
  }
  return std::norm(gain);
}

double second_difference(const std::vector<double>& x, std::size_t k) {
  return x[k + 1] - 2.0 * x[k] + x[k - 1];
}

double fourth_difference(const std::vector<double>& x, std::size_t k) {
  return second_difference(x, k + 1) - 2.0 * second_difference(x, k) + second_difference(x, k - 1);
}

// Mean squares of second and fourth differences.
struct DifferencePowers {
  double second = 0.0;
  double fourth = 0.0;
};

DifferencePowers difference_powers(const std::vector<double>& x) {
  DifferencePowers sum;
  double before = second_difference(x, 1);
  double here = second_difference(x, 2);
  for (std::size_t k = 2; k + 2 < x.size(); ++k) {
    const double after = second_difference(x, k + 1);
    const double fourth = after - 2.0 * here + before;
    sum.second += here * here;
    sum.fourth += fourth * fourth;
    before = here;
    here = after;
  }
  const auto count = static_cast<double>(x.size() - 4);
  return {sum.second / count, sum.fourth / count};
}

// Mean square of the fourth differences but for the largest, which are outliers; as if the noise were normal.
double quiet_mean_square(const std::vector<double>& x) {
  // differences; a choice: their mean square is known to 2 or 3 %, in little time
  constexpr std::size_t most = 8192;
  const std::size_t step = x.size() / most + 1;
  std::vector<double> squares;
  for (std::size_t k = 2; k + 2 < x.size(); k += step) {
    squares.push_back(std::pow(fourth_difference(x, k), 2));
  }
  const auto quiet = static_cast<std::ptrdiff_t>(std::ceil(quiet_part * static_cast<double>(squares.size())));
  std::ranges::nth_element(squares, squares.begin() + (quiet - 1));
  double sum = 0.0;
  for (std::ptrdiff_t k = 0; k < quiet; ++k) {
    sum += squares[static_cast<std::size_t>(k)];
  }
  return sum / (quiet_square * static_cast<double>(quiet));
}

// Part of the samples that equal the one before.
constexpr double many_repeats = 0.2;
double repeats(const Eigen::Ref<const Vector>& q) {
  const Index m = q.size() - 1;
  return static_cast<double>((q.tail(m).array() == q.head(m).array()).count()) /
         static_cast<double>(std::max<Index>(m, 1));
}

}  // namespace

// Half the sampling rate and `octaves` below it.
RowBand::RowBand(double f_m) : frequencies(grid), velocity(grid), acceleration(grid) {
  const double step = octaves / static_cast<double>(grid);
  for (Index i = 0; i < grid; ++i) {
    const double f = 0.5 * f_m * std::exp2(-step * (static_cast<double>(i) + 0.5));
    const double width = f * std::numbers::ln2 * step;
    const double omega = 2.0 * pi * f / f_m;
    const double difference = std::sin(omega) * f_m;  // over x, of a central difference
    frequencies[i] = f;
    velocity[i] = difference * difference * 2.0 * width / f_m;
    acceleration[i] = difference * difference * velocity[i];
  }
}

RowBand::RowBand(const SignalOptions& signal, double f_m) : RowBand(f_m) {
  const auto n_d = static_cast<double>(stride_of(signal));
  const Filter filter = signal.cutoff_hz > 0.0 ? butterworth(signal.order, signal.cutoff_hz, f_m) : Filter{};
  for (Index i = 0; i < grid; ++i) {
    const double omega = 2.0 * pi * frequencies[i] / f_m;
    double gain = zero_phase_gain(filter, omega);
    double averaged = 1.0;
    if (signal.exact_rows()) {
      gain *= window_gain(omega, n_d);
      averaged = (4.0 + 2.0 * std::cos(omega)) / 6.0;
    } else if (frequencies[i] > 0.4 * f_m / n_d) {
      gain = 0.0;
    }
    velocity[i] *= gain * gain * averaged * averaged;
    acceleration[i] *= gain * gain;
  }
}

RowBand::RowBand(const Filter& filter, double f_m) : RowBand(f_m) {
  for (Index i = 0; i < grid; ++i) {
    const double gain = zero_phase_gain(filter, 2.0 * pi * frequencies[i] / f_m);
    velocity[i] *= gain * gain;
    acceleration[i] *= gain * gain;
  }
}

PositionNoise::PositionNoise(const Eigen::Ref<const Vector>& q, double f_m) : f_m_(f_m) {
  std::vector<double> means(q.begin(), q.end());
  std::vector<double> accelerations;
  std::vector<double> quiet;
  double samples = 1.0;  // of a mean
  while (means.size() >= fewest_means) {
    const DifferencePowers powers = difference_powers(means);
    levels_.push_back(samples * powers.fourth / fourth_difference_power);
    quiet.push_back(samples * quiet_mean_square(means) / fourth_difference_power);
    const double rate = f_m / samples;
    accelerations.push_back(powers.second * rate * rate * rate * rate);
    for (std::size_t k = 0; k + 1 < means.size(); k += 2) {
      means[k / 2] = 0.5 * (means[k] + means[k + 1]);
    }
    means.resize(means.size() / 2);
    samples *= 2.0;
  }
  if (levels_.empty()) {
    return;
  }
  std::size_t lowest = 0;
  const auto density = [&](std::size_t k) { return levels_[k] * std::exp2(-4.0 * static_cast<double>(k)); };
  for (std::size_t k = 1; k < levels_.size() && density(k) < clear_rise * density(lowest); ++k) {
    if (density(k) < density(lowest)) {
      lowest = k;
    }
  }
  valley_ = 0.25 * f_m * std::exp2(-static_cast<double>(lowest));
  // A position that stands still between the steps of its encoder hides its noise from differences of
  // neighbours.
  const auto seen = repeats(q) > many_repeats ? static_cast<std::ptrdiff_t>(lowest) + 1 : 1;
  deviation_ = std::sqrt(*std::max_element(quiet.begin(), quiet.begin() + seen));
  motion_ = accelerations[std::min(lowest + 1, accelerations.size() - 1)];
  motions_ = levels_;
  std::fill(motions_.begin(), motions_.begin() + static_cast<std::ptrdiff_t>(lowest) + 1, 0.0);
  std::fill(levels_.begin() + static_cast<std::ptrdiff_t>(lowest), levels_.end(), levels_[lowest]);
}

std::size_t PositionNoise::octave(double frequency) const {
  return std::min(static_cast<std::size_t>(std::floor(std::log2(0.5 * f_m_ / frequency))),
                  levels_.size() - 1);
}

double PositionNoise::level(double frequency) const { return levels_[octave(frequency)]; }

double PositionNoise::motion_in(const RowBand& band) const {
  double out = 0.0;
  for (Index i = 0; i < band.frequencies.size() && !motions_.empty(); ++i) {
    out += motions_[octave(band.frequencies[i])] * band.acceleration[i];
  }
  return out;
}

DerivativeNoise PositionNoise::in(const RowBand& band) const {
  DerivativeNoise out;
  if (levels_.empty()) {
    return out;
  }
  for (Index i = 0; i < band.frequencies.size(); ++i) {
    const double noise = level(band.frequencies[i]);
    out.velocity += noise * band.velocity[i];
    out.acceleration += noise * band.acceleration[i];
  }
  return out;
}

}  // namespace rivid::detail
