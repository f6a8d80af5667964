// Findings about a log by itself, joint by joint, without a model of the robot.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "identify/check/checks.hpp"
#include "identify/rows/exact_rows.hpp"
#include "identify/rows/position_noise.hpp"
#include "ranges.hpp"
#include "rivid/identify/rows.hpp"
#include "rivid/signal/filter.hpp"
#include "rivid/text.hpp"

namespace rivid::detail {

namespace {

// A joint stands still where its positions stay within so many deviations of their noise, or within this
// range.
constexpr double still_sigmas = 12.0;
constexpr double still_range = 1e-3;  // [rad | m]
// No encoder has so much noise [rad | m].
constexpr double surely_moves = 0.1;

// A sample counts as standstill below this part of the joint's largest velocity.
constexpr double slow = 0.01;
constexpr double notable_standstill = 0.3;  // of the samples; a choice: pauses of usual motions stay below
// Positions may leave the limits of the URDF by this part of their span.
constexpr double beyond_limits = 0.1;
// No other zero or robot takes positions so many times as far as the limits.
constexpr double far_beyond_limits = 10.0;
// Without limits: a joint that turns more often than this is in degrees, and a slide is not longer than that.
constexpr double most_turns = 8.0 * 2.0 * std::numbers::pi;
// [m] a choice: millimetres read as metres make a slide of 20 mm this long
constexpr double longest_slide = 20.0;
// Largest motion of any joint that makes degrees out of radians likely [rad].
constexpr double smallest_motion = 0.12;
// times the limit, as an rms; a choice: drives exceed their limits a little, wrong units by 57 and more
constexpr double beyond_velocity = 3.0;
// times the limit, as an rms; a choice: torques stay below 1, thousandths of a unit exceed it by far
constexpr double beyond_effort = 5.0;
// Part of the samples at one extreme value, in runs of at least so many, that is saturation.
constexpr double saturated_share = 0.005;
constexpr Index saturated_run = 3;
// Of the part of the samples at the value next to it.
constexpr double saturated_factor = 6.0;
// Velocities are differences over so long a time [s].
constexpr double velocity_span = 0.02;
// A recorded velocity this much larger or smaller than the differences of the positions is another one.
constexpr double same_scale = 1.25;

// Least distance between two different values in a row: the quantum of an encoder, if there is one.
double quantum(const Eigen::Ref<const Vector>& x) {
  double least = 0.0;
  for (Index k = 1; k < x.size(); ++k) {
    const double step = std::abs(x[k] - x[k - 1]);
    if (step > 0.0 && (least == 0.0 || step < least)) {
      least = step;
    }
  }
  return least;
}

// What of a column would bring a joint within its limits: the other sign, or another zero.
std::string cures_of_limits(const Joint& joint, double lowest, double highest) {
  const auto within = [&](double low, double high) { return low >= joint.lower && high <= joint.upper; };
  std::string out = within(-highest, -lowest) ? "; within them with the other sign" : "";
  if (joint.type == JointType::revolute) {
    for (const double turns : {1.0, -1.0, 2.0, -2.0}) {
      const double offset = 0.5 * std::numbers::pi * turns;
      if (within(lowest + offset, highest + offset)) {
        return out + (out.empty() ? "; within them with" : ", or with") + " offset = " + number(offset, 6) +
               " in [log] position";
      }
    }
  }
  return out;
}

void check_limits(const Robot& robot, std::span<const Log> logs, const Log& log, Index j, Findings& out) {
  const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
  const bool turns = joint.type == JointType::revolute;
  const double unit = turns ? degree : 1e-3;
  const std::string symbol = turns ? " rad" : " m";
  const double lowest = log.q.col(j).minCoeff();
  const double highest = log.q.col(j).maxCoeff();
  const std::string extent = "from " + number(lowest, 3) + " to " + number(highest, 3) + symbol;
  const std::string subject = place(robot, logs, log, j);
  if (!std::isfinite(joint.lower) || !std::isfinite(joint.upper) || joint.upper <= joint.lower) {
    if (highest - lowest > (turns ? most_turns : longest_slide)) {
      out.add("position_unit", subject,
              extent + (turns ? ", as degrees would be" : ", as millimetres would be"));
    }
    return;
  }
  const double span = joint.upper - joint.lower;
  const auto outside = [&](double scale) {
    return std::max({0.0, joint.lower - scale * lowest, scale * highest - joint.upper}) / span;
  };
  const std::string limits =
      extent + ", limits of the joint are " + number(joint.lower, 3) + " and " + number(joint.upper, 3);
  // In half spans from the middle.
  const double reach =
      std::max(highest - 0.5 * (joint.lower + joint.upper), 0.5 * (joint.lower + joint.upper) - lowest) /
      (0.5 * span);
  if (outside(1.0) > 1.0 && outside(unit) <= beyond_limits) {
    out.add("position_unit", subject,
            limits + (turns ? ", as degrees would be" : ", as millimetres would be"),
            {{"log.position.scale", joint.name, {unit}}});
  } else if (reach > far_beyond_limits) {
    out.add("position_unit", subject, limits + ": more than ten times as far");
  } else if (outside(1.0) > beyond_limits) {
    out.add("position_limits", subject, limits + cures_of_limits(joint, lowest, highest));
  }
}

// A column whose values are those of a register of 16 bits, over the whole of it, and which jumps from end to
// end: it has gone over its end.
void add_wrap(const Eigen::Ref<const Vector>& x, const std::string& what, const std::string& subject,
              Findings& out) {
  constexpr double values = 65536.0;  // 2^16, of a register of 16 bits
  constexpr double nearly_all = 0.9;  // of the register; a choice: motions seldom reach both ends exactly
  const double extent = range(x);
  const double step = extent > 0.0 ? quantum(x) : 0.0;
  if (!(step > 0.0) || extent > values * step || extent < nearly_all * values * step) {
    return;
  }
  Index jumps = 0;
  for (Index k = 1; k < x.size(); ++k) {
    jumps += std::abs(x[k] - x[k - 1]) > nearly_all * values * step ? 1 : 0;
  }
  if (jumps > 0) {
    out.add(
        "register_wraps", subject,
        what + " jumps by " + number(values * step, 4) + ", 65536 of its steps, " + counted(jumps, "time"));
  }
}

void check_columns(const Robot& robot, std::span<const Log> logs, const Log& log, Findings& out) {
  const auto duplicates = [&](const Matrix& x, const char* what) {
    for (Index j = 0; j < x.cols(); ++j) {
      for (Index i = 0; i < j; ++i) {
        if (range(x.col(j)) > 0.0 && x.col(i) == x.col(j)) {
          out.add("duplicate_column", place(robot, logs, log, j),
                  std::string(what) + " equals that of " + robot.joints[static_cast<std::size_t>(i)].name);
        }
      }
    }
  };
  duplicates(log.q, "position");
  for (Index j = 0; log.q_r.cols() == log.q.cols() && j < log.q.cols(); ++j) {
    if (range(log.q.col(j)) > 0.0 && log.q.col(j) == log.q_r.col(j)) {
      out.add("duplicate_column", place(robot, logs, log, j),
              "position equals its reference to the last digit");
    }
  }
  for (Index j = 0; j < log.q.cols(); ++j) {
    add_wrap(log.q.col(j), "position", place(robot, logs, log, j), out);
  }
  duplicates(log.tau, "torque");
  duplicates(log.v_tau, "control signal");
}

// Samples that stand at a value, one after the other.
Index clipped(const Eigen::Ref<const Vector>& x, double value) {
  Index count = 0;
  for (Index begin = 0; begin < x.size();) {
    Index end = begin;
    while (end < x.size() && x[end] == value) {
      ++end;
    }
    count += end - begin >= saturated_run ? end - begin : 0;
    begin = std::max(end, begin + 1);
  }
  return count;
}

// The value next to an extreme one.
double next_to(const Eigen::Ref<const Vector>& x, double extreme) {
  double out = std::numeric_limits<double>::quiet_NaN();
  for (const double value : x) {
    if (value != extreme && !(std::abs(value - extreme) >= std::abs(out - extreme))) {
      out = value;
    }
  }
  return out;
}

void check_torque_values(const Robot& robot, std::span<const Log> logs, const Log& log, Findings& out) {
  const bool torques = log.tau.size() > 0;
  const Matrix& x = torques ? log.tau : log.v_tau;
  // A base that floats needs no torques: these are not measured.
  if (x.cols() != robot.size() ||
      (robot.base_joints > 0 && x.rightCols(x.cols() - robot.base_joints).isZero(0.0))) {
    return;
  }
  const Matrix tau = effort(robot, log);
  for (Index j = robot.base_joints; j < x.cols(); ++j) {
    const std::string subject = place(robot, logs, log, j);
    const std::string what = torques ? "torque" : "control signal";
    if (range(x.col(j)) == 0.0) {
      out.add("dead_torque", subject, what + " is " + number(x(0, j), 4) + " throughout");
      continue;
    }
    add_wrap(x.col(j), what, subject, out);
    const bool moves = !stands_still(log.q.col(j));
    for (const double extreme : {x.col(j).minCoeff(), x.col(j).maxCoeff()}) {
      const double share = static_cast<double>(clipped(x.col(j), extreme)) / static_cast<double>(x.rows());
      // A coarse signal stands at all of its values for a while, at its extremes a little longer.
      const auto beside =
          static_cast<double>(clipped(x.col(j), next_to(x.col(j), extreme))) / static_cast<double>(x.rows());
      if (moves && share > saturated_share && share > saturated_factor * beside) {
        out.add("torque_saturated", subject,
                what + " stays at " + number(extreme, 4) + " for " + number(100.0 * share, 2) +
                    " % of the samples");
      }
    }
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    if (std::isfinite(joint.max_effort) && joint.max_effort > 0.0) {
      const double typical = rms(tau.col(j));
      if (typical > beyond_effort * joint.max_effort) {
        out.add("torque_unit", subject,
                "torque is " + number(typical, 3) + (joint.type == JointType::revolute ? " N·m" : " N") +
                    " on average, the URDF allows " + number(joint.max_effort, 3));
      }
    }
  }
}

// (n_m × n), the ends held.
Matrix velocities(const Log& log) {
  const Index last = log.samples() - 1;
  const Index half =
      std::clamp<Index>(std::lround(0.5 * velocity_span * log.f_m), 1, std::max<Index>(last / 2, 1));
  Matrix out(log.samples(), log.q.cols());
  for (Index k = 0; k <= last; ++k) {
    const Index before = std::max<Index>(k - half, 0);
    const Index after = std::min(k + half, last);
    out.row(k) = (log.q.row(after) - log.q.row(before)) *
                 (log.f_m / static_cast<double>(std::max<Index>(after - before, 1)));
  }
  return out;
}

void check_velocities(const Robot& robot, std::span<const Log> logs, const Log& log, const Matrix& qd,
                      Findings& out) {
  std::vector<double> factors;
  std::vector<std::pair<Index, Likeness>> compared;
  for (Index j = 0; j < robot.size(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    if (stands_still(log.q.col(j))) {
      continue;
    }
    const double fast = rms(qd.col(j));
    if (std::isfinite(joint.max_velocity) && joint.max_velocity > 0.0 &&
        fast > beyond_velocity * joint.max_velocity &&
        !out.has("position_unit", place(robot, logs, log, j))) {
      out.add("velocity_limit", place(robot, logs, log, j),
              number(fast, 3) + (joint.type == JointType::revolute ? " rad/s" : " m/s") +
                  " on average, the URDF allows " + number(joint.max_velocity, 3));
    }
    if (log.qd.cols() == robot.size()) {
      const Likeness found = likeness(qd.col(j), log.qd.col(j));
      compared.emplace_back(j, found);
      factors.push_back(found.factor);
    }
  }
  if (compared.empty()) {
    return;
  }
  const auto off = [](double f) { return f > same_scale || f < 1.0 / same_scale; };
  const double first = factors.front();
  const bool together = std::ranges::all_of(compared, [&](const auto& c) {
    return c.second.correlation > Likeness::alike && !off(c.second.factor / first);
  });
  if (together && off(first) && !out.has("position_unit")) {
    out.add("time_scale", logs.size() == 1 ? "all joints" : log.source,
            "recorded velocities are " + number(first, 3) +
                " times the differences of the positions: the rate is " + number(log.f_m) +
                " Hz here, and would be " + number(log.f_m * first, 4) + " Hz, if no unit is wrong");
    return;
  }
  for (const auto& [j, found] : compared) {
    if (found.correlation < Likeness::alike || off(found.factor)) {
      out.add("velocity_mismatch", place(robot, logs, log, j),
              "recorded velocity is " + number(found.factor, 3) +
                  " times the derivative of the position, correlation " + number(found.correlation, 2));
    }
  }
}

void check_standstill(const Robot& robot, std::span<const Log> logs, const Log& log, const Matrix& qd,
                      Findings& out) {
  for (Index j = 0; j < robot.size(); ++j) {
    const Vector speed = qd.col(j).cwiseAbs();
    const double share = static_cast<double>((speed.array() < slow * speed.maxCoeff()).count()) /
                         static_cast<double>(speed.size());
    if (share > notable_standstill && !stands_still(log.q.col(j))) {
      out.add("standstill", place(robot, logs, log, j),
              "stands still for " + number(100.0 * share, 2) + " % of the samples");
    }
  }
}

// Errors of the instants, which all joints share in proportion to their velocities, against errors of
// positions, which they do not. By fourth differences, that hold little of a motion.
void check_clock(const Log& log, const Matrix& qd, std::string subject, Findings& out) {
  // Part of the joints' noise that is common, over that of independent errors: 1 for none, n for all.
  constexpr double common = 1.5;
  // Neighbouring fourth differences of white errors correlate by -0.8, those of motions by nearly 1.
  constexpr double rough = -0.4;
  constexpr double least_jitter = 0.01;  // rms [periods]; a choice: less is not worth a word
  // of 3, the largest fourth difference of a lost period: half-way between none and one
  constexpr double lost_part = 0.5;
  const Index n = log.q.cols();
  const Index m = log.samples() - 4;
  const std::vector<Index> moving = places_where(n, [&](Index j) { return !stands_still(log.q.col(j)); });
  if (moving.size() < 2 || m < 100) {
    return;
  }
  Vector along = Vector::Zero(m);    // Σ w q̇ Δ⁴q
  Vector weights = Vector::Zero(m);  // Σ w q̇²
  for (const Index j : moving) {
    const auto x = log.q.col(j);
    const Vector fourth =
        x.head(m) - 4.0 * x.segment(1, m) + 6.0 * x.segment(2, m) - 4.0 * x.segment(3, m) + x.tail(m);
    const double variance = fourth.squaredNorm() / static_cast<double>(m);
    if (variance > 0.0) {
      const auto v = qd.col(j).segment(2, m);
      along += v.cwiseProduct(fourth) / variance;
      weights += v.cwiseAbs2() / variance;
    }
  }
  const Vector found = along.array() / weights.array().max(1e-300).sqrt();
  const double share = found.squaredNorm() / static_cast<double>(m);
  const double neighbours = found.head(m - 1).dot(found.tail(m - 1)) / found.squaredNorm();
  if (!(share > common) || !(neighbours < rough)) {
    return;
  }
  // Fourth differences of the errors of the instants, in periods, where the robot moves fast enough to see
  // them.
  const double fast = weights.mean();
  double squares = 0.0;
  double count = 0.0;
  Index lost = 0;
  Index quiet_until = 0;
  for (Index k = 0; k < m; ++k) {
    if (weights[k] < fast) {
      continue;
    }
    const double error = along[k] / weights[k] * log.f_m;
    squares += error * error;
    count += 1.0;
    // A step by one period has fourth differences of one and three.
    if (std::abs(error) > lost_part * 3.0 && k >= quiet_until) {
      ++lost;
      quiet_until = k + 5;
    }
  }
  const double jitter = std::sqrt(squares / std::max(count, 1.0) / fourth_difference_power);
  if (jitter < least_jitter) {
    return;
  }
  const std::string seen =
      lost > 0 && jitter < 0.2
          ? "; at " + counted(lost, "instant") + " or more it steps by a period, as where samples are lost"
          : "";
  out.add(
      "clock_jitter", std::move(subject),
      "the instants of the samples are off by " + number(100.0 * jitter, 2) + " % of a period (rms)" + seen);
}

// Small motions everywhere: radians that were taken for degrees.
void check_smallness(const Robot& robot, std::span<const Log> logs, Findings& out) {
  double most = 0.0;
  for (Index j = 0; j < robot.size(); ++j) {
    if (robot.joints[static_cast<std::size_t>(j)].type == JointType::revolute) {
      for (const Log& log : logs) {
        most = std::max(most, range(log.q.col(j)));
      }
    }
  }
  if (most > 0.0 && most < smallest_motion) {
    out.add("small_motion", "all joints",
            "no joint turns by more than " + number(most, 2) + " rad, as radians taken for degrees would");
  }
}

// Joints that move in no log; whether any moves at all.
bool check_motion(const Robot& robot, std::span<const Log> logs, Findings& out) {
  std::vector<Index> still;
  for (Index j = 0; j < robot.size(); ++j) {
    if (std::ranges::all_of(logs, [&](const Log& log) { return stands_still(log.q.col(j)); })) {
      still.push_back(j);
    }
  }
  const auto widest = [&](Index j) {
    double most = 0.0;
    for (const Log& log : logs) {
      most = std::max(most, range(log.q.col(j)));
    }
    return "positions stay within " + number(most, 2) +
           (robot.joints[static_cast<std::size_t>(j)].type == JointType::revolute ? " rad" : " m");
  };
  if (static_cast<Index>(still.size()) == robot.size()) {
    out.add("at_rest", "all joints", widest(0));
    return false;
  }
  for (const Index j : still) {
    out.add("joint_still", robot.joints[static_cast<std::size_t>(j)].name, widest(j));
  }
  return true;
}

// Rates that no dynamics can be seen at, or that nothing is logged at: time in another unit.
void check_rate(const Log& log, std::string subject, Findings& out) {
  // [Hz] a choice: a log of 1 kHz with milliseconds read as seconds has 1 Hz
  constexpr double slowest_rate = 8.0;
  // [Hz] no robot is logged as fast; 1 kHz with seconds read as milliseconds is 1 MHz
  constexpr double fastest_rate = 2e5;
  if (log.f_m < slowest_rate || log.f_m > fastest_rate) {
    out.add("time_scale", std::move(subject),
            "the rate is " + number(log.f_m, 3) + " Hz, should be between " + number(slowest_rate) + " and " +
                number(fastest_rate) + ": time may be in another unit, milliseconds say");
  }
}

}  // namespace

double rms(const Eigen::Ref<const Vector>& x) {
  return std::sqrt(x.squaredNorm() / static_cast<double>(std::max<Index>(x.size(), 1)));
}

Vector centred(const Eigen::Ref<const Vector>& x) { return x.array() - x.mean(); }

double range(const Eigen::Ref<const Vector>& x) { return x.maxCoeff() - x.minCoeff(); }

bool stands_still(const Eigen::Ref<const Vector>& q) {
  const double extent = range(q);
  return extent < surely_moves && extent <= std::max(still_range, still_sigmas * noise_level(q));
}

Likeness likeness(const Eigen::Ref<const Vector>& x, const Eigen::Ref<const Vector>& y) {
  const Vector a = centred(x);
  const Vector b = centred(y);
  const double norms = a.norm() * b.norm();
  return norms > 0.0 ? Likeness{a.dot(b) / a.squaredNorm(), a.dot(b) / norms} : Likeness{};
}

void check_encoders(const Robot& robot, std::span<const Log> logs, const Log& log, Findings& out) {
  std::string text;
  for (Index j = 0; j < robot.size(); ++j) {
    text += (text.empty() ? "" : ", ") + robot.joints[static_cast<std::size_t>(j)].name + " noise " +
            number(noise_level(log.q.col(j)), 2) + " step " + number(quantum(log.q.col(j)), 2);
  }
  out.add("encoder", logs.size() == 1 ? "all joints" : log.source, text + " [rad | m]");
}

void check_series(const Robot& robot, std::span<const Log> logs, const CheckOptions& options, Findings& out) {
  const bool moves = check_motion(robot, logs, out);
  if (moves) {
    check_smallness(robot, logs, out);
  }
  for (const Log& log : logs) {
    check_rate(log, logs.size() == 1 ? "all joints" : log.source, out);
    check_columns(robot, logs, log, out);
    for (Index j = 0; j < robot.size(); ++j) {
      check_limits(robot, logs, log, j, out);
    }
    check_torque_values(robot, logs, log, out);
    if (!moves) {
      continue;
    }
    const Matrix qd = velocities(log);
    check_standstill(robot, logs, log, qd, out);
    check_velocities(robot, logs, log, qd, out);
    check_clock(log, qd, logs.size() == 1 ? "all joints" : log.source, out);
    check_cutoff(robot, logs, log, options, out);
    check_reference(robot, logs, log, options.instrumental, out);
  }
}

}  // namespace rivid::detail
