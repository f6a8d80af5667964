#pragma once

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

/// Regressor entry of one friction parameter: what it is multiplied with in the torque of its joint.
///
/// @param qd  joint velocity [rad/s | m/s]; at rest both directions of the asymmetric law are silent
template <typename Scalar>
[[nodiscard]] Scalar friction_entry(ParameterKind kind, const Scalar& qd) {
  const Scalar zero(0);
  switch (kind) {
    case ParameterKind::Fv:
      return qd;
    case ParameterKind::Fc:
      return sign(qd);
    case ParameterKind::off:
      return Scalar(1);
    case ParameterKind::Fv_plus:
      return select(qd > zero, qd, zero);
    case ParameterKind::Fv_minus:
      return select(qd < zero, qd, zero);
    case ParameterKind::Fc_plus:
      return select(qd > zero, Scalar(1), zero);
    case ParameterKind::Fc_minus:
      return select(qd < zero, Scalar(-1), zero);
    default:
      return zero;
  }
}

}  // namespace rivid
