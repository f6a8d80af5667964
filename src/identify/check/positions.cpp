#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "identify/check/checks.hpp"
#include "identify/rows/exact_rows.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/text.hpp"
#include "signal/window_decimator.hpp"

namespace rivid::detail {

namespace {

// Part of a motion that the position filter may take away, relative to the motion, and in deviations of the
// noise.
constexpr double lost_share = 0.01;
constexpr double lost_much = 0.05;
constexpr double lost_sigmas = 5.0;
// Noise of the accelerations relative to themselves.
constexpr double noisy = 0.7;

// What a low-pass does to positions.
struct Effect {
  double lost = 0.0;                // rms of what is taken away [rad | m]
  double acceleration_noise = 0.0;  // part of the rms acceleration that is noise of the encoder
};

// Σ_m h_m x[k + m] for each stride-th k that the window fits around.
Vector averaged(const Eigen::Ref<const Vector>& x, const Vector& window, Index stride) {
  Vector out((x.size() - window.size()) / stride + 1);
  for (Index k = 0; k < out.size(); ++k) {
    out[k] = window.dot(x.segment(k * stride, window.size()));
  }
  return out;
}

// Of each joint.
//
// n_d  of the window that a decimation averages accelerations by, 1 for none
std::vector<Effect> effects(const Log& log, double cutoff_hz, int order, Index n_d = 1) {
  std::vector<Effect> out(static_cast<std::size_t>(log.q.cols()));
  const Vector window = decimation_window(n_d);
  Matrix filtered = log.q;
  Index border = 2;
  Matrix impulse = Matrix::Zero(2 * window.size() + 9, 1);
  if (cutoff_hz > 0.0) {
    const Filter filter = butterworth(order, cutoff_hz, log.f_m);
    filtered = zero_phase(log.q, filter);
    const Index settling = std::min(settling_samples(filter), log.samples() / 4);
    border += settling;
    impulse = Matrix::Zero(impulse.rows() + 2 * (border + settling), 1);
    impulse(impulse.rows() / 2, 0) = 1.0;
    impulse = zero_phase(impulse, filter);
  } else {
    impulse(impulse.rows() / 2, 0) = 1.0;
  }
  const Index count = log.samples() - 2 * border;
  if (count < window.size()) {
    return out;
  }
  const double gain = averaged(differentiate(impulse, log.f_m).qdd.col(0), window, 1).norm();
  for (Index j = 0; j < log.q.cols(); ++j) {
    if (stands_still(log.q.col(j))) {
      continue;
    }
    const Matrix qdd = differentiate(filtered.col(j), log.f_m).qdd;
    const double acceleration = rms(averaged(qdd.col(0).segment(border, count), window, n_d));
    const double noise = gain * noise_level(log.q.col(j));
    out[static_cast<std::size_t>(j)] = {
        .lost = rms((log.q.col(j) - filtered.col(j)).segment(border, count)),
        .acceleration_noise = acceleration > 0.0 ? noise / acceleration : 0.0};
  }
  return out;
}

// Stride of the windows that average exact rows; the decimation of the others is left to its own filter.
Index window_stride(const SignalOptions& signal) {
  Index out = 1;
  for (const int n_d : signal.decimation) {
    out *= signal.exact_rows() ? n_d : 1;
  }
  return out;
}

constexpr double alike = Likeness::alike;
// Motions that are so many times their references are in other units: degrees, millimetres. Slow control and
// resonances make other factors.
constexpr std::array unit_factors = {1.0 / degree, degree, 1000.0, 1e-3};
constexpr double like_a_unit = 0.4;  // of log(factor / unit): from 1/1.5 to 1.5 times; a choice
// Search for delays of the motion behind its reference [s].
constexpr double longest_lead = 0.5;
constexpr double longest_delay = 5.0;
// of a log, evenly over it, up to twice as many; a choice that bounds the time of the search
constexpr Index compared_samples = 600;
// Correlation of a motion with the reference of another joint that shows them exchanged, and below which it
// has nothing to do with its own.
constexpr double much_alike = 0.95;
constexpr double unlike = 0.5;
// A motion below this part of its reference follows none.
constexpr double least_following = 0.05;

// The reference, and by how much the motion is behind it.
struct Following {
  double delay = 0.0;  // [s]
  Likeness at_delay;   // q = factor q_r
};

Following following(const Eigen::Ref<const Vector>& motion, const Eigen::Ref<const Vector>& reference,
                    double f_m) {
  const Index stride = std::max<Index>(1, motion.size() / compared_samples);
  const Index count = motion.size() / stride;
  const Eigen::Map<const Vector, 0, Eigen::InnerStride<>> q(motion.data(), count,
                                                            Eigen::InnerStride<>(stride));
  const Eigen::Map<const Vector, 0, Eigen::InnerStride<>> q_r(reference.data(), count,
                                                              Eigen::InnerStride<>(stride));
  const double step = static_cast<double>(stride) / f_m;
  const auto lead = std::min(static_cast<Index>(longest_lead / step), count / 4);
  const auto delay = std::min(static_cast<Index>(longest_delay / step), count / 4);
  constexpr double shortness = 2e-3;  // correlation that a second less is worth [1/s]
  Following best;
  Following opposite;
  double most = -2.0;
  for (Index d = -lead; d <= delay; ++d) {
    const Index overlap = count - std::abs(d);
    const Likeness found =
        likeness(q_r.segment(std::max<Index>(-d, 0), overlap), q.segment(std::max<Index>(d, 0), overlap));
    // Of the delays that a periodic motion allows, the shortest.
    const double merit = found.correlation - shortness * static_cast<double>(std::abs(d)) * step;
    if (merit > most) {
      most = merit;
      best = {static_cast<double>(d) * step, found};
    }
    if (-found.correlation > -opposite.at_delay.correlation) {
      opposite = {static_cast<double>(d) * step, found};
    }
  }
  return best.at_delay.correlation < alike && -opposite.at_delay.correlation > alike ? opposite : best;
}

}  // namespace

double suitable_cutoff(const Log& log) {
  // Filters that take no more away than noise, or a thousandth of the motion; with room for what
  // accelerations need.
  constexpr double first_hz = 0.2;  // [Hz] lowest cut-off that is tried; a choice
  constexpr double step = 1.4;      // from one cut-off to the next; a choice
  constexpr double small_part = 1e-3;
  constexpr double small_sigmas = 3.0;
  constexpr double room = 4.0;
  const double highest = 0.2 * log.f_m;
  Vector allowed(log.q.cols());
  for (Index j = 0; j < log.q.cols(); ++j) {
    allowed[j] = std::max(small_sigmas * noise_level(log.q.col(j)), small_part * rms(centred(log.q.col(j))));
  }
  const auto takes_too_much = [&](double cutoff_hz) {
    const std::vector<Effect> found = effects(log, cutoff_hz, 4);
    return std::ranges::mismatch(found, allowed, std::less_equal<>(), &Effect::lost).in1 != found.end();
  };
  double cutoff_hz = first_hz;
  while (cutoff_hz < highest && takes_too_much(cutoff_hz)) {
    cutoff_hz *= step;
  }
  return std::min(room * cutoff_hz, highest);
}

void check_cutoff(const Robot& robot, std::span<const Log> logs, const Log& log, const CheckOptions& options,
                  Findings& out) {
  const SignalOptions& signal = options.signal;
  if (signal.cutoff_hz >= 0.5 * log.f_m) {
    return;  // refused later, with a better message
  }
  if (window_stride(signal) > 1 && signal.cutoff_hz == 0.0) {
    return;  // what noise does to such rows is computed: noise_bias
  }
  const auto other_cutoff = [&]() -> std::vector<Change> {
    return {{.key = "signal.cutoff_hz", .numbers = {suitable_cutoff(log)}}};
  };
  const std::vector<Effect> all = effects(log, signal.cutoff_hz, signal.order, window_stride(signal));
  for (Index j = 0; j < robot.size(); ++j) {
    if (stands_still(log.q.col(j))) {
      continue;
    }
    const Effect& found = all[static_cast<std::size_t>(j)];
    const double share = found.lost / rms(centred(log.q.col(j)));
    if (share > lost_share && found.lost > lost_sigmas * noise_level(log.q.col(j))) {
      out.add(share > lost_much ? "cutoff_low" : "cutoff_lowish", place(robot, logs, log, j),
              "the filter at " + number(signal.cutoff_hz, 3) + " Hz takes " +
                  number(100.0 * std::min(share, 1.0), 2) + " % of the motion away; try " +
                  number(suitable_cutoff(log), 2) + " Hz",
              other_cutoff());
    }
    if (found.acceleration_noise > noisy) {
      out.add(options.instrumental ? "cutoff_high_iv" : "cutoff_high", place(robot, logs, log, j),
              (signal.cutoff_hz > 0.0 ? "at a cut-off of " + number(signal.cutoff_hz, 3) + " Hz "
                                      : std::string("without a filter ")) +
                  "noise makes " + number(100.0 * std::min(found.acceleration_noise, 1.0), 2) +
                  " % of the accelerations; try " + number(suitable_cutoff(log), 2) + " Hz",
              other_cutoff());
    }
  }
}

void check_reference(const Robot& robot, std::span<const Log> logs, const Log& log, bool used,
                     Findings& out) {
  if (log.q_r.cols() != robot.size() || log.q_r.rows() != log.q.rows()) {
    return;
  }
  bool leads = true;
  bool any_follows = false;
  std::vector<std::pair<Index, Following>> lost;
  std::string delays;
  for (Index j = 0; j < robot.size(); ++j) {
    if (stands_still(log.q.col(j)) || stands_still(log.q_r.col(j))) {
      continue;
    }
    const Following found = following(log.q.col(j), log.q_r.col(j), log.f_m);
    const double factor = found.at_delay.factor;
    leads = leads && found.delay < -2.0 / log.f_m;
    delays += (delays.empty() ? "" : ", ") + robot.joints[static_cast<std::size_t>(j)].name + " " +
              number(found.delay, 3) + " s";
    if (found.at_delay.correlation > alike) {
      any_follows = true;
      if (std::ranges::any_of(unit_factors,
                              [&](double unit) { return std::abs(std::log(factor / unit)) < like_a_unit; })) {
        out.add(used ? "reference_unit" : "reference_unlike", place(robot, logs, log, j),
                "the motion is " + number(factor, 3) + " times its reference");
      }
    } else if (range(log.q.col(j)) > least_following * range(log.q_r.col(j))) {
      lost.emplace_back(j, found);
    }
  }
  const bool of_another_log = !any_follows && std::ranges::any_of(lost, [](const auto& it) {
    return std::abs(it.second.at_delay.correlation) < unlike;
  });
  for (const auto& [j, found] : lost) {
    // Slow control and saturation make motions unlike their references; those of another log or joint are
    // another matter.
    std::string other;
    for (Index k = 0; k < robot.size(); ++k) {
      if (k != j && !stands_still(log.q_r.col(k)) &&
          following(log.q.col(j), log.q_r.col(k), log.f_m).at_delay.correlation > much_alike) {
        other = "; it follows that of " + robot.joints[static_cast<std::size_t>(k)].name;
      }
    }
    const double correlation = found.at_delay.correlation;
    if (!other.empty() || correlation < -much_alike || of_another_log) {
      out.add(used ? "reference_mismatch" : "reference_unlike", place(robot, logs, log, j),
              "correlation of motion and reference is " + number(correlation, 2) +
                  " at best, should be above " + number(alike) + other);
    }
  }
  if (delays.empty()) {
    return;
  }
  const std::string subject = logs.size() == 1 ? "all joints" : log.source;
  out.add(std::string_view(leads ? "reference_leads" : "reference_delay"), subject,
          "motion behind reference: " + delays);
}

}  // namespace rivid::detail
