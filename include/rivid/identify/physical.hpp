#pragma once

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// How physically consistent standard parameters are looked for, see physical().
struct Physical {
  /// Which of all sets that explain the data equally well is chosen.
  enum class Prior {
    /// Log-det (Bregman) divergence of the pseudo-inertias from the robot description's P⁰ [Lee 2020]: Σ_j
    /// tr(P⁰_j⁻¹ P_j) − log det(P⁰_j⁻¹ P_j) − 4. It does not depend on frames and units, and keeps all masses
    /// and inertias away from zero.
    log_det,
    /// Its second-order part, ½ Σ_j ‖L_j⁻¹ (P_j − P⁰_j) L_j⁻ᵀ‖², P⁰_j = L_j L_jᵀ: a quadratic pull, which a
    /// body may follow down to nothing.
    ridge
  };
  struct MassBounds {
    std::string link;  ///< that moves, by its name in the robot description
    double least = 0.0;
    double most = std::numeric_limits<double>::infinity();  ///< [kg]
  };

  Prior prior = Prior::log_det;
  /// λ: a prior of 1 weighs as much as half a squared standard deviation of the estimate. At the default it
  /// decides what the data leave open and little else; hundreds and more hold weakly exciting data to the
  /// robot description.
  double weight = 1.0;
  /// Whether an identification lowers the weight by tens where the robot description is so far from the data
  /// that its pull would raise the residual sum of squares by more than a tenth, as placeholders in a URDF
  /// do.
  bool weight_may_fall = true;
  std::vector<MassBounds> masses = {};  ///< of single links
  std::optional<std::array<double, 2>> total_mass =
      {};  ///< of all moving links together, least and most [kg]

  Vector start =
      {};  ///< (N_s) to begin with; empty: the robot description. The answer does not depend on it.
  double tolerance = 1e-6;  ///< of the cost, relative to one and itself
  int max_steps = 500;      ///< of Newton's method

  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  /// Least and most mass of links by their names.
  [[nodiscard]] std::map<std::string, std::array<double, 2>> masses_by_link() const {
    std::map<std::string, std::array<double, 2>> out;
    for (const MassBounds& bounds : masses) {
      out[bounds.link] = {bounds.least, bounds.most};
    }
    return out;
  }

  template <typename P = Physical>
  static constexpr auto fields() {
    return std::tuple(
        Field{"prior", &P::prior,
              "distance from the robot description: `\"log_det\"`, which keeps masses positive, or "
              "`\"ridge\"`, "
              "its quadratic part"},
        Field{"weight",
              &P::weight,
              "of the prior, against half the squared deviations of the fit; 10 to 1000 hold weakly exciting "
              "data to the description",
              {.range = Range::above(0.0, 1e12)}},
        Field{"weight_may_fall",
              &P::weight_may_fall,
              "whether the weight is lowered by tens where it would cost more than a tenth of the residual "
              "sum of squares",
              {.otherwise = "`true` without `weight`"}},
        Field{"masses",
              [](const P& p) { return p.masses_by_link(); },
              "bounds of the masses of single links by their name: `masses = { link_2 = [10, 25] }`",
              {.otherwise = "–", .unit = "kg"}},
        Field{"total_mass",
              &P::total_mass,
              "bounds of the mass of all moving links together",
              {.otherwise = "–", .unit = "kg", .must_be = "[least, most] in kg"}},
        Field{"tolerance",
              &P::tolerance,
              "of the cost, relative to 1 + cost",
              {.range = Range::from(1e-15, 1.0)}},
        Field{"max_steps", &P::max_steps, "of Newton's method", {.range = Range::from(1, 1e5)}});
  }
};

template <>
inline constexpr std::array names_of<Physical::Prior> = std::to_array<std::string_view>({"log_det", "ridge"});

