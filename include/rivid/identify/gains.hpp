#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rivid/data/log.hpp"
#include "rivid/fields.hpp"
#include "rivid/finding.hpp"
#include "rivid/identify/estimation.hpp"
#include "rivid/model/robot.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// The drive gain of one joint, from logs.
struct GainEstimate {
  std::string joint;
  double nominal =
      0.0;  ///< joint-side torque per unit of the control signal, as the robot has it: Joint::g_tau()
  double value = 0.0;
  double sigma = 0.0;  ///< infinite where the logs do not determine it
  std::array<double, 2> interval_95 = {0.0, 0.0};
  /// Whether the interval is narrower than ±30 % of the value: a joint that the load does not move is not
  /// identifiable.
  bool identifiable = false;

  template <typename G = GainEstimate>
  static constexpr auto fields() {
    return std::tuple(
        Field{"joint", &G::joint, "its name"},
        Field{"nominal",
              &G::nominal,
              "gain of the experiment file with gears, on the joint side",
              {.unit = "N·m, N a unit of `control`"}},
        Field{"value", &G::value, "estimate", {.unit = "as `nominal`"}},
        Field{"sigma",
              &G::sigma,
              "its standard deviation; null where the logs do not determine it",
              {.unit = "as `nominal`"}},
        Field{"interval_95", &G::interval_95, "its 95 % confidence interval", {.unit = "as `nominal`"}},
        Field{"identifiable", &G::identifiable,
              "whether the interval is narrower than ±30 % of the value; else `nominal` is used"});
  }
};

/// What is known of the drive gains when they are estimated.
struct GainOptions {
  /// Relative standard deviations of the gains that are known, by the names of the joints; 0: exact.
  std::map<std::string, double> known = {};
  std::optional<double> mass = {};  ///< of the payload of the logs with one [kg]
  double mass_sigma = 0.0;          ///< its standard deviation [kg]

  [[nodiscard]] std::optional<std::string> complaint(const Robot& robot) const;

  template <typename O = GainOptions>
  static constexpr auto fields() {
    return std::tuple(Field{"known",
                            &O::known,
                            "relative standard deviation by joint, 0 for exact: `known = { joint_2 = 0.01 }`",
                            {.otherwise = "none is known", .unit = "1", .range = gain_sigma_range}},
                      Field{"mass",
                            &O::mass,
                            "of the payload in the logs of `loaded`",
                            {.otherwise = "–", .unit = "kg", .range = Range::above(0.0, 1e6)}},
                      Field{"mass_sigma",
                            &O::mass_sigma,
                            "its standard deviation",
                            {.unit = "kg", .range = Range::from(0.0, 1e6)}});
  }
};

/// Drive gains that were estimated from logs.
struct [[nodiscard]] GainReport {
  bool identified = false;  ///< whether the fit settled; else all gains stay nominal
  std::string scale;        ///< a sentence: what all gains are relative to, or why there is no estimate
  std::vector<GainEstimate> joints;
  /// Relative covariance of the gains that are used, (n × n). Of one that stayed nominal it has what is open
  /// of it: how far the estimate is from it, 10 to 30 %; 10 % of each where there is no estimate.
  Matrix C;
  double relative_error = 0.0;  ///< ‖Y − Ŷ‖ / ‖Y‖ over all rows
  Index rows = 0;
  CovarianceReport covariance;
  std::vector<Finding> warnings;  ///< against the logs with the payload, which become those of the result

  template <typename R = GainReport>
  static constexpr auto fields() {
    return std::tuple(
        Field{"identified", &R::identified, "whether the fit settled; else all gains stay nominal"},
        Field{"scale", &R::scale,
              "one sentence: what all gains are relative to, or why there is no estimate"},
        Field{"joints", &R::joints, "one a joint, see below"},
        Field{"C",
              &R::C,
              "relative covariance of the gains that are used, which `covariance.C_chi` contains",
              {.unit = "1"}},
        Field{"relative_error", &R::relative_error, "‖Y − Ŷ‖ / ‖Y‖ of that fit", {.unit = "1"}},
        Field{"rows", &R::rows, "of that fit, logs with payload included"},
        Field{"covariance", &R::covariance, "what C was made of, members as in [`covariance`](#covariance)"});
  }
};

/// Estimates the drive gains K_j of τ_j = K_j i_j with the parameters of the arm, by Gauss-Newton on
///
///   nominal_j i_j = r_j (W_j χ + L_j λ),   K_j = nominal_j / r_j,
///
/// weighted joint by joint. The noise is in the currents, so these stand on the left. λ is a payload of known
/// mass, in the logs with one. The scale comes from that mass or from a known gain; without any, the gain of
/// one joint, the one to which the others are determined best, counts as exact. A gain that is not
/// identifiable keeps its nominal value, and the others are estimated with it.
///
/// @param without     logs of the arm alone, at least one, with control signals
/// @param with        logs with the payload; needs options.mass
/// @param estimation  signal, covariance and threads; the method is weighted least squares
/// @throws InputError  where robot, logs and options do not fit together
GainReport identify_gains(const Robot& robot, std::span<const Log> without, std::span<const Log> with,
                          const Estimation& estimation, const GainOptions& options = {});

/// The robot with the gains that were estimated: Joint::drive_gain. Estimation::gain_covariance should be
/// GainReport::C then.
///
/// @throws InputError  where there is not one gain for each joint
[[nodiscard]] Robot with_gains(Robot robot, const GainReport& gains);

}  // namespace rivid
