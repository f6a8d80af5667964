#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// One base parameter: a standard parameter, and those that move the robot in no other way than it does.
struct BaseParameter {
  StandardParameter leading;
  std::string name;       ///< "ZZ1R", with R where something is regrouped into it; else "MX2"
  std::string regrouped;  ///< "ZZ1 + Ia1 + 0.25 M2"; the name itself where nothing is
  std::string unit;       ///< SI, joint side
};

/// Where the torques of a robot are linearised whose friction follows the load (Friction::load): all else is
/// linear as it is.
struct LoadPoint {
  /// (b) parameters that |τ_load| is computed with; empty: none, as for robots without such friction
  Vector chi;
  /// (n) If set, rows are those of Gauss-Newton's step, whose least-squares solution is the next estimate and
  /// whose covariance knows that the load is an estimate too: the columns of M q̈ + N are multiplied with 1 +
  /// Fl g sign q̇ and Fl g τ_load sign q̇ is added to the torque, with Fl of `chi` and g = τ_load / √(τ_load²
  /// + width²), the sign of the load without its jump [N·m | N].
  std::optional<Vector> width;
};

/// Base parameters of a robot, Eqs. (4–6) of [RIV]: the b ≤ N_s combinations of the standard parameters that
/// the torques can show at all.
struct BaseParameters {
  std::vector<BaseParameter> parameters;    ///< (b), in the order of the standard parameters that lead them
  std::vector<StandardParameter> standard;  ///< (N_s)
  std::vector<Index> leading;               ///< (b) indices into standard, ascending
  std::vector<Index> dependent;             ///< (N_s − b) the others
  Matrix K;                                 ///< (b × N_s − b): χ = χ_leading + K χ_dependent
  LoadPoint load;                           ///< of friction that follows the load

  /// The rank decision: the smallest part of a kept column that was independent of the columns before it, and
  /// the largest of a dropped one, both relative to the largest column of the same unit. A clear decision
  /// lies many decades between them.
  double smallest_kept = 1.0;
  double largest_dropped = 0.0;
  Index weakest_kept = -1;       ///< column of smallest_kept, an index into standard; −1 where none is
  Index strongest_dropped = -1;  ///< column of largest_dropped

  [[nodiscard]] Index size() const { return static_cast<Index>(parameters.size()); }

  /// What shows that they are those of another robot, or of other friction laws.
  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  /// smallest_kept / largest_dropped, the latter taken as one rounding error at least.
  [[nodiscard]] double rank_gap() const;

  /// A warning that names the columns between which the line was drawn: where rank_gap() lies below 100, and
  /// where smallest_kept lies below 0.01, as rounded angles in a robot description make it.
  [[nodiscard]] std::optional<std::string> doubt() const;

  /// Leading standard parameters in the order of `parameters`: the columns of the base regressor.
  [[nodiscard]] std::vector<StandardParameter> columns() const;

  /// Standard parameters that make up base parameter i with their coefficients, the leading one first.
  [[nodiscard]] std::vector<std::pair<std::string, double>> regrouping(Index i) const;

  /// χ of Eq. (6) from standard parameters, (N_s) → (b).
  [[nodiscard]] Vector from_standard(const Eigen::Ref<const Vector>& chi_st) const;

  /// One standard vector with these base parameters, (b) → (N_s): the regrouped values in the places of the
  /// leading parameters and zero elsewhere. It gives the right torques, though no link need be a physical
  /// body.
  [[nodiscard]] Vector to_standard(const Eigen::Ref<const Vector>& chi) const;

  /// Basis Z of what the torques can not show, (N_s × N_s − b): all standard vectors with base parameters χ
  /// are to_standard(χ) + Z z. Column i stands for the dependent parameter i: one there, and what it takes
  /// off the leading parameters that it is regrouped into, so that Z is −K in the rows `leading`, 1 in the
  /// rows `dependent`.
  [[nodiscard]] Matrix null_space() const;
};

struct BaseParametersOptions {
  int samples = 60;           ///< random states
  std::uint64_t seed = 1991;  ///< of std::mt19937_64

  [[nodiscard]] std::optional<std::string> complaint() const;
};

/// Base parameters by the numerical method of Gautier (1991): IDM_st at random states is factored by
/// Householder QR, the columns scanned in the order that keeps the parameters of the closed-form rules of
/// Gautier & Khalil (1990): XX XY XZ YZ ZZ MX MY of links 1…n, YY MZ M of links 1…n, then rotor inertias,
/// then those of coupled motors, then friction, then that of coupled motors. A column is dependent where the
/// part of it that is independent of those kept is at most Robot::base_tolerance times the largest column of
/// the same unit.
///
/// @throws InputError where the robot or an option can not be used
[[nodiscard]] BaseParameters base_parameters(const Robot& robot, const BaseParametersOptions& options = {});

namespace detail {

// Coefficients of K of which so little is seen that they are no part of a regrouping's name.
enum class SmallCoefficients {
  kept,    // for the torques
  dropped  // they are noise
};

// From IDM_st at some states, or its triangular factor: columns are those of Robot::standard_parameters(). No
// parameter at all where nothing is seen.
[[nodiscard]] BaseParameters base_of(const Robot& robot, const Matrix& W, double tolerance,
                                     SmallCoefficients small);

// Columns of a robot and of a body on its last link: the base parameters, and behind them those of the ten
// inertial parameters of the last link that lead none.
struct BodyColumns {
  // On the last link of a chain.
  BodyColumns(const Robot& robot, const BaseParameters& base)
      : BodyColumns(static_cast<int>(robot.size()) - 1, base) {
    require_chain("a body on the last link", robot.chain);
  }
  // link: that the body is on, counted from 0
  BodyColumns(int link, const BaseParameters& base) : all(base) {
    for (int k = 0; k < inertial_count; ++k) {
      const StandardParameter wanted = {static_cast<ParameterKind>(k), link};
      const auto at = std::ranges::find_if(all.parameters, [&](const BaseParameter& p) {
        return p.leading.kind == wanted.kind && p.leading.joint == wanted.joint;
      });
      body[static_cast<std::size_t>(k)] = at - all.parameters.begin();
      if (at == all.parameters.end()) {
        all.parameters.push_back({wanted, wanted.name(), wanted.name(), ""});
      }
    }
  }

  BaseParameters all;
  std::array<Index, inertial_count> body{};  // where XX … M of the link stand
};

}  // namespace detail

}  // namespace rivid

#ifdef RIVID_DEFINITIONS
#include "rivid/regressor/base_inline.hpp"
#endif