/// Standard parameters of a robot of physical bodies.
struct PhysicalParameters {
  Vector chi_st;  ///< values of BaseParameters::standard, (N_s) [SI, joint side]
  Vector chi;     ///< their base parameters, (b)
  /// What is open of `chi` because the prior decided it, (b × b): the prior is off by as much as it is where
  /// the data tell [MacKay 1992]. Infinite for friction and rotors that nothing shows.
  Matrix C_prior;
  double cost = 0.0;               ///< distance + weight × divergence
  double distance = 0.0;           ///< ½ ‖root (χ̂ − χ)‖²
  double divergence = 0.0;         ///< of the prior
  double gap = 0.0;                ///< that the cost is above the least one at most
  int steps = 0;                   ///< of Newton's method
  bool reached = true;             ///< whether the gap is within the tolerance
  std::vector<std::string> notes;  ///< links with a physically inconsistent description, and what replaces it

  template <typename R = PhysicalParameters>
  static constexpr auto fields() {
    return std::tuple(
        Field{"links", nullptr,
              "base to tip, each with `link`, `joint`, and `parameters`: all standard parameters in the "
              "order of (3), each with `name`, `value`, `unit`, `a_priori`"},
        Field{"chi", &R::chi, "their base parameters, in the order of `parameters`", {.unit = "SI"}},
        Field{"fit", nullptr,
              "the model on the rows of the identification, members as in "
              "[`validation`](#fit-and-each-of-validation)"},
        Field{"options", nullptr, "[`[method.physical]`](experiment.md#methodphysical) as it was used"},
        Field{"better", nullptr,
              "whether left-out blocks of time are predicted better than by `parameters`, or these are not "
              "all determined: then this set is the answer"},
        Field{"sigma",
              nullptr,
              "deviations of `chi` by these blocks and by what the prior decided; empty where the blocks "
              "can not say",
              {.unit = "SI"}},
        Field{"C_chi", nullptr, "their covariance, by rows; empty where `sigma` is", {.unit = "SI²"}},
        Field{"cost", &R::cost, "distance + weight × divergence", {.unit = "1"}},
        Field{"distance", &R::distance, "½ (χ̂ − χ)ᵀ C_χχ⁻¹ (χ̂ − χ)", {.unit = "1"}},
        Field{"divergence", &R::divergence, "of the prior", {.unit = "1"}},
        Field{"gap", &R::gap, "what the cost is above the least one at most", {.unit = "1"}},
        Field{"steps", &R::steps, "Newton steps"},
        Field{"reached", &R::reached, "whether the gap is within 1e-6 of (1 + cost)"});
  }
};

/// The physically consistent standard parameters nearest to an estimate of the base parameters:
///
///   min ½ ‖root (χ̂ − A χ_st)‖² + weight × prior(χ_st)
///
/// with A from the standard to the base parameters, Eqs. (4–6) of [RIV], over all χ_st whose pseudo_inertia()
/// of every link is positive definite, whose friction brakes and whose rotors have no negative inertia: Ia,
/// Fv, Fc, Fv+, Fv−, Fc+ + Fc−, Iam, Fvm, Fcm ≥ 0. (Fc+ and Fc− may be shifted by an offset; Fcm of
/// Coulomb::single has either sign. Where a coupling leaves the diagonal of its terms to the joints, Ia_i ≥
/// c_i² Iam and Fv_i ≥ c_i² Fvm.) Friction and rotors are pulled to the robot description as if each were
/// known to make as much torque as all parameters together, which decides only what the data leave open.
///
/// The problem is convex. Newton's method on the logarithmic barrier of the constraints solves it; every
/// iterate is physical.
///
/// @param chi   estimate χ̂, (b)
/// @param root  any square root of its information, (m × b) with rootᵀ root = C_χχ⁻¹; without full rank where
///              the data do not determine everything
/// @throws InputError  the options' complaint(); where sizes differ or values are not finite
[[nodiscard]] PhysicalParameters physical(const Robot& robot, const BaseParameters& base,
                                          const Eigen::Ref<const Vector>& chi,
                                          const Eigen::Ref<const Matrix>& root, const Physical& options = {});

}  // namespace rivid
