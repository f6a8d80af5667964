#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include "rivid/fields.hpp"

namespace rivid {

/// How a passive joint of a planar four-bar linkage follows the joint of its crank: by the law of cosines,
/// and slopes and curvatures by the derivatives of the closed loop. Angles are about the axis of the crank's
/// joint, from the line that leads from the crank's axis to the rocker's.
struct FourBarAngle {
  double ground = 0.0;       ///< distance of the crank's axis to the rocker's [m]
  double crank = 0.0;        ///< of the crank's axis to the coupler's [m]
  double coupler = 0.0;      ///< of the coupler's axis to the closing point [m]
  double rocker = 0.0;       ///< of the rocker's axis to the closing point [m]
  double crank_angle = 0.0;  ///< of the crank where its joint is at 0 [rad]
  double zero = 0.0;         ///< of the joint's link where the joint and the crank's are at 0 [rad]
  double least = 0.0;        ///< positions of the crank's joint that the linkage reaches [rad]
  double most = 0.0;
  bool mirrored = false;               ///< whether the coupler turns clockwise to the rocker
  bool of_rocker = false;              ///< the joint is the rocker's, else the coupler's
  bool reversed = false;               ///< whether the joint's axis is opposite to the crank's
  bool turns = false;                  ///< whether rocker and coupler go round with the crank
  std::array<double, 3> closing = {};  ///< point in the frame of the joint's link [m]

  template <typename A = FourBarAngle>
  static constexpr auto fields() {
    return std::tuple(Field{"ground", &A::ground, ""}, Field{"crank", &A::crank, ""},
                      Field{"coupler", &A::coupler, ""}, Field{"rocker", &A::rocker, ""},
                      Field{"crank_angle", &A::crank_angle, ""}, Field{"zero", &A::zero, ""},
                      Field{"least", &A::least, ""}, Field{"most", &A::most, ""},
                      Field{"mirrored", &A::mirrored, ""}, Field{"of_rocker", &A::of_rocker, ""},
                      Field{"reversed", &A::reversed, ""}, Field{"turns", &A::turns, ""},
                      Field{"closing", &A::closing, ""});
  }

  bool operator==(const FourBarAngle&) const = default;

  /// Position of the joint, and its first and second derivative by that of the crank's; no numbers where the
  /// linkage can not be closed.
  ///
  /// @param q  position of the crank's joint [rad]
  template <typename Scalar>
  [[nodiscard]] std::array<Scalar, 3> at(const Scalar& q) const;

 private:
  template <typename Scalar>
  [[nodiscard]] std::array<Scalar, 3> of_one(const Scalar& q) const;
};

/// How a joint follows one to three others by a table: a cubic spline of pieces of one length in each of
/// them.
struct JointSpline {
  static constexpr std::size_t most_joints = 3;  // a choice: coefficients grow by a power of each
  static constexpr std::size_t most_values = 1 + most_joints + most_joints * most_joints;  // with curvatures

  std::vector<double> least, most;   ///< positions of the joints that it follows, one each [rad | m]
  std::vector<int> pieces;           ///< between these
  std::vector<double> coefficients;  ///< of products of B-splines, (Π (pieces + 3)), the last joint's fastest

  template <typename S = JointSpline>
  static constexpr auto fields() {
    return std::tuple(Field{"least", &S::least, ""}, Field{"most", &S::most, ""},
                      Field{"pieces", &S::pieces, ""}, Field{"coefficients", &S::coefficients, ""});
  }

  bool operator==(const JointSpline&) const = default;

  /// The four B-splines of a joint that are not zero there, and their first and second derivatives.
  template <typename Scalar>
  struct Basis {
    std::size_t first = 0;
    std::array<std::array<Scalar, 4>, 3> values;
  };
  template <typename Scalar>
  [[nodiscard]] Basis<Scalar> basis(std::size_t axis, const Scalar& q) const;

  /// Position of the joint, its d slopes by those that it follows, and its d × d curvatures. Beyond its ends
  /// the last pieces go on.
  ///
  /// @param q  their positions, (d)
  template <typename Scalar>
  void at(const Scalar* q, Scalar* out) const;

 private:
  template <typename Scalar>
  void of_one(const Scalar* q, Scalar* out) const;
};

namespace detail {

template <typename Scalar>
struct Planar {
  Scalar x, y;

