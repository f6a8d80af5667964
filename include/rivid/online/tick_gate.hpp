#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <tuple>

#include "rivid/error.hpp"
#include "rivid/online/plausible.hpp"
#include "rivid/text.hpp"
#include "rivid/types.hpp"

namespace rivid {

struct TickGateOptions {
  double f_m = 1000.0;  ///< ticks a second [Hz]
  /// Acceleration that no joint can have for one tick and its opposite for the next [rad/s² | m/s²]: a tick
  /// that asks for more, and for more than eight times what the noise of the positions does, is a glitch.
  /// Positions that stay away after such a jump begin anew.
  double largest_acceleration = 100.0;
  Index filled = 2;          ///< ticks lost one after the other that are filled in; more are a gap
  double smoothing = 0.003;  ///< time constant of the velocities [s]

  [[nodiscard]] std::optional<std::string> complaint() const {
    if (!std::isfinite(f_m) || f_m <= 0.0) {
      return "f_m is " + number(f_m) + " Hz, must be positive";
    }
    if (!(largest_acceleration > 0.0) || filled < 0 || !(smoothing >= 0.0)) {
      return "largest_acceleration is " + number(largest_acceleration) + ", filled " +
             std::to_string(filled) + " and smoothing " + number(smoothing) +
             " s, must be positive, not negative, and not negative";
    }
    return std::nullopt;
  }
};

/// What was wrong with a tick.
struct TickQuality {
  Index lost = 0;    ///< ticks before it that did not come, or were not taken
  bool gap = false;  ///< they were too many to be filled in, or positions have jumped: everything begins anew
  bool not_finite = false;  ///< it has no number, or one that no robot has, and counts as lost
  bool repeated = false;  ///< it is the one before once more, or its positions are though the robot moves; it
                          ///< counts as lost
  bool late = false;      ///< its time is that of no tick, or it comes behind a later one; it counts as lost
  bool glitch = false;    ///< the tick before it was a glitch, and was replaced

  [[nodiscard]] bool good() const noexcept {
    return lost == 0 && !gap && !not_finite && !repeated && !late && !glitch;
  }
};

/// Ticks of a control loop as they come, made the even ones that estimators take. Each comes out one tick
/// later, when the next one says whether it was a glitch; ticks that are lost are interpolated.
///
/// What a size of noise is, is learned: quantised positions and time stamps that jitter are no glitches.
///
/// After the constructor no member allocates, throws or locks.
template <typename Scalar>
class TickGate {
 public:
  using Values = Eigen::Ref<const Eigen::VectorX<Scalar>>;
  using Result = Eigen::VectorX<Scalar>;

  /// Ticks of each kind so far.
  struct Counts {
    Index taken = 0, lost = 0, gaps = 0, not_finite = 0, repeated = 0, late = 0, glitches = 0;
  };

  /// @throws InputError  where an option can not be used
  TickGate(Index joints, const TickGateOptions& options)
      : options_(options),
        part_(static_cast<Scalar>(
            options.smoothing > 0.0 ? -std::expm1(-1.0 / (options.smoothing * options.f_m)) : 1.0)) {
    if (const auto fault = options.complaint()) {
      throw InputError("TickGate: " + *fault);
    }
    for (Result* const x : {&before_.q, &before_.tau, &now_.q, &now_.tau, &between_.q, &between_.tau,
                            &next_.q, &next_.tau, &older_q_, &qd_, &usual_q_, &usual_tau_}) {
      *x = Result::Zero(joints);
    }
  }

  /// Takes a tick, and calls take(q, qd, tau, anew) for those that have become known: none, one, or several
  /// where some were lost. `anew`: they do not go on from those before.
  ///
  /// @param t    when it was measured [s]
  /// @param q    positions, (n) [rad | m]
  /// @param tau  torques, joint side, (n) [N·m | N]
  template <typename Take>
  TickQuality update(double t, const Values& q, const Values& tau, const Take& take) noexcept;

  [[nodiscard]] const Counts& counts() const noexcept { return counts_; }

  [[nodiscard]] auto state() noexcept {
    return std::tie(older_q_, before_.q, before_.tau, now_.q, now_.tau, qd_, usual_q_, usual_tau_, clock_,
                    counts_);
  }

