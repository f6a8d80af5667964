#include "rivid/data/adjust.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "log_columns.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

namespace {

// Rounding of time stamps may put a sample behind the end of a reference by this part of the reference's
// period.
constexpr double span_tolerance = 1e-6;

void require_torques(const char* who, const Log& log) {
  if (log.tau.size() == 0) {
    throw InputError(std::string(who) + ": " + log.source + " has no torques");
  }
}

std::string range(double lower, double upper, const char* unit) {
  return number(lower) + " to " + number(upper) + unit;
}

}  // namespace

Log shift_torque(const Log& log, double lag) {
  if (log.tau.size() == 0 && log.v_tau.size() == 0) {
    throw InputError("shift_torque: " + log.source + " has neither torques nor control signals");
  }
  detail::require_even("shift_torque", log);
  if (!std::isfinite(lag) || std::abs(lag) >= static_cast<double>(log.samples() - 1)) {
    throw InputError("shift_torque: lag is " + number(lag) + " samples, but " + log.source + " has only " +
                     std::to_string(log.samples()));
  }
  if (lag == 0.0) {
    return log;
  }
  // Sample k takes its torque from row k + lag, between the rows k + whole and k + whole + 1.
  const auto whole = static_cast<Index>(std::floor(lag));
  const double fraction = lag - std::floor(lag);
  const Index reach = fraction > 0.0 ? whole + 1 : whole;
  const Index first = std::max<Index>(0, -whole);
  const Index kept = log.samples() - first - std::max<Index>(0, reach);
  Log out = excerpt(log, first, kept);
  const auto shifted = [&](const Matrix& x) -> Matrix {
    if (x.size() == 0) {
      return x;
    }
    return (1.0 - fraction) * x.middleRows(first + whole, kept) +
           fraction * x.middleRows(first + reach, kept);
  };
  out.tau = shifted(log.tau);
  out.v_tau = shifted(log.v_tau);
  const Index lost = log.samples() - kept;
  out.notes.push_back("torques moved by " + number(-lag) + " samples, " + counted(lost, "row") +
                      " dropped at the " + (lag > 0.0 ? "end" : "start"));
  return out;
}

std::optional<std::string> TorqueTable::complaint() const {
  if (q.size() != tau.size() || q.size() < 2) {
    return source + ": the table has " + std::to_string(q.size()) + " positions and " +
           std::to_string(tau.size()) +
           " torques; at least 2 of both are required, as many of one as of the other";
  }
  if (!q.allFinite() || !tau.allFinite()) {
    return source + ": the table must be finite";
  }
  for (Index i = 1; i < q.size(); ++i) {
    if (q[i] <= q[i - 1]) {
      return source + ": the positions of the table must increase, but row " + std::to_string(i + 1) +
             " has " + number(q[i]) + " after " + number(q[i - 1]);
    }
  }
  return std::nullopt;
}

TorqueTable read_torque_table(const std::filesystem::path& path, const TableOptions& options) {
  const Table table = read_table(path, options);
  if (table.columns() != 2) {
    throw InputError(table.source + ": two columns are required, position and torque; got " +
                     std::to_string(table.columns()) + " (" + listed(table.names) + ")");
  }
  TorqueTable out{table.source, table.values.col(0), table.values.col(1)};
  if (const auto fault = out.complaint()) {
    throw InputError(*fault);
  }
  return out;
}

Log subtract_torque(Log log, Index joint, const TorqueTable& table, Outside outside) {
  require_torques("subtract_torque", log);
  detail::require_even("subtract_torque", log);
  if (const auto fault = table.complaint()) {
    throw InputError("subtract_torque: " + *fault);
  }
  if (joint < 0 || joint >= log.q.cols() || joint >= log.tau.cols()) {
    throw InputError("subtract_torque: there is no joint " + std::to_string(joint + 1) + "; " + log.source +
                     " has " + std::to_string(log.joints()));
  }
  const double lower = table.q[0];
  const double upper = table.q[table.q.size() - 1];
  Index held = 0;
  for (Index k = 0; k < log.q.rows(); ++k) {
    const double q = log.q(k, joint);
    if (q >= lower && q <= upper) {
      continue;
    }
    if (outside == Outside::refuse) {
      throw InputError("subtract_torque: " + log.place(k) + ": joint " + std::to_string(joint + 1) +
                       " is at " + number(q) + ", outside of " + table.source + ", which goes from " +
                       range(lower, upper, "") + "; extend the table, cut the log, or hold the end values");
    }
    ++held;
  }
  log.tau.col(joint) -= linear_interpolation(table.q, table.tau, log.q.col(joint));
  log.notes.push_back("torque of " + table.source + " subtracted from joint " + std::to_string(joint + 1) +
                      (held > 0 ? "; its end values held for " + counted(held, "sample") : ""));
  return log;
}