  friend Planar operator-(const Planar& a, const Planar& b) { return {a.x - b.x, a.y - b.y}; }
  [[nodiscard]] Planar times(const Scalar& k) const { return {k * x, k * y}; }
  [[nodiscard]] Planar turned(const Scalar& c, const Scalar& s) const {
    return {x * c - y * s, x * s + y * c};
  }
};
template <typename Scalar>
Scalar dot(const Planar<Scalar>& a, const Planar<Scalar>& b) {
  return a.x * b.x + a.y * b.y;
}
template <typename Scalar>
Scalar cross(const Planar<Scalar>& a, const Planar<Scalar>& b) {
  return a.x * b.y - a.y * b.x;
}

// A number without its derivatives or imaginary part; none of a formula that is recorded, in which no linkage
// takes part.
template <typename Scalar>
double plain_value(const Scalar& x) {
  if constexpr (std::is_convertible_v<Scalar, double>) {
    return static_cast<double>(x);
  } else if constexpr (requires { x.real(); }) {
    return x.real();
  } else if constexpr (requires { x.value(); }) {
    return x.value();
  } else {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

// Angle of a unit vector, with the derivatives of its components.
template <typename Scalar>
Scalar angle_of(const Planar<Scalar>& u) {
  const double plain = std::atan2(plain_value(u.y), plain_value(u.x));
  return Scalar(plain) + u.y * Scalar(std::cos(plain)) - u.x * Scalar(std::sin(plain));
}

}  // namespace detail

template <typename Scalar>
std::array<Scalar, 3> FourBarAngle::at(const Scalar& q) const {
  if constexpr (requires { Scalar::lanes; }) {
    std::array<std::array<double, Scalar::lanes>, 3> each;
    for (int lane = 0; lane < Scalar::lanes; ++lane) {
      const std::array<double, 3> one = at(q[lane]);
      for (std::size_t k = 0; k < one.size(); ++k) {
        each[k][static_cast<std::size_t>(lane)] = one[k];
      }
    }
    return {Scalar::load(each[0].data()), Scalar::load(each[1].data()), Scalar::load(each[2].data())};
  } else {
    return of_one(q);
  }
}

template <typename Scalar>
std::array<Scalar, 3> FourBarAngle::of_one(const Scalar& q) const {
  using detail::cross;
  using detail::dot;
  using std::cos;
  using std::sin;
  using std::sqrt;
  using Plane = detail::Planar<Scalar>;
  const auto a = static_cast<Scalar>(crank);
  const auto b = static_cast<Scalar>(coupler);
  const auto c = static_cast<Scalar>(rocker);
  const Scalar angle = q + Scalar(crank_angle);
  const Plane u2 = {cos(angle), sin(angle)};
  // From the rocker's axis to the coupler's; the rocker turns from there to the closing point.
  const Plane r = u2.times(a) - Plane{Scalar(ground), Scalar(0.0)};
  const Scalar length = sqrt(dot(r, r));
  const Scalar cosine = (dot(r, r) + c * c - b * b) / (Scalar(2.0) * length * c);
  const Scalar sine = sqrt(Scalar(Scalar(1.0) - cosine * cosine));
  const Plane u4 = r.turned(cosine, mirrored ? sine : Scalar(-sine)).times(Scalar(1.0) / length);
  const Plane u3 = (u4.times(c) - r).times(Scalar(1.0) / b);
  const Scalar s34 = cross(u3, u4);
  const Scalar c34 = dot(u3, u4);
  const Scalar w3 = a * cross(u4, u2) / (b * s34);
  const Scalar w4 = a * cross(u3, u2) / (c * s34);
  const Scalar e3 = (a * dot(u4, u2) + b * w3 * w3 * c34 - c * w4 * w4) / (b * s34);
  const Scalar e4 = (a * dot(u3, u2) + b * w3 * w3 - c * w4 * w4 * c34) / (c * s34);
  const Scalar from = turns ? Scalar(q + Scalar(zero)) : Scalar(zero);
  const Scalar way = detail::angle_of((of_rocker ? u4 : u3).turned(cos(from), Scalar(-sin(from))));
  Scalar x = turns ? Scalar(way + q) : way;
  Scalar slope = of_rocker ? w4 : w3;
  if (!of_rocker) {
    x = x - q;
    slope = slope - Scalar(1.0);
  }
  const Scalar sign(reversed ? -1.0 : 1.0);
  return {sign * x, sign * slope, sign * (of_rocker ? e4 : e3)};
}

template <typename Scalar>
JointSpline::Basis<Scalar> JointSpline::basis(std::size_t axis, const Scalar& q) const {
  const double per = pieces[axis] / (most[axis] - least[axis]);
  const double place = (detail::plain_value(q) - least[axis]) * per;
  const double cell = std::floor(std::min(std::max(0.0, place), pieces[axis] - 1.0));
  const Scalar t = (q - Scalar(least[axis])) * Scalar(per) - Scalar(cell);
  const Scalar one(1.0);
  const Scalar u = one - t;
  const Scalar half(0.5);
  const auto sixth = static_cast<Scalar>(1.0 / 6.0);
  const Scalar three(3.0);
  const Scalar four(4.0);
  const auto p = static_cast<Scalar>(per);
  const auto pp = static_cast<Scalar>(per * per);
  return {static_cast<std::size_t>(cell),
          {{{u * u * u * sixth, (three * t * t * t - Scalar(6.0) * t * t + four) * sixth,
             (three * u * u * u - Scalar(6.0) * u * u + four) * sixth, t * t * t * sixth},
            {Scalar(0.0) - p * half * u * u, p * half * (three * t * t - four * t),
             p * half * (four * u - three * u * u), p * half * t * t},
            {pp * u, pp * (three * t - one - one), pp * (three * u - one - one), pp * t}}}};
}

template <typename Scalar>
void JointSpline::at(const Scalar* q, Scalar* out) const {
  if constexpr (requires { Scalar::lanes; }) {
    const std::size_t d = pieces.size();
    std::array<std::array<double, Scalar::lanes>, most_values> each{};
    for (int lane = 0; lane < Scalar::lanes; ++lane) {
      std::array<double, most_joints> at_lane{};
      std::array<double, most_values> values{};
      for (std::size_t a = 0; a < d; ++a) {
        at_lane[a] = q[a][lane];
      }
      of_one(at_lane.data(), values.data());
      for (std::size_t v = 0; v < values.size(); ++v) {
        each[v][static_cast<std::size_t>(lane)] = values[v];
      }
    }
    for (std::size_t v = 0; v < 1 + d + d * d; ++v) {
      out[v] = Scalar::load(each[v].data());
    }
  } else {
    of_one(q, out);
  }
}

template <typename Scalar>
void JointSpline::of_one(const Scalar* q, Scalar* out) const {
  const std::size_t d = pieces.size();
  std::array<Basis<Scalar>, most_joints> of_joint{};
  std::size_t corners = 1;
  for (std::size_t a = 0; a < d; ++a) {
    of_joint[a] = basis(a, q[a]);
    corners *= 4;
  }
  std::fill_n(out, 1 + d + d * d, Scalar(0.0));
  for (std::size_t corner = 0; corner < corners; ++corner) {
    std::array<std::size_t, most_joints> piece{};
    std::size_t place = 0;
    for (std::size_t a = 0, rest = corner; a < d; ++a, rest /= 4) {
      piece[a] = rest % 4;
      place = place * static_cast<std::size_t>(pieces[a] + 3) + of_joint[a].first + piece[a];
    }
    for (std::size_t v = 0; v < 1 + d + d * d; ++v) {
      auto product = static_cast<Scalar>(coefficients[place]);
      for (std::size_t a = 0; a < d; ++a) {
        // Value 0; slope 1 + i; curvature 1 + d + i d + k.
        const bool curves = v > d;
        const std::size_t i = curves ? (v - 1 - d) / d : v - 1;
        const std::size_t order = (v > 0 && i == a ? 1U : 0U) + (curves && (v - 1 - d) % d == a ? 1U : 0U);
        product = product * of_joint[a].values[order][piece[a]];
      }
      out[v] = out[v] + product;
    }
  }
}

/// By what a joint follows others where it is no sum.
using Curve = std::variant<FourBarAngle, JointSpline>;

}  // namespace rivid
