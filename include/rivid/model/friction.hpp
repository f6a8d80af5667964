#pragma once

#include <cmath>
#include <span>
#include <string_view>

#include "rivid/model/parameters.hpp"

namespace rivid {

/// Friction law of a joint: which parameters its torque is linear in.
enum class Friction {
  none,       ///< no friction
  viscous,    ///< τ = Fv q̇
  coulomb,    ///< τ = Fv q̇ + Fc sign q̇
  symmetric,  ///< τ = Fv q̇ + Fc sign q̇ + off, the law of Eq. (3) of [RIV]
  asymmetric  ///< τ = Fv± q̇ + Fc± sign q̇, by the sign of q̇
};

/// Parameters of a law, in the order of the standard vector.
[[nodiscard]] std::span<const ParameterKind> parameters(Friction law);

/// "none", "viscous", "coulomb", "symmetric", "asymmetric".
[[nodiscard]] std::string_view name(Friction law);

/// One of two values, without a branch where Scalar holds several samples (see Pack).
template <typename Scalar>
[[nodiscard]] Scalar select(bool condition, const Scalar& a, const Scalar& b) {
  return condition ? a : b;
}

/// sign of a velocity with sign(0) = 0, as the Coulomb columns need it.
template <typename Scalar>
[[nodiscard]] Scalar sign(const Scalar& qd) {
  const Scalar zero(0);
  return select(qd > zero, Scalar(1), select(qd < zero, Scalar(-1), zero));
}

/// The same, or what stands in its place: tanh(q̇ / sign_speed).
///
/// @param sign_speed  Joint::sign_speed [rad/s | m/s]; 0: the sign itself
template <typename Scalar>
[[nodiscard]] Scalar sign(const Scalar& qd, double sign_speed) {
  if (sign_speed == 0.0) {
    return sign(qd);
  }
  using std::tanh;
  return tanh(Scalar(qd / Scalar(sign_speed)));
}

/// Regressor entry of one friction parameter: what it is multiplied with in the torque of its joint.
///
/// @param qd          joint velocity [rad/s | m/s]; at rest both directions of the asymmetric law are silent
/// @param sign_speed  Joint::sign_speed [rad/s | m/s]
template <typename Scalar>
[[nodiscard]] Scalar friction_entry(ParameterKind kind, const Scalar& qd, double sign_speed = 0.0) {
  const Scalar zero(0);
  switch (kind) {
    case ParameterKind::Fv:
      return qd;
    case ParameterKind::Fc:
      return sign(qd, sign_speed);
    case ParameterKind::off:
      return Scalar(1);
    case ParameterKind::Fv_plus:
      return select(qd > zero, qd, zero);
    case ParameterKind::Fv_minus:
      return select(qd < zero, qd, zero);
    case ParameterKind::Fc_plus:
      return select(qd > zero, sign(qd, sign_speed), zero);
    case ParameterKind::Fc_minus:
      return select(qd < zero, sign(qd, sign_speed), zero);
    default:
      return zero;
  }
}

}  // namespace rivid