Log with_reference(Log log, const Log& reference, double delay_s, Outside outside) {
  if (reference.q_r.size() == 0 || reference.t.size() < 2) {
    throw InputError("with_reference: " + reference.source + " has no reference positions");
  }
  if (!std::isfinite(delay_s)) {
    throw InputError("with_reference: delay_s is " + number(delay_s) + " s, must be finite");
  }
  if (reference.q_r.cols() != log.joints()) {
    throw InputError("with_reference: " + reference.source + " has " + std::to_string(reference.q_r.cols()) +
                     " joints, " + log.source + " has " + std::to_string(log.joints()));
  }
  for (const Log* const each : {&std::as_const(log), &reference}) {
    if (!each->t.allFinite()) {
      throw InputError("with_reference: " + each->source + ": t must be finite");
    }
  }
  const double first = reference.t[0];
  const double last = reference.t[reference.t.size() - 1];
  const double tolerance = span_tolerance * (last - first) / static_cast<double>(reference.t.size() - 1);
  Vector at = log.t.array() - delay_s;
  const auto is_outside = [&](Index k) { return at[k] < first - tolerance || at[k] > last + tolerance; };
  std::vector<Index> held;
  for (Index k = 0; k < at.size(); ++k) {
    if (is_outside(k)) {
      held.push_back(k);
    }
  }
  if (!held.empty() && outside == Outside::refuse) {
    throw InputError("with_reference: " + log.place(held.front()) + ": t − delay is " +
                     number(at[held.front()]) + " s, but " + reference.source + " covers " +
                     range(first, last, " s") + " only; cut the log to t = " +
                     range(first + delay_s, last + delay_s, " s") + ", or hold the end values");
  }
  at = at.cwiseMax(first).cwiseMin(last);
  log.q_r = CubicSpline(reference.t, reference.q_r)(at);
  log.qd_r.resize(0, 0);
  if (reference.qd_r.size() > 0) {
    log.qd_r = linear_interpolation(reference.t, reference.qd_r, at);
    for (const Index k : held) {
      log.qd_r.row(k).setZero();
    }
  }
  log.notes.push_back("reference from " + reference.source + ", " + number(delay_s) + " s later" +
                      (held.empty() ? "" : "; held for " + counted(std::ssize(held), "sample")));
  return log;
}

namespace {

void check(const char* who, const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& values,
           Index least) {
  if (t.size() != values.rows()) {
    throw InputError(std::string(who) + ": t has " + std::to_string(t.size()) + " instants, values has " +
                     std::to_string(values.rows()) + " rows; they must be as many");
  }
  if (t.size() < least) {
    throw InputError(std::string(who) + ": t has " + std::to_string(t.size()) + " instants, at least " +
                     std::to_string(least) + " are required");
  }
  for (Index i = 1; i < t.size(); ++i) {
    if (!(t[i] > t[i - 1])) {
      throw InputError(std::string(who) + ": t must increase, but goes from " + number(t[i - 1]) + " to " +
                       number(t[i]) + " at index " + std::to_string(i));
    }
  }
}

// Interval i of `t` that `at` lies in, 0 ≤ i ≤ m − 2; the first or last one outside. `hint` is the last
// answer.
Index interval(const Vector& t, double at, Index hint) {
  const Index last = t.size() - 2;
  if (at >= t[hint] && (hint == last || at < t[hint + 1])) {
    return hint;
  }
  if (hint < last && at >= t[hint + 1] && (hint + 1 == last || at < t[hint + 2])) {
    return hint + 1;
  }
  const double* const begin = t.data();
  const Index after = std::upper_bound(begin, begin + t.size(), at) - begin;
  return std::clamp<Index>(after - 1, 0, last);
}

// Slopes at the samples. Continuity of the second derivative at the inner samples gives a tridiagonal system;
// the not-a-knot condition has three unknowns, one of which the neighbouring equation removes.
Matrix slopes(const Vector& t, const Matrix& values) {
  const Index m = t.size();
  const Vector h = t.tail(m - 1) - t.head(m - 1);
  const Matrix secant = (values.bottomRows(m - 1) - values.topRows(m - 1)).array().colwise() / h.array();
  Matrix s(m, values.cols());
  if (m == 2) {
    s.row(0) = s.row(1) = secant.row(0);
    return s;
  }
  if (m == 3) {
    // One parabola: its slope at the middle weighs the secants by the opposite intervals.
    s.row(1) = (h[1] * secant.row(0) + h[0] * secant.row(1)) / (h[0] + h[1]);
    s.row(0) = 2.0 * secant.row(0) - s.row(1);
    s.row(2) = 2.0 * secant.row(1) - s.row(1);
    return s;
  }
  Vector diagonal(m);
  Vector upper(m - 1);
  Vector lower(m - 1);    // lower[i] stands in row i + 1
  const Index e = m - 2;  // last interval
  const double first_two = h[0] + h[1];
  const double last_two = h[e] + h[e - 1];
  diagonal[0] = h[1];
  upper[0] = first_two;
  s.row(0) = ((h[0] + 2.0 * first_two) * h[1] * secant.row(0) + h[0] * h[0] * secant.row(1)) / first_two;
  for (Index i = 1; i < m - 1; ++i) {
    lower[i - 1] = h[i];
    diagonal[i] = 2.0 * (h[i - 1] + h[i]);
    upper[i] = h[i - 1];
    s.row(i) = 3.0 * (h[i] * secant.row(i - 1) + h[i - 1] * secant.row(i));
  }
  lower[e] = last_two;
  diagonal[m - 1] = h[e - 1];
  s.row(m - 1) =
      (h[e] * h[e] * secant.row(e - 1) + (2.0 * last_two + h[e]) * h[e - 1] * secant.row(e)) / last_two;

  for (Index i = 1; i < m; ++i) {
    const double factor = lower[i - 1] / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    s.row(i) -= factor * s.row(i - 1);
  }
  s.row(m - 1) /= diagonal[m - 1];
  for (Index i = m - 2; i >= 0; --i) {
    s.row(i) = (s.row(i) - upper[i] * s.row(i + 1)) / diagonal[i];
  }
  return s;
}

// The cubic of one interval, as powers of the time since its beginning.
struct Cubic {
  double value, slope, half_curvature, sixth_jerk;