 private:
  struct Tick {
    Result q, tau;
  };
  struct Clock {
    double t = 0.0;       // of the newest tick, on an even grid
    double jitter = 0.0;  // mean distance of time stamps from the grid, in ticks
    Index known = 0;      // ticks since the begin, at most as many as matter
    Index steps = 1;      // from the tick before to the newest, and to the one before from that before it
    Index older_steps = 1;
    Index learned = 0;  // ticks that the usual sizes are known by
  };
  static constexpr double largest_position = 1e6;  // [rad | m] squares of what lies far beyond overflow
  static constexpr double largest_torque = 1e9;    // [N·m | N] the same
  static constexpr double late_part = 0.25;        // of a tick, beside …
  static constexpr double jitters = 3.0;           // … the usual distance
  static constexpr double follow = 0.02;           // part by which grid and jitter follow
  static constexpr double learn = 0.01;            // part by which usual sizes of noise do
  static constexpr double usual_positions = 8.0;   // usual sizes of noise that make a glitch; a choice
  static constexpr double usual_torques = 12.0;    // the same; a choice: torques are rougher
  static constexpr double moving_sizes = 4.0;      // of the noise, in a tick
  static constexpr double jump = 4.0;  // limits of a glitch by which positions that have jumped are away
  static constexpr Index enough = 50;  // ticks after which usual sizes are known

  void begin(double t, const Values& q, const Values& tau) noexcept {
    clock_ = {.t = t, .jitter = clock_.jitter, .known = 1, .learned = clock_.learned};
    now_.q = q;
    now_.tau = tau;
    qd_.setZero();
  }
  // Whether the positions move on by more than their noise.
  [[nodiscard]] bool moving() const noexcept {
    bool out = false;
    for (Index j = 0; j < now_.q.size(); ++j) {
      out = out || std::abs(qd_[j]) >
                       static_cast<Scalar>(moving_sizes * options_.f_m) * std::max(usual_q_[j], Scalar(1e-9));
    }
    return out;
  }
  template <typename Take>
  void push(const Tick& next, Index steps, const Take& take, TickQuality& quality) noexcept;
  struct Limits {
    Scalar least;
    double sizes;  // usual ones
    bool known;    // whether these are
  };
  static bool replaced(Scalar& x, const Scalar& line, const Scalar& expected, Scalar& usual,
                       const Limits& limits) noexcept;

