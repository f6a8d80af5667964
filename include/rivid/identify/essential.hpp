#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Which parameters an estimate can do without, see essential().
struct Essential {
  /// Probability of keeping a parameter that is zero: a parameter is removed if the F-test does not reject
  /// its removal at this significance level.
  double significance = 0.05;

  [[nodiscard]] std::optional<std::string> complaint() const;

  template <typename R = Essential>
  static constexpr auto fields() {
    return std::tuple(Field{"significance",
                            &R::significance,
                            "significance level: a removal whose F-test gives a smaller p is refused",
                            {.range = Range::within(0.0, 1.0)}});
  }
};

/// A parameter that was eliminated.
struct EliminatedParameter {
  std::string name;
  double F = 0.0;  ///< of its removal from those that were left then, 1 degree of freedom in the numerator
  double p = 0.0;  ///< probability of more, if the parameter is zero

  template <typename R = EliminatedParameter>
  static constexpr auto fields() {
    return std::tuple(Field{"name", &R::name, "of the parameter"},
                      Field{"F", &R::F, "of its removal", {.unit = "1"}},
                      Field{"p", &R::p, "probability of more, if the parameter is zero", {.unit = "1"}});
  }
};

/// The parameters that matter.
struct EssentialParameters {
  Vector chi;                                   ///< (b); zero where eliminated
  Matrix from;                                  ///< (b × b): chi = from χ̂, of which chi has its covariance
  Matrix C_chi;                                 ///< (b × b) covariance, zero where eliminated
  std::vector<Index> kept;                      ///< indices of base parameters, ascending
  std::vector<EliminatedParameter> eliminated;  ///< in the order of their removal
  /// Parameters that the test would let go, but without which M(q) would not be positive definite.
  std::vector<std::string> held;
  double F = 0.0;  ///< of all removals together
  double p = 1.0;

  template <typename R = EssentialParameters>
  static constexpr auto fields() {
    return std::tuple(
        Field{"parameters",
              nullptr,
              "those that stay, each with `name`, `value`, `sigma`, `relative_sigma_percent`",
              {.unit = "SI"}},
        Field{"eliminated", &R::eliminated,
              "those that went, in the order of their removal, each with the `F` and `p` of that removal"},
        Field{"held", &R::held,
              "names of those that would have gone, but M(q) would not be positive definite without them"},
        Field{"F", &R::F, "of all removals together", {.unit = "1"}},
        Field{"p", &R::p, "the same as a probability", {.unit = "1"}},
        Field{"significance", nullptr, "below which p a removal is refused", {.unit = "1"}},
        Field{"fit", nullptr,
              "of these parameters on the rows of the identification, members as in "
              "[`validation`](#fit-and-each-of-validation)"});
  }
};

/// Backward elimination of parameters that the data do not need [Khalil 2007]: again and again the one with
/// the largest relative standard deviation is taken out and the others are fitted anew, as long as neither
/// this removal nor all together raise the loss ‖root (χ̂ − χ)‖² significantly, by an F-test. No row is
/// looked at again.
///
/// The physics stays: the leading inertia of a joint (see regular_start()) is never removed, and a removal
/// that makes M(q) lose its positive definiteness along the motion is taken back, where the estimate itself
/// had it.
///
/// The F-test takes the errors of rows for independent; C_χ need not.
///
/// @param chi      estimate χ̂, (b), all determined
/// @param C_chi    its covariance, (b × b)
/// @param root     square root of its information for independent errors, (b × b) with full rank: R / σ of
///                 least squares, R_VW / σ of instrumental variables, where the loss is that of the equations
///                 projected onto the instruments
/// @param freedom  rows without parameters, positive
/// @param q        motions that M(q) is looked at along, each (n_m × n) [rad | m]
/// @throws InputError  the options' complaint(); where sizes differ, values are not finite or freedom is not
///                     positive
[[nodiscard]] EssentialParameters essential(const Robot& robot, const BaseParameters& base,
                                            const Eigen::Ref<const Vector>& chi,
                                            const Eigen::Ref<const Matrix>& C_chi,
                                            const Eigen::Ref<const Matrix>& root, double freedom,
                                            std::span<const Matrix> q, const Essential& options = {});

}  // namespace rivid
