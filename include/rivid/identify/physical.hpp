#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// How physically consistent standard parameters are looked for, see physical().
struct Physical {
  /// What tells, among all sets that explain the data as well, which one is wanted.
  enum class Prior {
    /// Log-det (Bregman) divergence of the pseudo-inertias from the robot description's P⁰ [Lee 2020]:
    /// Σ_j tr(P⁰_j⁻¹ P_j) − log det(P⁰_j⁻¹ P_j) − 4. It does not depend on frames and units, and keeps all masses and
    /// inertias away from zero.
    log_det,
    /// Its second-order part, ½ Σ_j ‖L_j⁻¹ (P_j − P⁰_j) L_j⁻ᵀ‖², P⁰_j = L_j L_jᵀ: a quadratic pull, which a body may
    /// follow down to nothing.
    ridge
  };
  struct MassBounds {
    std::string link;  ///< that moves, by its name in the robot description
    double least = 0.0;
    double most = std::numeric_limits<double>::infinity();  ///< [kg]
  };

  Prior prior = Prior::log_det;
  /// λ: a prior of 1 weighs as much as half a squared standard deviation of the estimate. At the default it decides what
  /// the data leave open and little else; hundreds and more hold weakly exciting data to the robot description.
  double weight = 1.0;
  /// Whether an identification lowers the weight by tens where the robot description is so far from the data that its pull
  /// would raise the residual sum of squares by more than a tenth, as placeholders in a URDF do.
  bool weight_may_fall = true;
  std::vector<MassBounds> masses = {};  ///< of single links
  std::optional<std::array<double, 2>> total_mass =
      {};  ///< of all moving links together, least and most [kg]

  Vector start =
      {};  ///< (N_s) to begin with; empty: the robot description. The answer does not depend on it.
  double tolerance = 1e-6;  ///< of the cost, relative to one and itself
  int max_steps = 500;      ///< of Newton's method

  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;
};

/// "log_det", "ridge".
[[nodiscard]] std::string_view name(Physical::Prior prior);

/// Standard parameters of a robot of physical bodies.
struct PhysicalParameters {
  Vector chi_st;                   ///< values of BaseParameters::standard, (N_s) [SI, joint side]
  Vector chi;                      ///< their base parameters, (b)
  double cost = 0.0;               ///< distance + weight × divergence
  double distance = 0.0;           ///< ½ ‖root (χ̂ − χ)‖²
  double divergence = 0.0;         ///< of the prior
  double gap = 0.0;                ///< that the cost is above the least one at most
  int steps = 0;                   ///< of Newton's method
  bool reached = true;             ///< whether the gap is within the tolerance
  std::vector<std::string> notes;  ///< links whose description belongs to no body, and what stands in for it
};

/// The physically consistent standard parameters nearest to an estimate of the base parameters:
///
///   min ½ ‖root (χ̂ − A χ_st)‖² + weight × prior(χ_st)
///
/// with A from the standard to the base parameters, Eqs. (4–6) of [RIV], over all χ_st whose pseudo_inertia() of every link
/// is positive definite, whose friction brakes and whose rotors have no negative inertia: Ia, Fv, Fc, Fv+, Fv−, Fc+ + Fc−,
/// Iam, Fvm, Fcm ≥ 0. (Fc+ and Fc− may be shifted by an offset; Fcm of Coulomb::single has either sign. Where a coupling
/// leaves the diagonal of its terms to the joints, Ia_i ≥ c_i² Iam and Fv_i ≥ c_i² Fvm.) Friction and rotors are pulled
/// to the robot description only where the data do not tell them.
///
/// The problem is convex. Newton's method on the logarithmic barrier of the constraints solves it; every iterate is
/// physical.
///
/// @param chi   estimate χ̂, (b)
/// @param root  any square root of its information, (m × b) with rootᵀ root = C_χχ⁻¹; without full rank where the data do
///              not determine everything
/// @throws InputError  the options' complaint(); where sizes differ or values are not finite
[[nodiscard]] PhysicalParameters physical(const Robot& robot, const BaseParameters& base,
                                          const Eigen::Ref<const Vector>& chi,
                                          const Eigen::Ref<const Matrix>& root, const Physical& options = {});

}  // namespace rivid