  TickGateOptions options_;
  Scalar part_;  // of the smoothing
  Tick before_, now_, between_, next_;
  Result older_q_, qd_, usual_q_, usual_tau_;
  Clock clock_;
  Counts counts_;
};

template <typename Scalar>
template <typename Take>
TickQuality TickGate<Scalar>::update(double t, const Values& q, const Values& tau,
                                     const Take& take) noexcept {
  TickQuality out;
  const auto dropped = [&](bool& as, Index& count) {
    as = true;
    ++count;
    return out;
  };
  if (q.size() != now_.q.size() || tau.size() != q.size() || !std::isfinite(t) ||
      !detail::plausible(q, largest_position) || !detail::plausible(tau, largest_torque)) {
    return dropped(out.not_finite, counts_.not_finite);
  }
  if (clock_.known == 0) {
    begin(t, q, tau);
    return out;
  }
  const double steps = (t - clock_.t) * options_.f_m;
  const double whole = std::round(steps);
  if (std::abs(whole) > static_cast<double>(options_.filled) + 1.0) {
    out.gap = true;
    out.lost = static_cast<Index>(std::clamp(whole - 1.0, 0.0, 1e15));
    ++counts_.gaps;
    counts_.lost += out.lost;
    begin(t, q, tau);
    return out;
  }
  if (whole < 1.0) {
    return whole == 0.0 ? dropped(out.repeated, counts_.repeated) : dropped(out.late, counts_.late);
  }
  if (q == now_.q && moving()) {
    return dropped(out.repeated, counts_.repeated);
  }
  const double off = steps - whole;
  const bool late = std::abs(off) > late_part + jitters * clock_.jitter;
  clock_.jitter += follow * (std::abs(off) - clock_.jitter);
  if (late) {
    return dropped(out.late, counts_.late);
  }
  clock_.t += (whole + follow * off) / options_.f_m;
  out.lost = static_cast<Index>(whole) - 1;
  counts_.lost += out.lost;
  next_.q = q;
  next_.tau = tau;
  push(next_, static_cast<Index>(whole), take, out);
  if (out.gap) {
    ++counts_.gaps;
    begin(clock_.t, q, tau);
    return out;
  }
  ++counts_.taken;
  counts_.glitches += out.glitch ? 1 : 0;
  return out;
}

// The tick at hand goes out, behind those that were lost before it, once its neighbours have said whether it
// was a glitch: nothing is filled in from one.
//
// steps  from it to the next one
template <typename Scalar>
template <typename Take>
void TickGate<Scalar>::push(const Tick& next, Index steps, const Take& take, TickQuality& quality) noexcept {
  if (clock_.known > 1) {
    const auto before = static_cast<Scalar>(clock_.steps);
    const auto after = static_cast<Scalar>(steps);
    const Scalar share = before / (before + after);
    const bool sizes_known = clock_.learned >= enough && clock_.known > 2;
    const auto least =
        static_cast<Scalar>(options_.largest_acceleration / (options_.f_m * options_.f_m)) * before * after;
    const Scalar on = before / static_cast<Scalar>(std::max<Index>(clock_.older_steps, 1));
    const auto limit_of = [&](Index j) { return least + static_cast<Scalar>(usual_positions) * usual_q_[j]; };
    for (Index j = 0; j < next.q.size(); ++j) {
      // What it should be: a position goes on as before, a torque is like one of its neighbours.
      const Scalar q = before_.q[j] + on * (before_.q[j] - older_q_[j]);
      const bool later = std::abs(now_.tau[j] - next.tau[j]) < std::abs(now_.tau[j] - before_.tau[j]);
      const Scalar tau = later ? next.tau[j] : before_.tau[j];
      const bool of_q = replaced(now_.q[j], before_.q[j] + share * (next.q[j] - before_.q[j]), q, usual_q_[j],
                                 {least, usual_positions, sizes_known});
      const bool of_tau = replaced(now_.tau[j], before_.tau[j] + share * (next.tau[j] - before_.tau[j]), tau,
                                   usual_tau_[j], {Scalar(0), usual_torques, sizes_known});
      quality.glitch = quality.glitch || of_q || of_tau;
      const Scalar away = next.q[j] - q - (q - before_.q[j]) * after / before;
      quality.gap = quality.gap || (of_q && std::abs(away) > static_cast<Scalar>(jump) * limit_of(j));
    }
    if (quality.gap) {
      quality.glitch = false;
      return;
    }
    clock_.learned = std::min(clock_.learned + 1, enough);
    bool first = clock_.known == 2;
    const auto out = [&](const Tick& tick, const Tick& from, const Tick& to, const Scalar& ticks) {
      const Scalar part = first ? Scalar(1) : part_;
      for (Index j = 0; j < qd_.size(); ++j) {
        qd_[j] += part * ((to.q[j] - from.q[j]) * static_cast<Scalar>(options_.f_m) / ticks - qd_[j]);
      }
      take(tick.q, qd_, tick.tau, first);
      first = false;
    };
    for (Index i = 1; i < clock_.steps; ++i) {
      const Scalar way = static_cast<Scalar>(i) / before;
      between_.q = before_.q + way * (now_.q - before_.q);
      between_.tau = before_.tau + way * (now_.tau - before_.tau);
      out(between_, before_, now_, before);
    }
    // Whether the next one is a glitch is not known yet: it is no velocity.
    for (Index j = 0; j < next.q.size(); ++j) {
      const Scalar ahead = now_.q[j] + (now_.q[j] - before_.q[j]) * after / before;
      between_.q[j] =
          sizes_known ? std::clamp(next.q[j], ahead - limit_of(j), ahead + limit_of(j)) : next.q[j];
    }
    out(now_, before_, between_, before + after);
  }
  clock_.known = std::min<Index>(clock_.known + 1, 3);
  clock_.older_steps = clock_.steps;
  clock_.steps = steps;
  older_q_ = before_.q;
  before_ = now_;
  now_ = next;
}

// Whether a value lies off the line between its neighbours, and off what it should be on the same side, by
// more than there is reason for: it takes its place on the line. A real kink or step has neighbours on one of
// its sides, and an acceleration that lasts bends the line to the other one.
template <typename Scalar>
bool TickGate<Scalar>::replaced(Scalar& x, const Scalar& line, const Scalar& expected, Scalar& usual,
                                const Limits& limits) noexcept {
  using std::abs;
  const Scalar size = Scalar(2) * abs(x - line);
  const Scalar limit = limits.least + static_cast<Scalar>(limits.sizes) * usual;
  const bool out =
      limits.known && size > limit && abs(x - expected) > Scalar(0.5) * limit && (x > line) == (x > expected);
  usual += static_cast<Scalar>(limits.known ? learn : 1.0 / static_cast<double>(enough)) *
           ((limits.known ? std::min(size, limit) : size) - usual);
  x = out ? line : x;
  return out;
}

}  // namespace rivid
