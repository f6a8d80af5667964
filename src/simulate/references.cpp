#include "rivid/simulate/references.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "accept.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Where in its motion a reference is, and whether it rests before or after it.
struct ReferenceTime {
  double t = 0.0;  // [s], between begin and end; NaN where that is asked for
  bool rests = false;

  // At which instant it is asked for, and the vectors that are filled.
  ReferenceTime(const Reference& reference, double asked, std::initializer_list<Index> sizes) {
    for (const Index size : sizes) {
      if (size != reference.joints()) {
        throw InputError("Reference::at: a vector has " + counted(size, "value") + ", must have " +
                         std::to_string(reference.joints()) + ", one a joint");
      }
    }
    // An instant that rounding put beyond an end, the sum of many periods say, still belongs to the motion.
    constexpr double rounding = 1e-9;
    const double begin = reference.begin();
    const double slack = rounding * reference.duration();
    const double end = begin + reference.duration();
    t = std::clamp(asked, begin, end);
    rests = asked < begin - slack || asked > end + slack;
  }
};

// Of the instant NaN, which lies between no samples.
void no_number(Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r, Eigen::Ref<Vector> qdd_r) {
  for (Eigen::Ref<Vector>* const x : {&q_r, &qd_r, &qdd_r}) {
    x->setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

using Samples = Eigen::Ref<const Matrix>;

// The samples, once it is known that a motion leads through them.
Samples checked(const std::string& who, const Eigen::Ref<const Vector>& t, const Samples& q_r) {
  if (t.size() != q_r.rows()) {
    throw InputError(who + ": t has " + std::to_string(t.size()) + " instants, q_r has " +
                     std::to_string(q_r.rows()) + " rows; they must be as many");
  }
  if (t.size() < 2 || q_r.cols() < 1) {
    throw InputError(who + ": q_r is (" + std::to_string(q_r.rows()) + " x " + std::to_string(q_r.cols()) +
                     "), must have two samples and one joint at least");
  }
  for (Index k = 0; k < t.size(); ++k) {
    if (!std::isfinite(t[k])) {
      throw InputError(who + ": t is " + number(t[k]) + " at index " + std::to_string(k) +
                       ", must be finite");
    }
    if (k > 0 && !(t[k] > t[k - 1])) {
      throw InputError(who + ": t must increase, but goes from " + number(t[k - 1]) + " to " + number(t[k]) +
                       " s at index " + std::to_string(k));
    }
  }
  for (Index j = 0; j < q_r.cols(); ++j) {
    for (Index k = 0; k < q_r.rows(); ++k) {
      if (!std::isfinite(q_r(k, j))) {
        throw InputError(who + ": the reference of joint " + std::to_string(j + 1) + " is " +
                         number(q_r(k, j)) + " at index " + std::to_string(k) + ", must be finite");
      }
    }
  }
  return q_r;
}

// Part of a move that is done, and its derivatives by time.
struct Progress {
  double s = 0.0, sd = 0.0, sdd = 0.0;
};

Progress quintic(double t, double T) {
  const double u = t / T;
  const double left = 1.0 - u;
  return {.s = u * u * u * (10.0 + u * (6.0 * u - 15.0)),
          .sd = 30.0 * u * u * left * left / T,
          .sdd = 60.0 * u * left * (1.0 - 2.0 * u) / (T * T)};
}

// Largest derivatives of the quintic with T = 1: at u = 1/2, at (3 ± √3)/6, at both ends.
constexpr double quintic_velocity = 15.0 / 8.0;
constexpr double quintic_acceleration = 5.773502691896258;  // 10/√3
constexpr double quintic_jerk = 60.0;

// Phases of a move with trapezoidal acceleration.
struct Phases {
  double jerk = 0.0, acceleration = 0.0, velocity = 0.0;  // durations T_j, T_a, T_v of one phase each

  [[nodiscard]] double duration() const { return 4.0 * jerk + 2.0 * acceleration + velocity; }
};

// The first half of the move; the other is its mirror image.
Progress first_half(double t, const Phases& phases) {
  const double T_j = phases.jerk;
  const double T_a = phases.acceleration;
  const double v = 1.0 / (2.0 * T_j + T_a + phases.velocity);
  const double a = v / (T_j + T_a);
  const double j = a / T_j;
  Progress at;  // the beginning of the phase
  const auto within = [&](double x, double jerk) {
    return Progress{.s = at.s + x * (at.sd + x * (at.sdd / 2.0 + x * jerk / 6.0)),
                    .sd = at.sd + x * (at.sdd + x * jerk / 2.0),
                    .sdd = at.sdd + x * jerk};
  };
  for (const auto& [length, jerk] : {std::pair{T_j, j}, std::pair{T_a, 0.0}, std::pair{T_j, -j}}) {
    if (t < length) {
      return within(t, jerk);
    }
    at = within(length, jerk);
    t -= length;
  }
  at = {.s = at.s, .sd = v, .sdd = 0.0};
  return within(t, 0.0);
}

Progress trapezoidal(double t, const Phases& phases) {
  const double T = phases.duration();
  if (t <= T / 2.0) {
    return first_half(t, phases);
  }
  const Progress mirrored = first_half(T - t, phases);
  return {.s = 1.0 - mirrored.s, .sd = mirrored.sd, .sdd = -mirrored.sdd};
}

// Largest derivatives that the limits of all joints leave to s, by the joint that has the most to go.
struct Limits {
  double velocity = std::numeric_limits<double>::infinity();
  double acceleration = std::numeric_limits<double>::infinity();
  double jerk = std::numeric_limits<double>::infinity();
};

Limits limits_of(const PointToPoint& moves, const Vector& distance) {
  const auto least = [&](const Vector& limit) {
    double out = std::numeric_limits<double>::infinity();
    for (Index j = 0; j < limit.size(); ++j) {
      if (distance[j] != 0.0) {
        out = std::min(out, limit[j] / std::abs(distance[j]));
      }
    }
    return out;
  };
  return {.velocity = least(moves.max_velocity),
          .acceleration = least(moves.max_acceleration),
          .jerk = least(moves.max_jerk)};
}

double quintic_duration(const Limits& limit) {
  return std::max({quintic_velocity / limit.velocity, std::sqrt(quintic_acceleration / limit.acceleration),
                   std::cbrt(quintic_jerk / limit.jerk)});
}

// The shortest phases of a unit move.
Phases shortest(const Limits& limit) {
  const double j = limit.jerk;
  Phases out{.jerk = std::cbrt(0.5 / j)};
  if (j * out.jerk > limit.acceleration) {
    const double a = limit.acceleration;
    out.jerk = a / j;
    // a (T_j + T_a) (2 T_j + T_a) = 1
    out.acceleration = std::max(0.0, (std::sqrt(out.jerk * out.jerk + 4.0 / a) - 3.0 * out.jerk) / 2.0);
  }
  if (j * out.jerk * (out.jerk + out.acceleration) > limit.velocity) {
    const double v = limit.velocity;
    out.jerk = std::min(std::sqrt(v / j), limit.acceleration / j);
    // v = j T_j (T_j + T_a); without a phase of constant acceleration but for rounding
    out.acceleration = std::max(0.0, v / (j * out.jerk) - out.jerk);
    out.velocity = std::max(0.0, 1.0 / v - 2.0 * out.jerk - out.acceleration);
  }
  return out;
}

Phases equal_phases(double duration) {
  const double phase = duration / 7.0;
  return {.jerk = phase, .acceleration = phase, .velocity = phase};
}

double one_or_all(const Vector& values, Index i) { return values.size() == 1 ? values[0] : values[i]; }

std::optional<std::string> limit_complaint(const char* name, const Vector& limit, Index n) {
  if (limit.size() == 0) {
    return std::nullopt;
  }
  if (limit.size() != n) {
    return std::string(name) + " has " + std::to_string(limit.size()) + " entries for " + std::to_string(n) +
           " joints";
  }
  for (Index j = 0; j < n; ++j) {
    if (!(limit[j] > 0.0) || !std::isfinite(limit[j])) {
      return std::string(name) + " of joint " + std::to_string(j + 1) + " is " + number(limit[j]) +
             ", must be positive and finite";
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> FourierSeries::complaint() const {
  const auto size = [](const Matrix& x) {
    return "(" + std::to_string(x.rows()) + " x " + std::to_string(x.cols()) + ")";
  };
  if (!(omega_f > 0.0) || !std::isfinite(omega_f)) {
    return "omega_f is " + number(omega_f) + " rad/s, must be positive and finite";
  }
  if (A.size() == 0 || A.rows() != B.rows() || A.cols() != B.cols()) {
    return "A is " + size(A) + " and B is " + size(B) +
           "; both must be (n x L): one row a joint, one column a harmonic";
  }
  if (q0.size() != 0 && q0.size() != A.rows()) {
    return "q0 has " + std::to_string(q0.size()) + " entries for " + std::to_string(A.rows()) + " joints";
  }
  for (Index j = 0; j < A.rows(); ++j) {
    if (!A.row(j).allFinite() || !B.row(j).allFinite() || (q0.size() > 0 && !std::isfinite(q0[j]))) {
      return "the coefficients of joint " + std::to_string(j + 1) + " must be finite";
    }
  }
  if (!(duration >= 0.0) || !std::isfinite(duration)) {
    return "duration is " + number(duration) + " s, must be positive and finite, or 0 for one period";
  }
  if (!std::isfinite(2.0 * std::numbers::pi / omega_f)) {
    return "omega_f is " + number(omega_f) + " rad/s, its period is not finite";
  }
  return std::nullopt;
}

FourierReference::FourierReference(FourierSeries series) : series_(std::move(series)) {
  detail::accept("FourierReference", series_.complaint());
  if (series_.q0.size() == 0) {
    series_.q0 = Vector::Zero(joints());
  }
  if (series_.duration == 0.0) {
    series_.duration = 2.0 * std::numbers::pi / series_.omega_f;
  }
}

void FourierReference::at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
                          Eigen::Ref<Vector> qdd_r) const {
  const ReferenceTime time(*this, t, {q_r.size(), qd_r.size(), qdd_r.size()});
  q_r = series_.q0;
  qd_r.setZero();
  qdd_r.setZero();
  // The sines of one harmonic follow from those of the last, to some l roundings: a call of sin and cos for
  // each would take most of the time.
  const double s_1 = std::sin(series_.omega_f * time.t);
  const double c_1 = std::cos(series_.omega_f * time.t);
  const double moves = time.rests ? 0.0 : 1.0;
  double s = s_1;
  double c = c_1;
  for (Index l = 0; l < series_.A.cols(); ++l) {
    const double omega = static_cast<double>(l + 1) * series_.omega_f;
    const double length = 1.0 / omega;
    for (Index j = 0; j < series_.A.rows(); ++j) {
      const double along = s * series_.A(j, l) - c * series_.B(j, l);
      q_r[j] += length * along;
      qd_r[j] += moves * (c * series_.A(j, l) + s * series_.B(j, l));
      qdd_r[j] -= moves * omega * along;
    }
    const double last = s;
    s = last * c_1 + c * s_1;
    c = c * c_1 - last * s_1;
  }
}

LoggedReference::LoggedReference(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& q_r)
    : spline_(t, checked("LoggedReference", t, q_r)) {}

void LoggedReference::at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
                         Eigen::Ref<Vector> qdd_r) const {
  const ReferenceTime time(*this, t, {q_r.size(), qd_r.size(), qdd_r.size()});
  if (std::isnan(time.t)) {
    return no_number(q_r, qd_r, qdd_r);
  }
  spline_.at(time.t, q_r, qd_r, qdd_r);
  if (time.rests) {
    qd_r.setZero();
    qdd_r.setZero();
  }
}

LinearReference::LinearReference(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& q_r)
    : t_(t), q_r_(checked("LinearReference", t, q_r)) {}

void LinearReference::at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
                         Eigen::Ref<Vector> qdd_r) const {
  const ReferenceTime time(*this, t, {q_r.size(), qd_r.size(), qdd_r.size()});
  if (std::isnan(time.t)) {
    return no_number(q_r, qd_r, qdd_r);
  }
  const Index i = detail::interval(t_, time.t);
  const double h = t_[i + 1] - t_[i];
  const double part = (time.t - t_[i]) / h;
  for (Index j = 0; j < q_r_.cols(); ++j) {
    q_r[j] = (1.0 - part) * q_r_(i, j) + part * q_r_(i + 1, j);
    qd_r[j] = time.rests ? 0.0 : (q_r_(i + 1, j) - q_r_(i, j)) / h;
  }
  qdd_r.setZero();
}

std::optional<std::string> PointToPoint::complaint() const {
  const Index k = via.rows();
  const Index n = via.cols();
  if (k < 2 || n < 1) {
    return "via is (" + std::to_string(k) + " x " + std::to_string(n) +
           "), must have two points and one joint at least";
  }
  for (Index i = 0; i < k; ++i) {
    if (!via.row(i).allFinite()) {
      return "via point " + std::to_string(i + 1) + " must be finite";
    }
  }
  const bool limited = max_velocity.size() + max_acceleration.size() + max_jerk.size() > 0;
  if (limited == (durations.size() > 0)) {
    return std::string("give either durations or limits (max_velocity, max_acceleration, max_jerk)") +
           (limited ? ", not both" : "");
  }
  if (!limited && durations.size() != 1 && durations.size() != k - 1) {
    return "durations has " + std::to_string(durations.size()) + " entries for " + counted(k - 1, "move") +
           "; one for each, or one for all";
  }
  for (Index i = 0; i < durations.size(); ++i) {
    if (!(durations[i] > 0.0) || !std::isfinite(durations[i])) {
      return "the duration of move " + std::to_string(i + 1) + " is " + number(durations[i]) +
             " s, must be positive and finite";
    }
  }
  for (const auto& [name, limit] :
       {std::pair{"max_velocity", &max_velocity}, std::pair{"max_acceleration", &max_acceleration},
        std::pair{"max_jerk", &max_jerk}}) {
    if (auto complaint = limit_complaint(name, *limit, n)) {
      return complaint;
    }
  }
  if (limited && profile == MoveProfile::trapezoidal_acceleration && max_jerk.size() == 0) {
    return "max_jerk is required for a trapezoidal acceleration within limits";
  }
  if (dwell.size() > 1 && dwell.size() != k) {
    return "dwell has " + std::to_string(dwell.size()) + " entries for " + counted(k, "point") +
           "; one for each, one for all, or none";
  }
  for (Index i = 0; i < dwell.size(); ++i) {
    if (!(dwell[i] >= 0.0) || !std::isfinite(dwell[i])) {
      return "the dwell at point " + std::to_string(i + 1) + " is " + number(dwell[i]) +
             " s, must be finite and not negative";
    }
  }
  return std::nullopt;
}

PointToPointReference::PointToPointReference(const PointToPoint& moves)
    : profile_(moves.profile), via_(moves.via.transpose()) {
  detail::accept("PointToPointReference", moves.complaint());
  const auto rest = [&](Index point) {
    return moves.dwell.size() == 0 ? 0.0 : one_or_all(moves.dwell, point);
  };
  duration_ = rest(0);
  for (Index i = 0; i + 1 < via_.cols(); ++i) {
    const Vector distance = via_.col(i + 1) - via_.col(i);
    Move move{.start = duration_};
    if (moves.durations.size() > 0) {
      move.duration = one_or_all(moves.durations, i);
      const Phases phases = equal_phases(move.duration);
      move.jerk_time = phases.jerk;
      move.acceleration_time = phases.acceleration;
    } else if (!distance.isZero(0.0)) {
      const Limits limit = limits_of(moves, distance);
      const Phases phases = shortest(limit);
      const bool is_quintic = profile_ == MoveProfile::quintic;
      move.duration = is_quintic ? quintic_duration(limit) : phases.duration();
      move.jerk_time = phases.jerk;
      move.acceleration_time = phases.acceleration;
    }
    moves_.push_back(move);
    duration_ += move.duration + rest(i + 1);
  }
}

void PointToPointReference::at(double t, Eigen::Ref<Vector> q_r, Eigen::Ref<Vector> qd_r,
                               Eigen::Ref<Vector> qdd_r) const {
  const ReferenceTime time(*this, t, {q_r.size(), qd_r.size(), qdd_r.size()});
  // The last move that has begun: of several at one instant, the others have nowhere to go.
  const auto after = std::upper_bound(moves_.begin(), moves_.end(), time.t,
                                      [](double instant, const Move& move) { return instant < move.start; });
  const Index i = std::max<Index>(0, after - moves_.begin() - 1);
  const Move& move = moves_[static_cast<std::size_t>(i)];
  const double since = time.t - move.start;
  if (since <= 0.0 || since >= move.duration) {
    q_r = via_.col(since <= 0.0 ? i : i + 1);
    qd_r.setZero();
    qdd_r.setZero();
    return;
  }
  const Phases phases{.jerk = move.jerk_time,
                      .acceleration = move.acceleration_time,
                      .velocity = move.duration - 4.0 * move.jerk_time - 2.0 * move.acceleration_time};
  const Progress progress =
      profile_ == MoveProfile::quintic ? quintic(since, move.duration) : trapezoidal(since, phases);
  q_r = (1.0 - progress.s) * via_.col(i) + progress.s * via_.col(i + 1);
  qd_r = progress.sd * (via_.col(i + 1) - via_.col(i));
  qdd_r = progress.sdd * (via_.col(i + 1) - via_.col(i));
}

}  // namespace rivid
