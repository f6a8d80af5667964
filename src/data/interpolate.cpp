#include <algorithm>
#include <string>

#include "rivid/data/adjust.hpp"
#include "rivid/error.hpp"
#include "rivid/text.hpp"

namespace rivid {

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
  // Half an interval early: the interval before or after the one that a uniform clock would give is looked at as well.
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
