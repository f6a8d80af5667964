#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>
#include <type_traits>

#include "rivid/fields.hpp"

// All that is known of a parameter kind, of a function of friction and of a friction law, one row each:
// whoever needs to know something of a kind asks its row. The vector kernels include this file: nothing here
// may come from Eigen, and what they call must be a template on their Scalar.
namespace rivid {

/// One of two values, without a branch where Scalar holds several samples (see Pack).
template <typename Scalar>
[[nodiscard, gnu::always_inline]] inline Scalar select(bool condition, const Scalar& a, const Scalar& b) {
  return condition ? a : b;
}

/// Whether a velocity is positive; of a complex number (complex step), its real part.
template <typename Scalar>
[[nodiscard, gnu::always_inline]] inline auto is_positive(const Scalar& x) {
  if constexpr (requires { x > Scalar(0.0); }) {
    return x > Scalar(0.0);
  } else {
    return x.real() > 0.0;
  }
}

/// sign of a velocity with sign(0) = 0, as the Coulomb columns need it.
template <typename Scalar>
[[nodiscard, gnu::always_inline]] inline Scalar sign(const Scalar& qd) {
  const Scalar zero(0.0);
  return select(is_positive(qd), Scalar(1.0), select(is_positive(Scalar(-qd)), Scalar(-1.0), zero));
}

/// The same, or what stands in its place: tanh(q̇ / sign_speed).
///
/// @param sign_speed  Joint::sign_speed [rad/s | m/s]; 0: the sign itself
template <typename Scalar>
[[nodiscard, gnu::always_inline]] inline Scalar sign(const Scalar& qd, double sign_speed) {
  if (sign_speed == 0.0) {
    return sign(qd);
  }
  using std::tanh;
  return tanh(Scalar(qd / Scalar(sign_speed)));
}

enum class JointType { revolute, prismatic };

/// What a standard parameter stands for, Eq. (3) of [RIV]; the four with a direction are asymmetric friction,
/// Iam, Fvm and Fcm belong to a motor that several joints turn, see Coupling. Fl is friction in proportion to
/// the load of the gear, Fr friction that grows with the square root of the speed.
enum class ParameterKind {
  XX,
  XY,
  XZ,
  YY,
  YZ,
  ZZ,
  MX,
  MY,
  MZ,
  M,
  Ia,
  Fv,
  Fc,
  off,
  Fv_plus,
  Fc_plus,
  Fv_minus,
  Fc_minus,
  Iam,
  Fvm,
  Fcm,
  Fl,
  Fr
};

/// What a parameter does in the torque of a joint.
enum class Role {
  inertial,  ///< of a link's body
  rotor,     ///< inertia of what a motor turns
  viscous,   ///< friction that grows with the speed, from nothing at rest
  dry,       ///< friction that jumps with the direction of motion, and holds at rest
  constant   ///< whatever the motion
};

/// Function that a parameter is multiplied with in the torque of its joint: φ(q̇) of friction.
enum class Basis {
  body,          ///< of the links' motion, see RegressorColumns
  acceleration,  ///< q̈
  speed,         ///< q̇
  sign,          ///< sign q̇
  one,           ///< 1
  load,          ///< sign q̇, times |τ_load| of the joint, see rivid/regressor/load.hpp
  root           ///< √|q̇| sign q̇ but for |q̇| near v = root_speed: q̇ / (q̇² + v²)^¼
};

/// What keeps the slope of Basis::root finite at rest [rad/s | m/s].
inline constexpr double root_speed = 1e-3;

/// Velocities for which a parameter is in the torque at all; at rest both directions are silent.
enum class Direction { both, positive, negative };

/// Least value of a parameter of a robot that exists.
enum class Bound {
  none,      ///< of either sign, or bounded by the physics of a body
  zero,      ///< not negative
  mean_zero  ///< the mean of both directions is not negative: an offset may shift the two
};

/// Where the a-priori value of a parameter is found: Robot::inertials, or the member of Joint or Coupling.
enum class APriori { inertials, Ia, Fv, Fc, Iam, Fvm, Fcm, zero };

/// SI units on the joint side.
struct JointUnit {
  std::string_view revolute;
  std::string_view prismatic;
};

struct BasisRow {
  Basis basis;
  Role role;
};

inline constexpr std::array basis_rows = {
    BasisRow{Basis::body, Role::inertial},       //
    BasisRow{Basis::acceleration, Role::rotor},  //
    BasisRow{Basis::speed, Role::viscous},       //
    BasisRow{Basis::sign, Role::dry},            //
    BasisRow{Basis::one, Role::constant},        //
    BasisRow{Basis::load, Role::dry},            //
    BasisRow{Basis::root, Role::viscous},
};

/// φ of friction, of a speed and of its sign: ±1 or 0, or tanh(speed / v_s) where it is smooth. Which of the
/// two is meant where the speed is zero, the sign says. Of Basis::load it is what |τ_load| is multiplied
/// with.
template <typename Scalar>
[[nodiscard, gnu::always_inline]] inline Scalar friction_function(Basis basis, const Scalar& speed,
                                                                  const Scalar& sign) {
  switch (basis) {
    case Basis::body:
    case Basis::acceleration:
      break;
    case Basis::speed:
      return speed;
    case Basis::sign:
      return sign;
    case Basis::one:
      return Scalar(1.0);
    case Basis::load:
      return sign;
    case Basis::root: {
      using std::sqrt;
      return speed / sqrt(Scalar(sqrt(Scalar(speed * speed + Scalar(root_speed * root_speed)))));
    }
  }
  return Scalar(0.0);
}

struct KindRow {
  ParameterKind kind;
  std::string_view symbol;
  JointUnit unit;
  Basis basis;
  Bound bound = Bound::none;
  APriori a_priori = APriori::zero;
  Direction direction = Direction::both;
  bool coupled = false;  ///< of a motor that several joints turn
};

namespace detail {

inline constexpr JointUnit inertia_unit = {"kg·m²", "kg·m²"};
inline constexpr JointUnit moment_unit = {"kg·m", "kg·m"};
inline constexpr JointUnit mass_unit = {"kg", "kg"};
inline constexpr JointUnit rotor_unit = {"kg·m²", "kg"};
inline constexpr JointUnit viscous_unit = {"N·m·s/rad", "N·s/m"};
inline constexpr JointUnit torque_unit = {"N·m", "N"};
inline constexpr JointUnit ratio_unit = {"1", "1"};
inline constexpr JointUnit root_unit = {"N·m·(s/rad)^½", "N·(s/m)^½"};

constexpr KindRow inertial_row(ParameterKind kind, std::string_view symbol, JointUnit unit) {
  return {kind, symbol, unit, Basis::body, Bound::none, APriori::inertials};
}

}  // namespace detail

inline constexpr auto kind_rows = [] {
  using enum ParameterKind;
  using namespace detail;
  constexpr auto plus = Direction::positive;
  constexpr auto minus = Direction::negative;
  constexpr auto both = Direction::both;
  return std::to_array<KindRow>({
      inertial_row(XX, "XX", inertia_unit),
      inertial_row(XY, "XY", inertia_unit),
      inertial_row(XZ, "XZ", inertia_unit),
      inertial_row(YY, "YY", inertia_unit),
      inertial_row(YZ, "YZ", inertia_unit),
      inertial_row(ZZ, "ZZ", inertia_unit),
      inertial_row(MX, "MX", moment_unit),
      inertial_row(MY, "MY", moment_unit),
      inertial_row(MZ, "MZ", moment_unit),
      inertial_row(M, "M", mass_unit),
      {Ia, "Ia", rotor_unit, Basis::acceleration, Bound::zero, APriori::Ia},
      {Fv, "Fv", viscous_unit, Basis::speed, Bound::zero, APriori::Fv},
      {Fc, "Fc", torque_unit, Basis::sign, Bound::zero, APriori::Fc},
      {off, "off", torque_unit, Basis::one},
      {Fv_plus, "Fv+", viscous_unit, Basis::speed, Bound::zero, APriori::Fv, plus},
      {Fc_plus, "Fc+", torque_unit, Basis::sign, Bound::mean_zero, APriori::Fc, plus},
      {Fv_minus, "Fv-", viscous_unit, Basis::speed, Bound::zero, APriori::Fv, minus},
      {Fc_minus, "Fc-", torque_unit, Basis::sign, Bound::mean_zero, APriori::Fc, minus},
      {Iam, "Iam", rotor_unit, Basis::acceleration, Bound::zero, APriori::Iam, both, true},
      {Fvm, "Fvm", viscous_unit, Basis::speed, Bound::zero, APriori::Fvm, both, true},
      {Fcm, "Fcm", torque_unit, Basis::sign, Bound::zero, APriori::Fcm, both, true},
      {Fl, "Fl", ratio_unit, Basis::load, Bound::zero},
      {Fr, "Fr", root_unit, Basis::root, Bound::zero},
  });
}();

/// Friction law of a joint: which parameters it has. The torque is linear in all of them but Fl, whose
/// |τ_load| is that of the other parameters.
enum class Friction {
  none,        ///< no friction
  viscous,     ///< τ = Fv q̇
  coulomb,     ///< τ = Fv q̇ + Fc sign q̇
  symmetric,   ///< τ = Fv q̇ + Fc sign q̇ + off, the law of Eq. (3) of [RIV]
  asymmetric,  ///< τ = Fv± q̇ + Fc± sign q̇, by the sign of q̇
  load,        ///< τ = Fv q̇ + (Fc + Fl |τ_load|) sign q̇ + off
  root,        ///< τ = Fv q̇ + Fr √|q̇| sign q̇ + Fc sign q̇ + off
  load_root,   ///< both of them: τ = Fv q̇ + Fr √|q̇| sign q̇ + (Fc + Fl |τ_load|) sign q̇ + off
  automatic    ///< one of symmetric, root, load and load_root that choose_friction() puts in its place; until
               ///< then the first
};

struct FrictionRow {
  Friction law;
  std::string_view name;                      ///< in files
  std::span<const ParameterKind> parameters;  ///< in the order of the standard vector
};

namespace detail {
template <ParameterKind... kinds>
inline constexpr std::array<ParameterKind, sizeof...(kinds)> list = {kinds...};
}

inline constexpr auto friction_rows = [] {
  using enum ParameterKind;
  return std::to_array<FrictionRow>({
      {Friction::none, "none", {}},
      {Friction::viscous, "viscous", detail::list<Fv>},
      {Friction::coulomb, "coulomb", detail::list<Fv, Fc>},
      {Friction::symmetric, "symmetric", detail::list<Fv, Fc, off>},
      {Friction::asymmetric, "asymmetric", detail::list<Fv_plus, Fc_plus, Fv_minus, Fc_minus>},
      {Friction::load, "load", detail::list<Fv, Fc, off, Fl>},
      {Friction::root, "root", detail::list<Fv, Fc, off, Fr>},
      {Friction::load_root, "load_root", detail::list<Fv, Fc, off, Fl, Fr>},
      {Friction::automatic, "auto", detail::list<Fv, Fc, off>},
  });
}();

static_assert(detail::complete<basis_rows, &BasisRow::basis>(), "one row for each Basis, in its order");
static_assert(detail::complete<kind_rows, &KindRow::kind>(), "one row for each ParameterKind, in its order");
static_assert(detail::complete<friction_rows, &FrictionRow::law>(),
              "one row for each Friction, in its order");

[[nodiscard]] constexpr const BasisRow& about(Basis basis) {
  return basis_rows[static_cast<std::size_t>(basis)];
}
[[nodiscard]] constexpr const KindRow& about(ParameterKind kind) {
  return kind_rows[static_cast<std::size_t>(kind)];
}
[[nodiscard]] constexpr const FrictionRow& about(Friction law) {
  return friction_rows[static_cast<std::size_t>(law)];
}

[[nodiscard]] constexpr Role role(ParameterKind kind) { return about(about(kind).basis).role; }
[[nodiscard]] constexpr bool is_friction(ParameterKind kind) {
  return role(kind) != Role::inertial && role(kind) != Role::rotor;
}

/// "XX", "Ia", "Fv+", …
[[nodiscard]] constexpr std::string_view symbol(ParameterKind kind) { return about(kind).symbol; }

/// SI unit of a parameter of that kind on the joint side: "kg·m²", "N·m·s/rad", …
[[nodiscard]] constexpr std::string_view unit(ParameterKind kind, JointType type) {
  return type == JointType::revolute ? about(kind).unit.revolute : about(kind).unit.prismatic;
}

/// Whether a law has a parameter of some function.
[[nodiscard]] constexpr bool has(Friction law, Basis basis) {
  for (const ParameterKind kind : about(law).parameters) {
    if (about(kind).basis == basis) {
      return true;
    }
  }
  return false;
}

/// "none", "viscous", "coulomb", "symmetric", "asymmetric", …
[[nodiscard]] constexpr std::string_view name(Friction law) { return about(law).name; }

/// Parameters of a law, in the order of the standard vector.
[[nodiscard]] constexpr std::span<const ParameterKind> parameters(Friction law) {
  return about(law).parameters;
}

/// Regressor entry of one friction parameter: what it is multiplied with in the torque of its joint.
///
/// @param qd          joint velocity [rad/s | m/s]
/// @param sign_speed  Joint::sign_speed [rad/s | m/s]
template <typename Scalar>
[[nodiscard, gnu::always_inline]] inline Scalar friction_entry(Basis basis, Direction direction,
                                                               const Scalar& qd, double sign_speed) {
  const Scalar zero(0.0);
  // The commonest column does without a sign, which costs more than all else here.
  const Scalar value = basis == Basis::speed ? qd : friction_function(basis, qd, sign(qd, sign_speed));
  switch (direction) {
    case Direction::both:
      break;
    case Direction::positive:
      return select(is_positive(qd), value, zero);
    case Direction::negative:
      return select(is_positive(Scalar(-qd)), value, zero);
  }
  return value;
}
template <typename Scalar>
[[nodiscard]] Scalar friction_entry(ParameterKind kind, const Scalar& qd, double sign_speed = 0.0) {
  return friction_entry(about(kind).basis, about(kind).direction, qd, sign_speed);
}

}  // namespace rivid