  Cubic(double h, double left, double right, double slope_left, double slope_right)
      : value(left), slope(slope_left) {
    const double secant = (right - left) / h;
    const double bend = (slope_left + slope_right - 2.0 * secant) / h;
    half_curvature = (secant - slope_left) / h - bend;
    sixth_jerk = bend / h;
  }

  [[nodiscard]] double at(double x) const {
    return value + x * (slope + x * (half_curvature + x * sixth_jerk));
  }
  [[nodiscard]] double slope_at(double x) const {
    return slope + x * (2.0 * half_curvature + x * 3.0 * sixth_jerk);
  }
  [[nodiscard]] double curvature_at(double x) const { return 2.0 * half_curvature + x * 6.0 * sixth_jerk; }
};

}  // namespace

Index detail::interval(const Vector& t, double at) {
  const Index last = t.size() - 2;
  // Half an interval early: the interval before or after the one that a uniform clock would give is looked at
  // as well.
  const double guess = (at - t[0]) / (t[last + 1] - t[0]) * static_cast<double>(last + 1) - 0.5;
  const double within = std::clamp(guess, 0.0, static_cast<double>(last));
  return rivid::interval(t, at, static_cast<Index>(within));
}

CubicSpline::CubicSpline(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& values)
    : t_(t), values_(values) {
  check("CubicSpline", t, values, 2);
  slopes_ = slopes(t_, values_);
}

Matrix CubicSpline::operator()(const Eigen::Ref<const Vector>& at) const {
  Matrix out(at.size(), values_.cols());
  Index i = 0;
  for (Index k = 0; k < at.size(); ++k) {
    i = interval(t_, at[k], i);
    for (Index c = 0; c < values_.cols(); ++c) {
      const Cubic cubic(t_[i + 1] - t_[i], values_(i, c), values_(i + 1, c), slopes_(i, c),
                        slopes_(i + 1, c));
      out(k, c) = cubic.at(at[k] - t_[i]);
    }
  }
  return out;
}

void CubicSpline::at(double t, Eigen::Ref<Vector> value, Eigen::Ref<Vector> slope,
                     Eigen::Ref<Vector> curvature) const {
  const Index i = detail::interval(t_, t);
  const double x = t - t_[i];
  for (Index c = 0; c < values_.cols(); ++c) {
    const Cubic cubic(t_[i + 1] - t_[i], values_(i, c), values_(i + 1, c), slopes_(i, c), slopes_(i + 1, c));
    value[c] = cubic.at(x);
    slope[c] = cubic.slope_at(x);
    curvature[c] = cubic.curvature_at(x);
  }
}

Matrix linear_interpolation(const Eigen::Ref<const Vector>& t, const Eigen::Ref<const Matrix>& values,
                            const Eigen::Ref<const Vector>& at) {
  check("linear_interpolation", t, values, 1);
  if (t.size() == 1) {
    return values.row(0).replicate(at.size(), 1);
  }
  const Vector knots = t;
  Matrix out(at.size(), values.cols());
  Index i = 0;
  for (Index k = 0; k < at.size(); ++k) {
    i = interval(knots, at[k], i);
    const double part = std::clamp((at[k] - knots[i]) / (knots[i + 1] - knots[i]), 0.0, 1.0);
    out.row(k) = (1.0 - part) * values.row(i) + part * values.row(i + 1);
  }
  return out;
}

}  // namespace rivid
